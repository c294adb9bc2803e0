// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/plan/adjacency_index.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace latticed {
namespace {

// Vertex 0 has far more keys than a list holds.
TEST(AdjacencyIndex, AnswersAsAMapDoes) {
  constexpr uint32_t kSeed = 5;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  AdjacencyIndex index;
  index.Reserve(8, 100);
  std::map<std::pair<uint32_t, uint64_t>, uint32_t> expected;
  for (uint32_t number = 0; number < 20'000; ++number) {
    const uint32_t vertex = random() % 4 == 0 ? random() % 100 : 0;
    const uint64_t key = random() % 3'000;
    const auto [it, added] = expected.try_emplace({vertex, key}, number);
    ASSERT_EQ(index.TryEmplace(vertex, key, number), std::pair(it->second, added));
  }
}

TEST(AdjacencyIndex, AListHasItsFirstKeysAlone) {
  constexpr uint32_t kInList = 32;
  AdjacencyIndex index;
  index.Reserve(3, 64);
  for (uint32_t key = 0; key < 40; ++key) {
    EXPECT_EQ(index.TryEmplaceInList(2, key, 100 + key), std::pair(100 + key, true));
  }
  for (uint32_t key = 0; key < 40; ++key) {
    const bool held = key < kInList;
    EXPECT_EQ(index.TryEmplaceInList(2, key, 200 + key),
              std::pair((held ? 100 : 200) + key, !held));
  }
}

}  // namespace
}  // namespace latticed
