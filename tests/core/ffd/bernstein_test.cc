// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/box/bernstein.h"

#include <gtest/gtest.h>

namespace latticed {
namespace {

TEST(Bernstein, ByHand) {
  EXPECT_DOUBLE_EQ(Bernstein(2, 1, 0, 0.5, 0.25, 0.25), 3 * 0.25 * 0.25);
  EXPECT_DOUBLE_EQ(Bernstein(1, 1, 1, 0.5, 0.25, 0.25), 6 * 0.5 * 0.25 * 0.25);
  EXPECT_DOUBLE_EQ(Bernstein(0, 0, 9, 0.0, 0.0, 1.0), 1.0);
  EXPECT_DOUBLE_EQ(Bernstein(3, 3, 3, 1.0, 1.0, 1.0), 1680.0);  // 9! / 6^3
  EXPECT_DOUBLE_EQ(Bernstein(-1, 1, 0, 0.5, 0.25, 0.25), 0.0);
}

TEST(Bernstein, OrderIsThatOfFormula3) {
  for (int n = 3; n <= 9; ++n) {
    int expected = 0;
    for (int i = n; i >= 0; --i) {
      for (int j = n - i; j >= 0; --j) EXPECT_EQ(BernsteinIndex(n, i, n - i - j), expected++);
    }
    EXPECT_EQ(expected, BernsteinCount(n));
  }
}

TEST(Bernstein, SumsToOneAndDerivativesMatchDifferences) {
  constexpr double kB1 = 0.3, kB2 = 0.45, kStep = 1e-6;
  for (int n = 3; n <= 9; ++n) {
    double sum = 0, sum_u = 0, sum_v = 0;
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n - i; ++j) {
        const int k = n - i - j;
        const auto at = [&](double b1, double b2) {
          return Bernstein(i, j, k, 1 - b1 - b2, b1, b2);
        };
        const double u = BernsteinU(i, j, k, 1 - kB1 - kB2, kB1, kB2);
        const double v = BernsteinV(i, j, k, 1 - kB1 - kB2, kB1, kB2);
        sum += at(kB1, kB2);
        sum_u += u;
        sum_v += v;
        EXPECT_NEAR(u, (at(kB1 + kStep, kB2) - at(kB1 - kStep, kB2)) / (2 * kStep), 1e-8);
        EXPECT_NEAR(v, (at(kB1, kB2 + kStep) - at(kB1, kB2 - kStep)) / (2 * kStep), 1e-8);
      }
    }
    EXPECT_NEAR(sum, 1, 1e-14);
    EXPECT_NEAR(sum_u, 0, 1e-13);
    EXPECT_NEAR(sum_v, 0, 1e-13);
  }
}

}  // namespace
}  // namespace latticed
