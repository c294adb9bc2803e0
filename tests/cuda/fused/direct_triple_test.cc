// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/fused/direct_triple.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/limits.h"
#include "fmt/format.h"

namespace latticed::testing {
namespace {

using kernels::DirectTriple;

TEST(DirectTripleTest, ComesByEachPointOnceAndByTheMiddleThriceAtATime) {
  for (int segments = 1; segments <= limits::kMaxSegments; ++segments) {
    SCOPED_TRACE(fmt::format("{} segments", segments));
    std::vector<int> times(static_cast<size_t>(PointsPerPatch(segments)));
    DirectTriple triple(segments);
    do {
      for (int r = 0; r < 3; ++r) ++times.at(static_cast<size_t>(triple.Index(r)));
    } while (triple.Next());

    std::vector<int> expected(times.size(), 1);
    if (segments % 3 == 0) {
      expected[static_cast<size_t>(PointIndex(segments, segments / 3, segments / 3))] = 3;
    }
    EXPECT_EQ(times, expected);
  }
}

TEST(DirectTripleTest, BeginsWithTheCornersAndGoesAlongTheEdges) {
  for (int segments = 1; segments <= limits::kMaxSegments; ++segments) {
    SCOPED_TRACE(fmt::format("{} segments", segments));
    DirectTriple triple(segments);
    for (int k = 0; k < segments; ++k) {
      ASSERT_TRUE(triple.IsOnRim());
      EXPECT_EQ(triple.steps[1], k);
      for (int edge = 0; edge < 3; ++edge) {
        EXPECT_EQ(triple.Index(edge), EdgePoint(segments, edge, k));
      }
      ASSERT_EQ(triple.Next(), k + 1 < segments || segments > 2);
    }
    EXPECT_TRUE(segments <= 2 || !triple.IsOnRim());
  }
}

TEST(DirectTripleTest, StepsAreThoseOfThePattern) {
  for (int segments = 1; segments <= limits::kMaxSegments; ++segments) {
    SCOPED_TRACE(fmt::format("{} segments", segments));
    DirectTriple triple(segments);
    do {
      const auto& [a, b, c] = triple.steps;
      // By corners: row is the part of corner 2, column that of corner 1.
      EXPECT_EQ(triple.Index(0), PointIndex(segments, c, b));
      EXPECT_EQ(triple.Index(1), PointIndex(segments, b, a));
      EXPECT_EQ(triple.Index(2), PointIndex(segments, a, c));
    } while (triple.Next());
  }
}

}  // namespace
}  // namespace latticed::testing
