// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares steps of the device's states with division. Short steps: for every probability, the states
// at which the quotient changes and those before them, with all bytes that may leave before. Long steps:
// random probabilities and states.
#include "cuda/draco/rans_entry.h"

#include <gtest/gtest.h>

#include <random>

namespace latticed::kernels {
namespace {

uint32_t Expected(uint32_t x, uint32_t p, uint32_t c, int precision) {
  return (x / p << precision) + x % p + c;
}

// The states from which so many bits leave that `kept` is left.
void ExpectShortSteps(uint32_t kept, uint32_t p, uint32_t c, const ShortEntry& entry) {
  for (const uint32_t bits : {0u, 8u, 16u}) {
    const uint32_t least = kept << bits;
    for (const uint32_t x : {least, least + (1u << bits) - 1}) {
      // A state is at least 4 M and below 1024 M. No byte more leaves than must.
      if (x < 4 * kShortM || x >= 1024 * kShortM || (bits > 0 && x >> (bits - 8) < 1024 * p))
        continue;
      ASSERT_EQ(LeavingBits(x, entry), bits) << "p = " << p << ", x = " << x;
      ASSERT_EQ(ShortStep(x, bits, entry), Expected(kept, p, c, kLeastRansPrecision))
          << "p = " << p << ", x = " << x;
    }
  }
}

TEST(RansEntry, ShortStepsDivideExactly) {
  for (uint32_t p = 1; p <= kShortM; ++p) {
    const uint32_t c = kShortM - p;
    const ShortEntry entry = TakeApart(MakeShortEntry(p, c));
    ASSERT_EQ(entry.rest, kShortM - p);
    for (uint32_t quotient = 4; quotient <= 1024; ++quotient) {
      for (const uint32_t kept : {quotient * p - 1, quotient * p}) {
        if (kept < 4 * p || kept >= 1024 * p) continue;
        ASSERT_NO_FATAL_FAILURE(ExpectShortSteps(kept, p, c, entry));
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
