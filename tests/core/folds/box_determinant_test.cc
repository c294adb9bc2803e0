// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/box_determinant.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/core/folds/fold_fixtures.h"

namespace latticed {
namespace {

using testing::DefinedDeterminant;
using testing::DrawLattice;
using testing::FoldCase;

constexpr uint32_t kDegreeMixes = 27;
// det J of these lattices is below 100. The definition loses more digits than the polynomial: it takes differences of
// products of whole coordinates.
constexpr double kTolerance = 1e-11;

// The first knot box, or the part of it between two fractions.
BoxPart PartOf(const LatticeStructure& s, Vec3d from, Vec3d to) {
  BoxPart part;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<size_t>(axis);
    int span = s.degree[a];
    while (!(s.knots[a][static_cast<size_t>(span) + 1] > s.knots[a][static_cast<size_t>(span)])) {
      ++span;
    }
    part.span[a] = span;
    const double begin = s.knots[a][static_cast<size_t>(span)];
    const double width = s.knots[a][static_cast<size_t>(span) + 1] - begin;
    part.lower[axis] = begin + from[axis] * width;
    part.upper[axis] = begin + to[axis] * width;
  }
  return part;
}

void ExpectDefinition(const FoldCase& lattice, const BoxPart& part) {
  BernsteinVolume determinant;
  const double slack =
      MakeBoxDeterminant(lattice.structure, lattice.control_points, part, determinant);
  EXPECT_GT(slack, 0);
  EXPECT_LT(slack, 1e-9);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int n = 0; n < 10; ++n) {
    const Vec3d l{uniform(random), uniform(random), uniform(random)};
    Vec3d parameter = part.lower;
    for (int a = 0; a < 3; ++a) parameter[a] += l[a] * (part.upper[a] - part.lower[a]);
    EXPECT_NEAR(determinant.Value(l),
                DefinedDeterminant(lattice.structure, lattice.control_points, part.span, parameter),
                kTolerance);
  }
}

TEST(BoxDeterminant, MatchesDefinitionAtAllDegreeMixes) {
  for (uint32_t mix = 0; mix < kDegreeMixes; ++mix) {
    for (uint32_t seed = 0; seed < 4; ++seed) {
      SCOPED_TRACE(::testing::Message() << "mix " << mix << " seed " << seed);
      const FoldCase lattice = DrawLattice(seed, mix, 0.5);
      ExpectDefinition(lattice, PartOf(lattice.structure, {0, 0, 0}, {1, 1, 1}));
    }
  }
}

TEST(BoxDeterminant, MatchesDefinitionInParts) {
  for (uint32_t mix = 0; mix < kDegreeMixes; ++mix) {
    SCOPED_TRACE(mix);
    const FoldCase lattice = DrawLattice(5, mix, 0.5);
    ExpectDefinition(lattice, PartOf(lattice.structure, {0.1, 0.3, 0.5}, {0.2, 0.9, 1}));
    // A flat part, a line and a point.
    ExpectDefinition(lattice, PartOf(lattice.structure, {0.1, 0.3, 0}, {0.2, 0.9, 0}));
    ExpectDefinition(lattice, PartOf(lattice.structure, {0.1, 0.3, 1}, {0.1, 0.9, 1}));
    ExpectDefinition(lattice, PartOf(lattice.structure, {0.1, 0.3, 0.7}, {0.1, 0.3, 0.7}));
  }
}

TEST(BoxDeterminant, OfTheIdentityIsOneEverywhere) {
  for (uint32_t mix = 0; mix < kDegreeMixes; ++mix) {
    const FoldCase lattice = DrawLattice(6, mix, 0);
    BernsteinVolume determinant;
    const double slack =
        MakeBoxDeterminant(lattice.structure, lattice.control_points,
                           PartOf(lattice.structure, {0, 0, 0}, {1, 1, 1}), determinant);
    for (size_t i = 0; i < determinant.size(); ++i) {
      EXPECT_NEAR(determinant.coefficients[i], 1, slack);
    }
  }
}

// Far from the origin, coordinates have few digits of the shape. Their differences are exact, and so is the slack.
TEST(BoxDeterminant, DoesNotLoseDigitsFarFromTheOrigin) {
  FoldCase lattice = DrawLattice(8, 26, 0.4);
  const BoxPart part = PartOf(lattice.structure, {0, 0, 0}, {1, 1, 1});
  const double grid = 0x1p-20;  // coordinates on a grid, which a far offset does not round
  for (Vec3d& p : lattice.control_points) {
    for (int c = 0; c < 3; ++c) p[c] = std::round(p[c] / grid) * grid;
  }
  BernsteinVolume near, far;
  const double slack = MakeBoxDeterminant(lattice.structure, lattice.control_points, part, near);
  for (Vec3d& p : lattice.control_points) p += Vec3d{0x1p30, -0x1p30, 0x1p29};
  EXPECT_EQ(MakeBoxDeterminant(lattice.structure, lattice.control_points, part, far), slack);
  for (size_t i = 0; i < near.size(); ++i) EXPECT_EQ(near.coefficients[i], far.coefficients[i]);
}

}  // namespace
}  // namespace latticed
