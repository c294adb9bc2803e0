// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Host memory that the device copies from and to by itself. Blocks are kept for the next user:
// nothing is launched on any stream while one is pinned or unpinned.
//
// A PinnedBuffer may go back only when no copy uses it any more.
//
// Errors   kResourceExhausted with asked and free bytes
// Threads  PinnedMemory is safe; a PinnedBuffer is used by one thread at a time
#ifndef LATTICED_CUDA_DEVICE_PINNED_MEMORY_H_
#define LATTICED_CUDA_DEVICE_PINNED_MEMORY_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <utility>

#include "absl/status/statusor.h"
#include "cuda/device/device_memory.h"

namespace latticed {

class PinnedMemory;

class PinnedBuffer {
 public:
  PinnedBuffer() = default;
  ~PinnedBuffer();
  PinnedBuffer(const PinnedBuffer&) = delete;  // one owner
  PinnedBuffer& operator=(const PinnedBuffer&) = delete;
  PinnedBuffer(PinnedBuffer&& other) noexcept
      : memory_(std::move(other.memory_)),
        data_(std::exchange(other.data_, nullptr)),
        size_(std::exchange(other.size_, 0)) {}
  PinnedBuffer& operator=(PinnedBuffer&& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }

  uint8_t* data() const { return data_; }
  size_t size() const { return size_; }
  std::span<uint8_t> span() const { return {data_, size_}; }

 private:
  friend class PinnedMemory;
  PinnedBuffer(std::shared_ptr<PinnedMemory> memory, uint8_t* data, size_t size)
      : memory_(std::move(memory)), data_(data), size_(size) {}

  std::shared_ptr<PinnedMemory> memory_;
  uint8_t* data_ = nullptr;
  size_t size_ = 0;
};

class PinnedMemory : public std::enable_shared_from_this<PinnedMemory> {
 public:
  explicit PinnedMemory(RefuseAllocation refuse) : refuse_(std::move(refuse)) {}
  ~PinnedMemory();
  PinnedMemory(const PinnedMemory&) = delete;  // owns the blocks
  PinnedMemory& operator=(const PinnedMemory&) = delete;

  // At least `bytes`: the next power of two, so that updates of all sizes find a block that served
  // another. Pins only where none is left.
  [[nodiscard]] absl::StatusOr<PinnedBuffer> Borrow(size_t bytes);
  // Of the blocks that are not back yet.
  uint64_t lent_bytes() const;

 private:
  friend class PinnedBuffer;
  void Return(uint8_t* data, size_t size);

  RefuseAllocation refuse_;
  mutable std::mutex mutex_;
  std::multimap<size_t, uint8_t*> free_;  // by size; these three guarded by mutex_
  size_t free_bytes_ = 0;
  uint64_t lent_bytes_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_PINNED_MEMORY_H_
