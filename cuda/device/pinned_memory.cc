// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/pinned_memory.h"

#include <unistd.h>

#include <algorithm>
#include <bit>

#include "core/base/error.h"
#include "cuda/device/cuda_status.h"

namespace latticed {
namespace {

constexpr char kStagingPurpose[] = "staging";
constexpr size_t kLeastBytes = size_t{4} << 10;
// Kept for later users at most; what comes back beyond it is unpinned.
constexpr size_t kMostFreeBytes = size_t{256} << 20;

uint64_t FreeHostBytes() {
  const long pages = sysconf(_SC_AVPHYS_PAGES), size = sysconf(_SC_PAGESIZE);
  return pages > 0 && size > 0 ? static_cast<uint64_t>(pages) * static_cast<uint64_t>(size) : 0;
}

}  // namespace

PinnedBuffer::~PinnedBuffer() {
  if (data_ != nullptr) memory_->Return(data_, size_);
}

PinnedMemory::~PinnedMemory() {
  for (const auto& [size, data] : free_) static_cast<void>(cudaFreeHost(data));
}

absl::StatusOr<PinnedBuffer> PinnedMemory::Borrow(size_t bytes) {
  const size_t size = std::bit_ceil(std::max(bytes, kLeastBytes));
  if (refuse_ && refuse_(kStagingPurpose, size)) {
    return error::OutOfMemory(kStagingPurpose, size, FreeHostBytes());
  }
  {
    const std::scoped_lock lock(mutex_);
    if (const auto block = free_.find(size); block != free_.end()) {
      uint8_t* const data = block->second;
      free_.erase(block);
      free_bytes_ -= size;
      return PinnedBuffer(shared_from_this(), data, size);
    }
  }
  void* data = nullptr;
  const cudaError_t result = cudaHostAlloc(&data, size, cudaHostAllocPortable);
  if (result == cudaErrorMemoryAllocation) {
    static_cast<void>(cudaGetLastError());
    return error::OutOfMemory(kStagingPurpose, size, FreeHostBytes());
  }
  if (auto s = CudaStatus(result, kStagingPurpose); !s.ok()) return s;
  return PinnedBuffer(shared_from_this(), static_cast<uint8_t*>(data), size);
}

void PinnedMemory::Return(uint8_t* data, size_t size) {
  {
    const std::scoped_lock lock(mutex_);
    if (free_bytes_ + size <= kMostFreeBytes) {
      free_.emplace(size, data);
      free_bytes_ += size;
      return;
    }
  }
  static_cast<void>(cudaFreeHost(data));
}

}  // namespace latticed
