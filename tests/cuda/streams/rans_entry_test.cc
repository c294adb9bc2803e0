// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares steps of the device's states with division. Short steps: for every probability, the states
// at which the quotient changes and those before them. Long steps: random probabilities and states.
#include "cuda/draco/rans_entry.h"

#include <gtest/gtest.h>

#include <random>

namespace latticed::kernels {
namespace {

uint32_t Expected(uint32_t x, uint32_t p, uint32_t c, int precision) {
  return (x / p << precision) + x % p + c;
}

TEST(RansEntry, ShortStepsDivideExactly) {
  for (uint32_t p = 1; p <= kShortM; ++p) {
    const uint32_t c = kShortM - p;
    const uint2 entry = MakeShortEntry(p, c);
    ASSERT_EQ(ShortProbability(entry), p);
    for (uint32_t quotient = 4; quotient <= 1024; ++quotient) {
      for (const uint32_t x : {quotient * p - 1, quotient * p}) {
        if (x < 4 * p || x >= 1024 * p) continue;
        ASSERT_EQ(ShortStep(x, entry.x, ShortShift(entry), ShortBias(entry), kShortM - p),
                  Expected(x, p, c, kLeastRansPrecision))
            << "p = " << p << ", x = " << x;
      }
    }
  }
}

TEST(RansEntry, LongStepsDivideExactly) {
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  for (int precision = kLeastRansPrecision + 1; precision <= kMostRansPrecision; ++precision) {
    for (int i = 0; i < 10'000; ++i) {
      const uint32_t p = 1 + random() % ((1u << precision) - 1), c = (1u << precision) - p;
      const uint32_t x = 4 * p + random() % (1020 * p);
      ASSERT_EQ(LongStep(x, MakeLongEntry(p, c), precision), Expected(x, p, c, precision))
          << "p = " << p << ", x = " << x << ", precision " << precision << ", seed " << kSeed;
    }
  }
}

}  // namespace
}  // namespace latticed::kernels
