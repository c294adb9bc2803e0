// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The CUDA backend, by the same pipelines and with the same results as the CPU's
// (core/cpu/cpu_backend.h). A build without CUDA compiles cuda_backend_stub.cc instead and answers
// kUnimplemented.
#ifndef LATTICED_CUDA_CUDA_BACKEND_H_
#define LATTICED_CUDA_CUDA_BACKEND_H_

#include <memory>

#include "absl/status/statusor.h"
#include "core/backend.h"
#include "core/codec/chunk_encoder.h"

namespace latticed {

struct CudaOptions {
  int device = 0;                               // ordinal of the CUDA runtime
  std::shared_ptr<const ChunkEncoder> encoder;  // null: the reference encoder
};

// kUnimplemented in a build without CUDA; kUnavailable without a usable device or driver.
[[nodiscard]] absl::StatusOr<std::unique_ptr<Backend>> MakeCudaBackend(const CudaOptions& options);

}  // namespace latticed

#endif  // LATTICED_CUDA_CUDA_BACKEND_H_
