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

}  // namespace
}  // namespace latticed::testing
