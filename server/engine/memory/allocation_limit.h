// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Limits what one thread allocates by operator new, which the server replaces. Libraries that read files allocate tables
// that no header announces: libdraco takes 768 bytes for a byte of a table of symbols. With a limit they get
// std::bad_alloc instead, before memory is touched.
//
//   AllocationLimit limit(reserved_bytes);
//   auto mesh = ReadMesh(…);              // throws std::bad_alloc when it takes more
//   limit.Raise(more_bytes);              // in all, since the limit was made
//
// What the thread frees is given back, whoever has allocated it. Memory of std::malloc and of other threads is not
// counted, nor are aligned forms. A build with sanitizers, which replace operator new themselves, has no limits.
//
// Threads  a limit holds for the thread that made it, one at a time, and is destroyed on it
#ifndef LATTICED_SERVER_ENGINE_MEMORY_ALLOCATION_LIMIT_H_
#define LATTICED_SERVER_ENGINE_MEMORY_ALLOCATION_LIMIT_H_

#include <cstdint>

namespace latticed {

class AllocationLimit {
 public:
  explicit AllocationLimit(uint64_t bytes);
  ~AllocationLimit();
  AllocationLimit(const AllocationLimit&) = delete;
  AllocationLimit& operator=(const AllocationLimit&) = delete;

  void Raise(uint64_t bytes);

  // While one exists, the thread's limit neither holds nor counts: for work that is not the reader's.
  class Pause {
   public:
    Pause();
    ~Pause();
    Pause(const Pause&) = delete;
    Pause& operator=(const Pause&) = delete;

   private:
    const bool was_active_;
  };

 private:
  uint64_t bytes_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_MEMORY_ALLOCATION_LIMIT_H_
