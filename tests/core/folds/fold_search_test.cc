// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/fold_search.h"

#include <gtest/gtest.h>

#include <limits>

namespace latticed {
namespace {

constexpr double kSlack = 1e-12;

// (x - root)^2 + height, of degree 2 in x and 2 in y and z.
FoldDecision DecideParabola(double root, double height) {
  FoldSearch search;
  BernsteinVolume& p = search.polynomial();
  p.count = {3, 3, 3};
  const double c[3] = {root * root + height, root * root - root + height,
                       (1 - root) * (1 - root) + height};
  for (size_t i = 0; i < p.size(); ++i) p.coefficients[i] = c[i % 3];
  return search.Decide(kSlack);
}

TEST(FoldSearch, CertifiesAtOnceIfAllCoefficientsAreAboveTheSlack) {
  const FoldDecision decision = DecideParabola(-1, 0.5);

  EXPECT_EQ(decision.state, FoldState::kCertified);
  EXPECT_EQ(decision.cells, 1);
}

TEST(FoldSearch, HalvesUntilItIsCertain) {
  const FoldDecision decision = DecideParabola(0.3, 1e-4);

  EXPECT_EQ(decision.state, FoldState::kCertified);
  EXPECT_GT(decision.cells, 10);
}

TEST(FoldSearch, FindsAFoldInside) {
  const FoldDecision decision = DecideParabola(0.3, -1e-6);

  EXPECT_EQ(decision.state, FoldState::kFolded);
  EXPECT_NEAR(decision.place.x, 0.3, 1e-3);
  EXPECT_LE(decision.value, 0);
  EXPECT_GE(decision.value, -1e-6);
}

TEST(FoldSearch, AWitnessLiesInsideWhereItCan) {
  const FoldDecision decision =
      DecideParabola(0, -1e-3);  // folded at the face x = 0, and beside it

  EXPECT_EQ(decision.state, FoldState::kFolded);
  EXPECT_GT(decision.place.x, 0);
  EXPECT_LE(decision.value, 0);
}

TEST(FoldSearch, AFlattenedCubeIsFolded) {
  FoldSearch search;
  search.polynomial().count = {3, 3, 3};
  search.polynomial().coefficients.fill(0);

  EXPECT_EQ(search.Decide(kSlack).state, FoldState::kFolded);
}

TEST(FoldSearch, WhatTouchesZeroIsUndecided) {
  const FoldDecision decision = DecideParabola(0.3, 1e-13);  // less than the slack

  EXPECT_EQ(decision.state, FoldState::kUndecided);
  EXPECT_NEAR(decision.place.x, 0.3, 1e-3);
  EXPECT_GT(decision.value, 0);
}

TEST(FoldSearch, NothingIsProvedOfNan) {
  FoldSearch search;
  search.polynomial().count = {3, 3, 3};
  search.polynomial().coefficients.fill(std::numeric_limits<double>::quiet_NaN());

  EXPECT_EQ(search.Decide(kSlack).state, FoldState::kUndecided);
}

TEST(FoldSearch, ASearchDoesNotDependOnTheOneBefore) {
  FoldSearch search;
  search.polynomial().count = {9, 9, 9};
  search.polynomial().coefficients.fill(-1);
  ASSERT_EQ(search.Decide(kSlack).state, FoldState::kFolded);
  search.polynomial().count = {3, 3, 3};
  search.polynomial().coefficients.fill(1);

  EXPECT_EQ(search.Decide(kSlack).state, FoldState::kCertified);
}

}  // namespace
}  // namespace latticed
