// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/stage_matrices.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/ffd/box/bernstein.h"
#include "core/ffd/tessellation_pattern.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using testing::StatusIs;

TEST(StageMatrices, InverseTimesBernsteinIsIdentity) {
  for (int n = 3; n <= 10; ++n) {
    ASSERT_OK(StageMatrices::Get(n, 1));
    const StageMatrices& stage = **StageMatrices::Get(n, 1);
    const std::vector<double> inverse = InverseBernsteinMatrix(n);
    for (size_t r = 0; r < stage.m; ++r) {
      const auto& sample = stage.samples[r];
      for (size_t c = 0; c < stage.m; ++c) {
        double sum = 0;
        for (size_t k = 0; k < stage.m; ++k) {
          const auto& t = stage.samples[k];
          sum += Bernstein(t[0], t[1], t[2], sample[0] / double(n), sample[1] / double(n),
                           sample[2] / double(n)) *
                 inverse[k + c * stage.m];
        }
        EXPECT_NEAR(sum, r == c ? 1 : 0, 1e-12) << "degree " << n;
      }
    }
  }
}

TEST(StageMatrices, StackReproducesPolynomialsOfItsDegree) {
  // f = b1^a b2^(n-a), sampled at the m points, must come back at every pattern point, with its slopes.
  for (int n = 3; n <= 10; ++n) {
    for (int s : {1, 2, 10, 32}) {
      ASSERT_OK(StageMatrices::Get(n, s));
      const StageMatrices& stage = **StageMatrices::Get(n, s);
      const TessellationPattern& pattern = TessellationPattern::Get(s);
      const size_t rows = 3 * stage.q;
      ASSERT_EQ(stage.stack.size(), rows * stage.m);
      for (int a = 0; a <= n; ++a) {
        std::vector<double> got(rows, 0.0);
        for (size_t c = 0; c < stage.m; ++c) {
          const double f = Power(stage.samples[c][1] / double(n), a) *
                           Power(stage.samples[c][2] / double(n), n - a);
          for (size_t r = 0; r < rows; ++r) got[r] += double{stage.stack[r + c * rows]} * f;
        }
        for (size_t r = 0; r < stage.q; ++r) {
          const double b1 = pattern.points[r][1] / double(s), b2 = pattern.points[r][2] / double(s);
          EXPECT_NEAR(got[r], Power(b1, a) * Power(b2, n - a), 1e-6);
          const double u = a == 0 ? 0 : a * Power(b1, a - 1) * Power(b2, n - a);
          const double v = a == n ? 0 : (n - a) * Power(b1, a) * Power(b2, n - a - 1);
          EXPECT_NEAR(got[stage.q + r], u, 2e-4);  // row sums of |Bqu inv(B)| reach 4,690
          EXPECT_NEAR(got[2 * stage.q + r], v, 2e-4);
        }
      }
    }
  }
}

TEST(StageMatrices, RefusesWhatIsOutOfLimits) {
  EXPECT_THAT(StageMatrices::Get(2, 10), StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_THAT(StageMatrices::Get(11, 10), StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_THAT(StageMatrices::Get(6, 0), StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_THAT(StageMatrices::Get(6, 33), StatusIs(absl::StatusCode::kInvalidArgument));
}

}  // namespace
}  // namespace latticed
