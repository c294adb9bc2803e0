// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/process_memory.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace latticed {
namespace {

constexpr uint64_t kWorthBytes = uint64_t{64} << 20;
constexpr int kTicksPerLook = 5;

}  // namespace

ProcessMemory MeasureMemory() {
  uint64_t virtual_pages = 0, resident_pages = 0;
  std::ifstream("/proc/self/statm") >> virtual_pages >> resident_pages;
  const auto page_bytes = static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  return {.resident_bytes = resident_pages * page_bytes,
          .virtual_bytes = virtual_pages * page_bytes};
}

void HeapTrimmer::Tick() {
  if (++ticks_ % kTicksPerLook != 0) return;
  const uint64_t resident = MeasureMemory().resident_bytes;
  kept_bytes_ = std::min(kept_bytes_, resident);
  if (resident - kept_bytes_ < kWorthBytes || mallinfo2().fordblks < kWorthBytes) return;
  malloc_trim(0);
  kept_bytes_ = MeasureMemory().resident_bytes;
}

}  // namespace latticed
