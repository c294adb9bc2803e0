// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/chunk_set.h"

#include <gtest/gtest.h>

#include <vector>

#include "server/engine/render/encode_snapshot.h"

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

TEST(EncodeProgress, EndsWithinTheTimeThatTheRestTakesAtThePaceSoFar) {
  const EncodeProgress quarter{
      .done = 1'000, .left = 3'000, .batch = 256, .spent = absl::Milliseconds(10)};
  EXPECT_FALSE(quarter.EndsWithin(absl::Milliseconds(29)));
  EXPECT_TRUE(quarter.EndsWithin(absl::Milliseconds(30)));

  EXPECT_FALSE((EncodeProgress{.done = 0, .left = 3'000, .batch = 256}.EndsWithin(absl::Hours(1))))
      << "no pace yet";
  EXPECT_TRUE(
      (EncodeProgress{.done = 0, .left = 256, .batch = 256}.EndsWithin(absl::ZeroDuration())))
      << "the last batch";
}

}  // namespace
}  // namespace latticed
