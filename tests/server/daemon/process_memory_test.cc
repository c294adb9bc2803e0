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

constexpr size_t kBlockBytes = 4'096;
constexpr uint64_t kMost = uint64_t{72} << 20;  // 64 MiB are not worth a trim

using Blocks = std::vector<std::unique_ptr<char[]>>;

Blocks Allocate(size_t megabytes) {
  Blocks blocks;
  for (size_t i = 0; i < (megabytes << 20) / kBlockBytes; ++i) {
    blocks.push_back(std::make_unique<char[]>(kBlockBytes));  // cleared, so resident
  }
  return blocks;
}

// Frees all but the last block: glibc itself returns only what is above all blocks in use.
void Free(Blocks& blocks) { blocks.erase(blocks.begin(), blocks.end() - 1); }

class HeapTrimmerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const Blocks blocks = Allocate(8);
    if (mallinfo2().uordblks < (8u << 20)) GTEST_SKIP() << "a sanitizer's allocator keeps memory";
    malloc_trim(0);
    rest_ = MeasureMemory().resident_bytes;
  }

  void Pass(int seconds) {
    for (int second = 0; second < seconds; ++second) heap_.Tick();
  }

  uint64_t rest_ = 0;
  HeapTrimmer heap_;
};

TEST_F(HeapTrimmerTest, ReturnsWhatWasFreedBelowABlockInUse) {
  Blocks blocks = Allocate(256);
  Free(blocks);
  ASSERT_GT(MeasureMemory().resident_bytes, rest_ + kMost) << "glibc keeps it";

  Pass(4);
  EXPECT_GT(MeasureMemory().resident_bytes, rest_ + kMost) << "before the fifth tick";
  Pass(1);

  EXPECT_LT(MeasureMemory().resident_bytes, rest_ + kMost);
}

// A trim under load leaves what is in use at that moment, which is freed later.
TEST_F(HeapTrimmerTest, ReturnsAPeakThatEndsInSteps) {
  std::vector<Blocks> steps;
  for (int step = 0; step < 5; ++step) {
    steps.push_back(Allocate(120));
    if (step == 3) Free(steps[0]);
    Pass(3);
  }
  for (Blocks& step : steps) {
    if (step.size() > 1) Free(step);
    Pass(2);
  }
  Pass(5);

  EXPECT_LT(MeasureMemory().resident_bytes, rest_ + kMost);
}

// No look sees these blocks in use: they come and go in between.
TEST_F(HeapTrimmerTest, ReturnsWhatWasUsedAgainBetweenTwoLooks) {
  Blocks first = Allocate(256);
  Free(first);
  Pass(5);
  ASSERT_LT(MeasureMemory().resident_bytes, rest_ + kMost);

  Pass(2);
  Blocks second = Allocate(200);
  Free(second);
  Pass(3);

  EXPECT_LT(MeasureMemory().resident_bytes, rest_ + kMost);
}

}  // namespace
}  // namespace latticed::testing
