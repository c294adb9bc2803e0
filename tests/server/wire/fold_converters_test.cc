// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/fold_converters.h"

#include <gtest/gtest.h>

#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

TEST(FoldConverters, FoldedBoxesComeFirstAndNoMoreThanAsked) {
  FoldReport report{.boxes = 900};
  for (uint32_t box = 0; box < 600; ++box) {
    report.places.push_back({.box = box,
                             .place = {static_cast<int>(box), 1, 2},
                             .state = box % 2 == 0 ? FoldState::kUndecided : FoldState::kFolded,
                             .rest_point = {1, 2, 3},
                             .determinant = -0.25});
  }

  const v1::FoldReport all = ToProto(report, 7, 3, kMostPlaces);
  const v1::FoldReport few = ToProto(report, 7, 3, kMostEditPlaces);

  EXPECT_EQ(all.revision(), 7u);
  EXPECT_EQ(all.structure_id(), 3u);
  EXPECT_FALSE(all.certified());
  EXPECT_EQ(all.boxes(), 900u);
  EXPECT_EQ(all.folded(), 300u);
  EXPECT_EQ(all.undecided(), 300u);
  ASSERT_EQ(all.places_size(), 600);
  EXPECT_EQ(all.places(0).state(), v1::FOLD_STATE_FOLDED);
  EXPECT_EQ(all.places(0).box().u(), 1);
  EXPECT_EQ(all.places(0).rest_point().z(), 3);
  EXPECT_EQ(all.places(0).determinant(), -0.25);
  EXPECT_EQ(all.places(300).state(), v1::FOLD_STATE_UNDECIDED);
  EXPECT_EQ(all.places(300).box().u(), 0);
  EXPECT_LE(all.ByteSizeLong(), 60'000u);
  EXPECT_EQ(few.places_size(), 256);
  EXPECT_EQ(few.folded(), 300u);
}

TEST(FoldConverters, ScopesAreReadAndOthersRefused) {
  EXPECT_EQ(*FoldScopeFromProto(v1::FOLD_SCOPE_UNSPECIFIED), FoldScope::kSurface);
  EXPECT_EQ(*FoldScopeFromProto(v1::FOLD_SCOPE_VOLUME), FoldScope::kVolume);
  EXPECT_THAT(FoldScopeFromProto(static_cast<v1::FoldScope>(9)),
              testing::StatusIs(absl::StatusCode::kInvalidArgument, ::testing::HasSubstr("scope")));
}

}  // namespace
}  // namespace latticed
