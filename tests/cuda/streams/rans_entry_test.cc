// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares steps of the device's states with division. Short steps: for every probability, the states
// at which the quotient changes and those before them, with all bytes that may leave before. Long steps:
// random probabilities and states.
#include "cuda/draco/rans_entry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace latticed::kernels {
namespace {

uint32_t Expected(uint32_t x, uint32_t p, uint32_t c, int precision) {
  return (x / p << precision) + x % p + c;
}

// float32 on the host. The sums are exact in double.
struct HostArithmetic {
  static float ClampedSum(float a, float b) { return std::clamp(a + b, 0.0f, 1.0f); }
  static float MultiplyAdd(float a, float b, float c) { return std::fma(a, b, c); }
  static float MultiplyAddDown(float a, float b, float c) {
    const double exact = static_cast<double>(a) * b + c;
    const auto nearest = static_cast<float>(exact);
    return nearest > exact ? std::nextafter(nearest, -1.0f) : nearest;
  }
};

// The states from which so many bytes leave that `kept` is left.
void ExpectShortSteps(uint32_t kept, uint32_t p, uint32_t c, const ShortEntry& entry) {
  for (const uint32_t bytes : {0u, 1u, 2u}) {
    const uint32_t bits = 8 * bytes, least = kept << bits;
    for (const uint32_t x : {least, least + (1u << bits) - 1}) {
      // A state is at least 4 M and below 1024 M. No byte more leaves than must.
      if (x < 4 * kShortM || x >= 1024 * kShortM || (bits > 0 && x >> (bits - 8) < 1024 * p))
        continue;
      const float state = ToState(x);
      ASSERT_EQ(StateOf(state), x);
      ASSERT_EQ((ByteLeaves(state, entry.above) ? 1u : 0u) +
                    (ByteLeaves(WithoutByte<HostArithmetic>(state), entry.above) ? 1u : 0u),
                bytes)
          << "p = " << p << ", x = " << x;
      ASSERT_EQ(StateOf(ShortStep<HostArithmetic>(state, entry)),
                Expected(kept, p, c, kLeastRansPrecision))
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
