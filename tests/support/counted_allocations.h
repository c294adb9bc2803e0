// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Counts all allocations of a program by replacing operator new. One source file of the program includes this.
//
//   const PeakMemory memory;
//   …
//   memory.peak()   // the most bytes at a time since then, above those before
//
// Threads  counts are exact; a peak of several threads may miss what falls between two of their steps
#ifndef LATTICED_TESTS_SUPPORT_COUNTED_ALLOCATIONS_H_
#define LATTICED_TESTS_SUPPORT_COUNTED_ALLOCATIONS_H_

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace {
std::atomic<size_t> allocated_bytes = 0, peak_bytes = 0;

void* Allocate(size_t bytes) {
  void* memory = std::malloc(bytes);
  if (memory == nullptr) throw std::bad_alloc();
  const size_t now = allocated_bytes += malloc_usable_size(memory);
  peak_bytes = std::max(peak_bytes.load(), now);
  return memory;
}
void Free(void* memory) {
  if (memory != nullptr) allocated_bytes -= malloc_usable_size(memory);
  std::free(memory);
}
}  // namespace

void* operator new(size_t bytes) { return Allocate(bytes); }
void* operator new[](size_t bytes) { return Allocate(bytes); }
void* operator new(size_t bytes, const std::nothrow_t&) noexcept { return Allocate(bytes); }
void* operator new[](size_t bytes, const std::nothrow_t&) noexcept { return Allocate(bytes); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { Free(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { Free(memory); }
void operator delete(void* memory) noexcept { Free(memory); }
void operator delete[](void* memory) noexcept { Free(memory); }
void operator delete(void* memory, size_t) noexcept { Free(memory); }
void operator delete[](void* memory, size_t) noexcept { Free(memory); }

namespace latticed::testing {

class PeakMemory {
 public:
  PeakMemory() : before_(allocated_bytes) { peak_bytes = before_; }
  size_t peak() const { return peak_bytes - before_; }

 private:
  const size_t before_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SUPPORT_COUNTED_ALLOCATIONS_H_
