// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The CUDA backend. It has the same pipelines and results as the CPU backend
// (core/cpu/cpu_backend.h), on one device or several (core/view/device_group.h). A build without
// CUDA compiles cuda_backend_stub.cc instead, which answers kUnimplemented.
#ifndef LATTICED_CUDA_CUDA_BACKEND_H_
#define LATTICED_CUDA_CUDA_BACKEND_H_

#include <memory>

#include "absl/status/statusor.h"
#include "core/backend.h"
#include "cuda/device/cuda_options.h"

namespace latticed {

// kUnimplemented in a build without CUDA; kUnavailable without a usable device or driver.
[[nodiscard]] absl::StatusOr<std::unique_ptr<Backend>> MakeCudaBackend(const CudaOptions& options);

}  // namespace latticed

#endif  // LATTICED_CUDA_CUDA_BACKEND_H_
