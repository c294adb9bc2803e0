// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/rising.h"

#include <numeric>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace latticed {
namespace {

std::vector<uint32_t> UpTo(size_t count) {
  std::vector<uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0u);
  return numbers;
}

// Every place of a list that is longer than a few vectors of the widest unit.
constexpr size_t kCount = 100;

TEST(Rising, AllNumbersAndSomeOfThem) {
  for (size_t count = 0; count <= kCount; ++count) EXPECT_TRUE(Rise(UpTo(count))) << count;
  EXPECT_TRUE(Rise(std::vector<uint32_t>{3, 70, 71, 0x7fff'ffff}));
}

TEST(Rising, OneTwiceIsSeenAtEveryPlace) {
  for (size_t at = 1; at < kCount; ++at) {
    std::vector<uint32_t> numbers = UpTo(kCount);
    numbers[at] = numbers[at - 1];
    EXPECT_FALSE(Rise(numbers)) << at;
  }
}

TEST(Rising, OneThatFallsIsSeenAtEveryPlace) {
  for (size_t at = 1; at < kCount; ++at) {
    std::vector<uint32_t> numbers = UpTo(kCount);
    numbers[at - 1] = 1'000;
    EXPECT_FALSE(Rise(numbers)) << at;
  }
}

TEST(Rising, NumbersBelowAreAllOfThemAndStay) {
  const auto some = NumbersBelow(5);
  EXPECT_THAT(some, testing::ElementsAre(0u, 1u, 2u, 3u, 4u));
  const auto many = NumbersBelow(1'000);
  EXPECT_EQ(many.size(), 1'000u);
  EXPECT_EQ(many.back(), 999u);
  EXPECT_EQ(NumbersBelow(6).data(), some.data());
  EXPECT_TRUE(Rise(some));
  EXPECT_TRUE(Rise(many.first(7)));
  EXPECT_TRUE(Rise(NumbersBelow(0)));
}

// Steps of less than 2^31 that come round to where they began.
TEST(Rising, NumbersFrom2To31OnAreSeenAtEveryPlace) {
  EXPECT_FALSE(Rise(std::vector<uint32_t>{0x8000'0000}));
  EXPECT_FALSE(Rise(std::vector<uint32_t>{5, 0x8000'0004, 3, 4}));
  for (size_t at = 0; at < kCount; ++at) {
    std::vector<uint32_t> numbers = UpTo(kCount);
    numbers[at] |= 0x8000'0000;
    EXPECT_FALSE(Rise(numbers)) << at;
  }
}

}  // namespace
}  // namespace latticed
