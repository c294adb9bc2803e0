// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The memory of this process, and how freed memory goes back to the system.
#ifndef LATTICED_SERVER_BASE_PROCESS_MEMORY_H_
#define LATTICED_SERVER_BASE_PROCESS_MEMORY_H_

#include <cstdint>

namespace latticed {

struct ProcessMemory {
  uint64_t resident_bytes = 0;
  uint64_t virtual_bytes = 0;
};
// By /proc/self/statm. Threads  safe
[[nodiscard]] ProcessMemory MeasureMemory();

// Lets glibc return what is free at the end of a thread's heap, from 16 MiB on; by itself it keeps up to 64 MiB of each.
// Called once, before the server starts.
void LimitFreeHeapEnds();

// glibc keeps freed memory for later allocations, so without this a server would stay as large as its largest moment.
// Of threads' heaps it returns what is free between blocks; LimitFreeHeapEnds cares for their ends.
//
// Threads  one at a time
class HeapTrimmer {
 public:
  // Returns free pages to the system, if that may be 64 MiB or more: if resident bytes that are not in use have grown
  // by as much since the last trim. Called once a second; looks every fifth time, since a look takes the heap's locks.
  void Tick();

 private:
  int ticks_ = 0;
  int64_t floor_bytes_ = 0;  // unused resident bytes after the last trim, or fewer
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_PROCESS_MEMORY_H_
