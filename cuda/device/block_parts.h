// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lays out the parts of a block of device memory, one after the other. Each begins at a multiple of 256 bytes.
//
// Threads  plain data
#ifndef LATTICED_CUDA_DEVICE_BLOCK_PARTS_H_
#define LATTICED_CUDA_DEVICE_BLOCK_PARTS_H_

#include <cstddef>

namespace latticed {

class BlockParts {
 public:
  static constexpr size_t kAlignment = 256;

  // Returns where the part begins.
  size_t Add(size_t bytes) {
    const size_t begin = end_;
    end_ += (bytes + kAlignment - 1) / kAlignment * kAlignment;
    return begin;
  }
  size_t end() const { return end_; }

 private:
  size_t end_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_BLOCK_PARTS_H_
