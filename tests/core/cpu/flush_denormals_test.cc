// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/flush_denormals.h"

#include <gtest/gtest.h>

#include <limits>

namespace latticed {
namespace {

// Halves the smallest normal number at run time.
float HalfOfSmallest() {
  volatile float smallest = std::numeric_limits<float>::min();
  return smallest / 2;
}

TEST(FlushDenormals, EndsWithItsScope) {
  ASSERT_GT(HalfOfSmallest(), 0.0f);
  {
    const FlushDenormals flush;
#if defined(__x86_64__)
    EXPECT_EQ(HalfOfSmallest(), 0.0f);
#endif
    { const FlushDenormals again; }
#if defined(__x86_64__)
    EXPECT_EQ(HalfOfSmallest(), 0.0f) << "the outer one still holds";
#endif
  }
  EXPECT_GT(HalfOfSmallest(), 0.0f);
}

}  // namespace
}  // namespace latticed
