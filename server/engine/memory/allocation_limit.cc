// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/memory/allocation_limit.h"

#include <malloc.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <new>
#include <utility>

namespace latticed {
namespace {

struct Meter {
  bool active = false;
  int64_t free_bytes = 0;  // negative by the ends of blocks, which malloc rounds up
};
constinit thread_local Meter meter;

}  // namespace

AllocationLimit::AllocationLimit(uint64_t bytes) : bytes_(bytes) {
  meter = {true, static_cast<int64_t>(bytes)};
}

AllocationLimit::~AllocationLimit() { meter = {}; }

void AllocationLimit::Raise(uint64_t bytes) {
  const uint64_t before = std::exchange(bytes_, std::max(bytes_, bytes));
  meter.free_bytes += static_cast<int64_t>(bytes_ - before);
}

AllocationLimit::Pause::Pause() : was_active_(std::exchange(meter.active, false)) {}

AllocationLimit::Pause::~Pause() { meter.active = was_active_; }

}  // namespace latticed

#ifdef LATTICED_REPLACE_NEW
namespace latticed {
namespace {

void* Allocate(size_t bytes) {
  if (meter.active && meter.free_bytes < static_cast<int64_t>(bytes)) throw std::bad_alloc();
  void* const memory = std::malloc(std::max<size_t>(bytes, 1));
  if (memory == nullptr) throw std::bad_alloc();
  if (meter.active) meter.free_bytes -= static_cast<int64_t>(malloc_usable_size(memory));
  return memory;
}

void Free(void* memory) noexcept {
  if (meter.active) meter.free_bytes += static_cast<int64_t>(malloc_usable_size(memory));
  std::free(memory);
}

}  // namespace
}  // namespace latticed

// The library's other forms call these, except the aligned ones. They are weak because programs of tests replace them too.
[[gnu::weak]] void* operator new(size_t bytes) { return latticed::Allocate(bytes); }
[[gnu::weak]] void operator delete(void* memory) noexcept { latticed::Free(memory); }
[[gnu::weak]] void operator delete(void* memory, size_t) noexcept { latticed::Free(memory); }
#endif  // LATTICED_REPLACE_NEW
