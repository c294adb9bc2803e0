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
  // Ordinals of the CUDA runtime. For tests, an ordinal may be repeated and then counts as several devices.
  std::vector<int> devices{0};
  uint64_t span_patches = kDefaultSpanPatches;  // plans of so many or more span all devices
  uint64_t memory_bytes = 0;  // budget of each device; 0: nine tenths of what is free at the start
  int threads = 0;            // for encoding on the host; 0: all that the machine or cgroup allows
  std::shared_ptr<const ChunkEncoder> encoder;  // null: core/codec/draco_writer.h
  // For tests: returns true to refuse an allocation of device or pinned memory.
  std::function<bool(std::string_view purpose, uint64_t bytes)> refuse_allocation;
  // For tests: sets all bits of new device memory, which makes floats NaN.
  bool poison_memory = false;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_CUDA_OPTIONS_H_
