// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/cpu_arena.h"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

namespace latticed {
namespace {

TEST(CpuArena, EveryItemIsVisitedOnceWhicheverThreadsDo) {
  for (const int threads : {1, 4, 192}) {
    CpuArena arena(threads);
    for (const size_t count : {0u, 1u, 33u, 64u, 65u, 1'000u}) {
      for (const size_t grain : {1u, 7u, 2'000u}) {
        std::vector<std::atomic<int>> visits(count);
        arena.ForRanges(count, grain, [&](size_t begin, size_t end) {
          for (size_t i = begin; i < end; ++i) ++visits[i];
        });
        for (const std::atomic<int>& visit : visits) ASSERT_EQ(visit, 1) << threads << ' ' << count;
      }
    }
  }
}

// A body may run a loop of the other kind.
TEST(CpuArena, LoopsWithinLoopsEnd) {
  CpuArena arena(64);
  std::atomic<int> visits = 0;
  arena.ForEach(100, [&](size_t) { arena.ForEach(10, [&](size_t) { ++visits; }); });
  EXPECT_EQ(visits, 1'000);
}

}  // namespace
}  // namespace latticed
