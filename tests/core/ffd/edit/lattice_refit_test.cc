// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The lattice that deforms most like another: exact where it can be, else nearest by the integral of the definition.
#include "core/ffd/edit/lattice_refit.h"

#include <cmath>
#include <random>

#include "core/ffd/bspline_basis.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/edit/knot_insertion.h"
#include "core/ffd/edit/lattice_edit.h"
#include "gmock/gmock.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

// R at a place in the frame, each coordinate 0 … 1.
Vec3d At(const Lattice& lattice, Vec3d place) {
  const LatticeStructure& s = lattice.structure;
  std::array<int, 3> span;
  Vec3d parameter;
  for (int a = 0; a < 3; ++a) {
    const auto n = static_cast<size_t>(a);
    const double begin = s.domain_begin(a), end = s.domain_end(a);
    parameter[a] = begin + place[a] * (end - begin);
    span[n] = FindLowerSpan(s.knots[n].data(), s.degree[n], s.size[n], parameter[a]);
  }
  return EvaluateVolume(s, lattice.control_points, span, parameter).position;
}

LatticeStructure Structure(std::array<int, 3> degree, std::array<int, 3> size,
                           KnotKind kind = KnotKind::kUniform) {
  LatticeStructure s;
  s.degree = degree;
  s.size = size;
  s.frame = {{5, -7, 1}, {Vec3d{2, 0, 0.3}, Vec3d{0, 3, 0}, Vec3d{0.1, 0, 1}}};
  for (size_t a = 0; a < 3; ++a) s.knots[a] = MakeKnots(kind, degree[a], size[a]);
  return s;
}

Lattice Shaken(const LatticeStructure& structure, uint32_t seed) {
  return {structure, Jitter(structure, 0.4, seed)};
}

// The largest distance on a grid that has no relation to knots.
double Farthest(const Lattice& a, const Lattice& b) {
  constexpr int kSteps = 13;
  double largest = 0;
  for (int n = 0; n <= kSteps * kSteps * kSteps; ++n) {
    const Vec3d place{(n % kSteps) / (kSteps - 1.), (n / kSteps % kSteps) / (kSteps - 1.),
                      std::min(1., n / kSteps / kSteps / (kSteps - 1.))};
    largest = std::max(largest, Norm(At(a, place) - At(b, place)));
  }
  return largest;
}

// ∫ |a - b|² over the frame by the midpoint rule.
double Integral(const Lattice& a, const Lattice& b) {
  constexpr int kSteps = 24;
  double sum = 0;
  for (int n = 0; n < kSteps * kSteps * kSteps; ++n) {
    const Vec3d place{(n % kSteps + 0.5) / kSteps, (n / kSteps % kSteps + 0.5) / kSteps,
                      (n / kSteps / kSteps + 0.5) / kSteps};
    const Vec3d difference = At(a, place) - At(b, place);
    sum += Dot(difference, difference) / (kSteps * kSteps * kSteps);
  }
  return sum;
}

TEST(LatticeRefit, KeepsTheShapeWhereTheNewLatticeCan) {
  constexpr uint32_t kSeed = 31;
  for (const KnotKind kind : {KnotKind::kUniform, KnotKind::kNonUniform, KnotKind::kUnclamped}) {
    const Lattice coarse = Shaken(Structure({1, 2, 3}, {4, 5, 6}, kind), kSeed);
    Lattice fine = coarse;
    for (int axis = 0; axis < 3; ++axis) {
      const double middle =
          0.37 * coarse.structure.domain_begin(axis) + 0.63 * coarse.structure.domain_end(axis);
      fine = *WithKnotInserted(fine, axis, middle, "");
    }
    const LatticeRefit refined = Refit(coarse, fine.structure);
    EXPECT_LT(Farthest(coarse, refined.lattice), 1e-12 * 10) << static_cast<int>(kind);
    EXPECT_LT(refined.residual, 1e-12 * 10);
    EXPECT_LT(Refit(fine, coarse.structure).residual, 1e-12 * 10)
        << "what a knot added, it can lose";
  }
}

// One span a side: polynomials of degree 2 are polynomials of degree 3 too.
TEST(LatticeRefit, RaisesTheDegreeOfAPolynomialExactly) {
  const Lattice quadratic = Shaken(Structure({2, 2, 2}, {3, 3, 3}), 5);
  const LatticeRefit cubic = Refit(quadratic, Structure({3, 3, 3}, {4, 5, 6}));
  EXPECT_LT(cubic.residual, 1e-11);
  EXPECT_LT(Farthest(quadratic, cubic.lattice), 1e-11);
}

TEST(LatticeRefit, IsTheNearestAndSaysHowFar) {
  constexpr uint32_t kSeed = 8;
  const Lattice given = Shaken(Structure({2, 3, 2}, {7, 6, 5}), kSeed);
  const LatticeRefit coarse = Refit(given, Structure({2, 2, 3}, {4, 4, 4}));
  const double least = Integral(given, coarse.lattice);
  EXPECT_GT(least, 1e-4);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> move(-0.02, 0.02);
  for (int n = 0; n < 12; ++n) {  // any other lattice is farther
    Lattice other = coarse.lattice;
    for (Vec3d& p : other.control_points) p += Vec3d{move(random), move(random), move(random)};
    EXPECT_GT(Integral(given, other), least) << n;
  }
  const double farthest = Farthest(given, coarse.lattice);
  EXPECT_GT(coarse.residual, 0.5 * farthest);
  EXPECT_LT(coarse.residual, 2 * farthest);
}

TEST(LatticeRefit, WhatHasNotMovedStaysAtRestBitForBit) {
  const LatticeStructure from = Structure({2, 2, 2}, {5, 4, 4});
  const LatticeStructure to = Structure({3, 2, 1}, {9, 3, 5}, KnotKind::kNonUniform);
  const LatticeRefit rest = Refit({from, IdentityControlPoints(from)}, to);
  EXPECT_EQ(rest.lattice.control_points, IdentityControlPoints(to));
  EXPECT_EQ(rest.residual, 0);
}

TEST(LatticeRefit, TakesTheLongestAndTheLargestLattices) {
  constexpr double kFarthest = 3;  // jitter of 0.4 of the shortest edge
  const Lattice longest = Shaken(Structure({3, 1, 1}, {8192, 2, 2}), 3);
  EXPECT_LT(Refit(longest, longest.structure).residual, 1e-10);
  for (const std::array<int, 3> size : {std::array{2, 8192, 2}, {2, 2, 8192}, {4, 64, 128}}) {
    const LatticeRefit other = Refit(longest, Structure({1, 1, 1}, size));
    EXPECT_GT(other.residual, 0.01);
    EXPECT_LT(other.residual, kFarthest);
  }
  const Lattice largest = Shaken(Structure({3, 3, 3}, {32, 32, 32}), 3);
  EXPECT_LT(Refit(largest, Structure({3, 3, 3}, {63, 32, 16})).residual, kFarthest);
}

// A function may have no support in the domain, and knots may lie closer together than a double can tell apart.
TEST(LatticeRefit, ControlPointsWithoutEffectStayAtRest) {
  LatticeStructure odd = Structure({1, 1, 1}, {3, 2, 2});
  odd.knots[0] = {-1, 0, 0, 1, 1};
  const Lattice given = Shaken(Structure({2, 2, 2}, {4, 4, 4}), 9);
  const LatticeRefit refit = Refit(given, odd);
  EXPECT_EQ(refit.lattice.control_points[0], IdentityControlPoints(odd)[0]);
  EXPECT_OK(Validate(refit.lattice));
  EXPECT_LT(refit.residual, 3);

  LatticeStructure close = Structure({1, 1, 1}, {5, 2, 2});
  close.knots[0] = {0, 0, 0.5, 0.5 + 1e-13, 0.5 + 2e-13, 1, 1};
  EXPECT_TRUE(std::isfinite(Refit(given, close).residual));
}

}  // namespace
}  // namespace latticed::testing
