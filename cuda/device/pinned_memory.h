// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Pinned host memory, which the device reads and writes by itself. Returned blocks are kept for the
// next user, because the driver blocks all launches while it pins or unpins memory.
//
// A PinnedBuffer must outlive every copy from or to it.
//
// Errors   kResourceExhausted with asked and free bytes
// Threads  PinnedMemory is safe; a PinnedBuffer is used by one thread at a time
#ifndef LATTICED_CUDA_DEVICE_PINNED_MEMORY_H_
#define LATTICED_CUDA_DEVICE_PINNED_MEMORY_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>

#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "cuda/device/device_memory.h"

namespace latticed {

class PinnedMemory;

struct PinnedDeleter {
  std::shared_ptr<PinnedMemory> memory;
  size_t size = 0;
  void operator()(uint8_t* data) const;
};

class PinnedBuffer {
 public:
  PinnedBuffer() = default;
  uint8_t* data() const { return data_.get(); }
  size_t size() const { return data_.get_deleter().size; }

 private:
  friend class PinnedMemory;
  PinnedBuffer(std::shared_ptr<PinnedMemory> memory, uint8_t* data, size_t size)
      : data_(data, PinnedDeleter{std::move(memory), size}) {}

  std::unique_ptr<uint8_t, PinnedDeleter> data_;
};

class PinnedMemory : public std::enable_shared_from_this<PinnedMemory> {
 public:
  explicit PinnedMemory(RefuseAllocation refuse) : refuse_(std::move(refuse)) {}
  ~PinnedMemory();
  PinnedMemory(const PinnedMemory&) = delete;  // owns the blocks
  PinnedMemory& operator=(const PinnedMemory&) = delete;

  // Returns a block of `bytes`, rounded up to a power of two and at least a page, so that updates
  // of all sizes can reuse blocks. Pins memory only where no block of this size is free.
  [[nodiscard]] absl::StatusOr<PinnedBuffer> Borrow(size_t bytes);
  // The size of the block that Borrow returns.
  static size_t BlockBytes(size_t bytes);
  // The bytes of all blocks that are not returned yet.
  uint64_t lent_bytes() const;

 private:
  friend struct PinnedDeleter;
  void Return(uint8_t* data, size_t size);

  RefuseAllocation refuse_;
  mutable Mutex mutex_;
  std::multimap<size_t, uint8_t*> free_ ABSL_GUARDED_BY(mutex_);  // by size
  size_t free_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t lent_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_PINNED_MEMORY_H_
