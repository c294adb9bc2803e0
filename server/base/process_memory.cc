// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/process_memory.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace latticed {
namespace {

constexpr int64_t kWorthBytes = int64_t{64} << 20;
constexpr int kTicksPerLook = 5;
// With 4 MiB an edit of 110,000 patches takes 7 % longer, on two cores.
constexpr int kFreeEndBytes = 16 << 20;
// What glibc comes to by itself: smaller blocks use the same pages again.
constexpr int kMmapBytes = 32 << 20;

// Resident bytes that malloc has not given out: freed blocks, code and stacks. Below zero if blocks that were given out
// have not been touched.
int64_t UnusedBytes(const struct mallinfo2& heap) {
  return static_cast<int64_t>(MeasureMemory().resident_bytes) -
         static_cast<int64_t>(heap.uordblks + heap.hblkhd);
}

}  // namespace

ProcessMemory MeasureMemory() {
  uint64_t virtual_pages = 0, resident_pages = 0;
  std::ifstream("/proc/self/statm") >> virtual_pages >> resident_pages;
  const auto page_bytes = static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  return {.resident_bytes = resident_pages * page_bytes,
          .virtual_bytes = virtual_pages * page_bytes};
}

void LimitFreeHeapEnds() {
  mallopt(M_TRIM_THRESHOLD, kFreeEndBytes);
  mallopt(M_MMAP_THRESHOLD, kMmapBytes);  // else it would stay at 128 KiB from now on
}

void HeapTrimmer::Tick() {
  if (++ticks_ % kTicksPerLook != 0) return;
  const struct mallinfo2 heap = mallinfo2();
  const int64_t unused = UnusedBytes(heap);
  floor_bytes_ = std::min(floor_bytes_, unused);
  if (unused - floor_bytes_ < kWorthBytes || heap.fordblks < size_t{kWorthBytes}) return;
  malloc_trim(0);
  floor_bytes_ = UnusedBytes(mallinfo2());
}

}  // namespace latticed
