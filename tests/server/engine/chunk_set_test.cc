// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/chunk_set.h"

#include <gtest/gtest.h>

#include <vector>

namespace latticed {
namespace {

using Chunks = std::vector<uint32_t>;

TEST(ChunkSet, TakesWhatWasAddedOnce) {
  ChunkSet set;
  set.Add(Chunks{5, 1});
  set.Add(Chunks{1, 3});

  EXPECT_FALSE(set.all());
  EXPECT_EQ(set.Take(6), (Chunks{1, 3, 5}));
  EXPECT_TRUE(set.Take(6).empty());
}

TEST(ChunkSet, AllAreThoseOfThePlanThatTakesThem) {
  ChunkSet set = ChunkSet::All();
  set.Add(Chunks{7});

  EXPECT_TRUE(set.all());
  EXPECT_EQ(set.Take(3), (Chunks{0, 1, 2}));
  EXPECT_FALSE(set.all());
  EXPECT_TRUE(set.Take(3).empty());
}

TEST(ChunkSet, ForgetsWhatASmallerPlanDoesNotHave) {
  ChunkSet set;
  set.Add(Chunks{2, 9});

  EXPECT_EQ(set.Take(4), (Chunks{2}));
  EXPECT_TRUE(set.Take(20).empty());
}

}  // namespace
}  // namespace latticed
