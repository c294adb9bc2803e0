// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The CUDA backend, by the same pipelines and with the same results as the CPU's
// (core/cpu/cpu_backend.h). A build without CUDA compiles cuda_backend_stub.cc instead and answers
// kUnimplemented. Pipeline fused is not there yet: Prepare answers kUnimplemented for it.
#ifndef LATTICED_CUDA_CUDA_BACKEND_H_
#define LATTICED_CUDA_CUDA_BACKEND_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/backend.h"
#include "core/codec/chunk_encoder.h"

namespace latticed {

struct CudaOptions {
  std::vector<int> devices{0};  // ordinals of the CUDA runtime; each plan goes to the freest
  uint64_t memory_bytes = 0;  // budget of each device; 0: nine tenths of what is free at the start
  int threads = 0;            // that encode on the host; 0: all that the machine or cgroup allows
  std::shared_ptr<const ChunkEncoder> encoder;  // null: the reference encoder
  // For tests: says yes to refuse an allocation of device or pinned memory.
  std::function<bool(std::string_view purpose, uint64_t bytes)> refuse_allocation;
  // For tests: new device memory is all ones, NaN as floats.
  bool poison_memory = false;
};

// kUnimplemented in a build without CUDA; kUnavailable without a usable device or driver.
[[nodiscard]] absl::StatusOr<std::unique_ptr<Backend>> MakeCudaBackend(const CudaOptions& options);

}  // namespace latticed

#endif  // LATTICED_CUDA_CUDA_BACKEND_H_
