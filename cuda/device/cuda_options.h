// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which devices the CUDA backend uses, and how much of them.
#ifndef LATTICED_CUDA_DEVICE_CUDA_OPTIONS_H_
#define LATTICED_CUDA_DEVICE_CUDA_OPTIONS_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "core/codec/chunk_encoder.h"
#include "core/view/device_group.h"

namespace latticed {

struct CudaOptions {
  // Ordinals of the CUDA runtime. One that is named twice counts as two devices, for tests.
  std::vector<int> devices{0};
  uint64_t span_patches = kDefaultSpanPatches;  // a plan of so many takes all the devices
  uint64_t memory_bytes = 0;  // budget of each device; 0: nine tenths of what is free at the start
  int threads = 0;            // that encode on the host; 0: all that the machine or cgroup allows
  std::shared_ptr<const ChunkEncoder> encoder;  // null: the one of core/codec/draco_writer.h
  // For tests: says yes to refuse an allocation of device or pinned memory.
  std::function<bool(std::string_view purpose, uint64_t bytes)> refuse_allocation;
  // For tests: new device memory is all ones, NaN as floats.
  bool poison_memory = false;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_CUDA_OPTIONS_H_
