// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/sorted_numbers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace latticed {
namespace {

// Longer than a few vectors of the widest instruction set.
constexpr size_t kCount = 100;

TEST(SortedNumbers, OneThatDoesNotRiseIsSeenAtEveryPlace) {
  std::vector<uint32_t> numbers(kCount);
  std::iota(numbers.begin(), numbers.end(), 0xffff'ff00u);
  for (size_t at = 1; at < kCount; ++at) {
    EXPECT_TRUE(IsStrictlySorted(numbers));
    for (const uint32_t wrong : {numbers[at - 1], numbers[at - 1] - 1, 0u}) {
      std::vector<uint32_t> bad = numbers;
      bad[at] = wrong;
      EXPECT_FALSE(IsStrictlySorted(bad)) << at;
    }
  }
  EXPECT_TRUE(IsStrictlySorted({}));
}

TEST(SortedNumbers, NumbersBelowAreAllOfThemAndStay) {
  const auto some = NumbersBelow(5);
  const auto many = NumbersBelow(1'000);

  EXPECT_THAT(some, ::testing::ElementsAre(0u, 1u, 2u, 3u, 4u));
  EXPECT_EQ(many.back(), 999u);
  EXPECT_EQ(NumbersBelow(6).data(), some.data());
  EXPECT_TRUE(IsStrictlySorted(some));
  EXPECT_TRUE(IsStrictlySorted(many.first(7)));
}

}  // namespace
}  // namespace latticed
