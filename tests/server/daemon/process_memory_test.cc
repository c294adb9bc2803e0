// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Freed memory goes back to the system.
#include "server/base/process_memory.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <memory>
#include <vector>

namespace latticed::testing {
namespace {

TEST(HeapTrimmerTest, ReturnsWhatWasFreedBelowABlockInUse) {
  constexpr size_t kBlocks = size_t{64} << 10, kBlockBytes = 4'096;  // 256 MiB
  constexpr uint64_t kMost = uint64_t{64} << 20;
  const uint64_t before = MeasureMemory().resident_bytes;
  std::vector<std::unique_ptr<char[]>> blocks;
  for (size_t i = 0; i < kBlocks; ++i) {
    blocks.push_back(std::make_unique<char[]>(kBlockBytes));  // cleared, so resident
  }
  blocks.erase(blocks.begin(),
               blocks.end() - 1);  // glibc itself returns only what is above all blocks in use
  if (mallinfo2().fordblks < kMost) GTEST_SKIP() << "a sanitizer's allocator keeps freed memory";
  ASSERT_GT(MeasureMemory().resident_bytes, before + kMost) << "glibc keeps it";

  HeapTrimmer heap;
  for (int second = 0; second < 4; ++second) heap.Tick();
  EXPECT_GT(MeasureMemory().resident_bytes, before + kMost) << "before the fifth tick";
  heap.Tick();

  EXPECT_LT(MeasureMemory().resident_bytes, before + kMost);
}

}  // namespace
}  // namespace latticed::testing
