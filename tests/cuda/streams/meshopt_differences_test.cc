// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares differences in words with the same operations, one number at a time.
#include "cuda/meshopt/meshopt_differences.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <type_traits>

namespace latticed::kernels {
namespace {

constexpr unsigned kDifferencesSeed = 20'261'128;
constexpr int kDifferenceRuns = 20'000;

// Numbers of bits 0 … 15, all equally often, or a corner of the 16-bit numbers.
uint16_t AnyNumber(std::mt19937& random) {
  constexpr std::array<uint16_t, 6> kCorners{0, 0x7f, 0x80, 0xff, 0x7fff, 0x8000};
  const auto number = static_cast<uint32_t>(random());
  return static_cast<uint16_t>(number % 5 == 0 ? kCorners[number / 5 % kCorners.size()]
                                               : number >> 16 >> number % 16);
}

template <class T>
T Zigzag(T to, T from) {
  const auto difference = static_cast<std::make_signed_t<T>>(static_cast<T>(to - from));
  return static_cast<T>(difference < 0 ? -2 * difference - 1 : 2 * difference);
}

TEST(MeshoptDifferences, AreThoseOfEachNumber) {
  std::mt19937 random(kDifferencesSeed);
  for (int run = 0; run < kDifferenceRuns; ++run) {
    const uint32_t to = AnyNumber(random) | uint32_t{AnyNumber(random)} << 16;
    const uint32_t from = AnyNumber(random) | uint32_t{AnyNumber(random)} << 16;
    uint32_t shorts = 0, bytes = 0;
    for (unsigned at = 0; at < 32; at += 16) {
      shorts |= uint32_t{Zigzag(static_cast<uint16_t>(to >> at), static_cast<uint16_t>(from >> at))}
                << at;
    }
    for (unsigned at = 0; at < 32; at += 8) {
      bytes |= uint32_t{Zigzag(static_cast<uint8_t>(to >> at), static_cast<uint8_t>(from >> at))}
               << at;
    }
    ASSERT_EQ(ZigzagDifferences<16>(to, from), shorts) << to << " after " << from;
    ASSERT_EQ(ZigzagDifferences<8>(to, from), bytes) << to << " after " << from;
  }
}

TEST(MeshoptDifferences, CodesOfFewBitsAreThoseOfTheFormat) {
  std::mt19937 random(kDifferencesSeed);
  for (int run = 0; run < kDifferenceRuns; ++run) {
    std::array<uint32_t, 8> bytes;
    EightBytes eight{};
    for (uint32_t k = 0; k < 8; ++k) {
      bytes[k] = (static_cast<uint32_t>(random()) & 0xff) >> random() % 8;
      (k < 4 ? eight.lower : eight.upper) |= bytes[k] << (8 * (k % 4));
    }
    uint32_t ones = 0, twos = 0, fours = 0, of_1 = 0, of_2 = 0, of_4 = 0;
    for (uint32_t k = 0; k < 8; ++k) {
      ones |= std::min(bytes[k], 1u) << k;
      twos |= std::min(bytes[k], 3u) << (6 - k % 4 * 2 + k / 4 * 8);
      fours |= std::min(bytes[k], 15u) << (4 - k % 2 * 4 + k / 2 * 8);
      of_1 |= bytes[k] >= 1 ? MarkOf(k) : 0;
      of_2 |= bytes[k] >= 3 ? MarkOf(k) : 0;
      of_4 |= bytes[k] >= 15 ? MarkOf(k) : 0;
    }
    ASSERT_EQ(MarkFrom(eight, 1), of_1);
    ASSERT_EQ(MarkFrom(eight, 3), of_2);
    ASSERT_EQ(MarkFrom(eight, 15), of_4);
    ASSERT_EQ(OneBitEach(of_1), ones);
    ASSERT_EQ(TwoBitsEach(eight, of_2), twos);
    ASSERT_EQ(FourBitsEach(eight, of_4), fours);
  }
}

}  // namespace
}  // namespace latticed::kernels
