// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Drags, compared with a dense solution of the formula in long double, and with the conditions that
// a least-squares solution must satisfy.
#include "core/ffd/edit/direct_manipulation.h"

#include <cmath>
#include <random>
#include <vector>

#include "core/base/limits.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/edit/lattice_edit.h"
#include "core/ffd/edit/minimum_norm.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

constexpr uint32_t kDragSeed = 11;

Lattice MakeLattice(std::array<int, 3> size, std::array<int, 3> degree, uint32_t seed) {
  Bounds bounds;
  bounds.Extend(Vec3d{-1, 0, 2});
  bounds.Extend(Vec3d{1, 1, 3});
  Lattice lattice = *FitLattice(bounds, size, degree, 0.0);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  for (Vec3d& p : lattice.control_points) p += {noise(random), noise(random), noise(random)};
  return lattice;
}

std::vector<Vec3d> RandomPoints(size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Vec3d> points;
  for (size_t i = 0; i < count; ++i) {
    const double x = unit(random), y = unit(random), z = unit(random);
    points.push_back({2 * x - 1, y, 2 + z});
  }
  return points;
}

Vec3d Deform(const Lattice& lattice, Vec3d point) {
  return EvaluateWorld(lattice.structure, lattice.control_points, point).position;
}

std::vector<Vec3d> Offset(const Lattice& lattice, const std::vector<Vec3d>& points,
                          const std::vector<Vec3d>& by) {
  std::vector<Vec3d> targets;
  for (size_t i = 0; i < points.size(); ++i) {
    targets.push_back(Deform(lattice, points[i]) + by[i % by.size()]);
  }
  return targets;
}

Lattice Moved(Lattice lattice, const ControlPointMoves& moves) {
  for (size_t n = 0; n < moves.indices.size(); ++n) {
    lattice.control_points[moves.indices[n]] += moves.offsets[n];
  }
  return lattice;
}

// A row of N: how far one unit of each control point moves the point.
std::vector<long double> BasisValues(const Lattice& lattice, Vec3d point) {
  std::vector<long double> values;
  std::vector<Vec3d> unit(lattice.control_points.size());
  for (Vec3d& p : unit) {
    p.x = 1;
    values.push_back(EvaluateWorld(lattice.structure, unit, point).position.x);
    p.x = 0;
  }
  return values;
}

// Computes N' (N N')^-1 dS by elimination.
std::vector<Vec3d> SolveDensely(const Lattice& lattice, const std::vector<Vec3d>& points,
                                const std::vector<Vec3d>& wanted) {
  const size_t k = points.size();
  std::vector<std::vector<long double>> n, g(k, std::vector<long double>(k + 3));
  for (const Vec3d p : points) n.push_back(BasisValues(lattice, p));
  for (size_t i = 0; i < k; ++i) {
    for (size_t j = 0; j < k; ++j) {
      for (size_t c = 0; c < n[i].size(); ++c) g[i][j] += n[i][c] * n[j][c];
    }
    for (int a = 0; a < 3; ++a) g[i][k + static_cast<size_t>(a)] = wanted[i][a];
  }
  for (size_t p = 0; p < k; ++p) {
    for (size_t i = 0; i < k; ++i) {
      if (i == p) continue;
      const long double factor = g[i][p] / g[p][p];
      for (size_t j = p; j < k + 3; ++j) g[i][j] -= factor * g[p][j];
    }
  }
  std::vector<Vec3d> x(lattice.control_points.size());
  for (size_t i = 0; i < k; ++i) {
    for (size_t c = 0; c < x.size(); ++c) {
      for (int a = 0; a < 3; ++a) {
        x[c][a] += static_cast<double>(n[i][c] * g[i][k + static_cast<size_t>(a)] / g[i][i]);
      }
    }
  }
  return x;
}

TEST(DirectManipulation, OnePointReachesItsTargetAtEveryDegree) {
  for (const std::array<int, 3> degree :
       {std::array{1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {1, 2, 3}, {3, 1, 2}}) {
    const Lattice lattice = MakeLattice({5, 4, 6}, degree, kDragSeed);
    for (const Vec3d point : {Vec3d{0.3, 0.2, 2.7}, {-1, 0, 2}, {1, 1, 3}, {0, 0.5, 2.5}}) {
      const Vec3d by{0.4, -0.3, 0.7};
      const std::vector targets{Deform(lattice, point) + by};

      const ControlPointMoves moves = DragToTargets(lattice, std::vector{point}, targets);

      EXPECT_LE(moves.residual, 1e-15);
      EXPECT_LE(Norm(Deform(Moved(lattice, moves), point) - targets[0]), 1e-14);
      const auto values = BasisValues(lattice, point);
      double sum2 = 0;
      for (const long double v : values) sum2 += static_cast<double>(v * v);
      for (size_t n = 0; n < moves.indices.size(); ++n) {
        const auto v = static_cast<double>(values[moves.indices[n]]);
        EXPECT_GT(v, 0);
        EXPECT_LE(Norm(moves.offsets[n] - v / sum2 * by), 1e-14);
      }
    }
  }
}

TEST(DirectManipulation, IndependentPointsReachTheirTargetsByTheSmallestMove) {
  SCOPED_TRACE(kDragSeed);
  for (const size_t count : {size_t{2}, size_t{7}, size_t{30}}) {
    const Lattice lattice = MakeLattice({6, 5, 7}, {2, 3, 2}, kDragSeed);
    const auto points = RandomPoints(count, kDragSeed + 1);
    const auto by = RandomPoints(count, kDragSeed + 2);

    const ControlPointMoves moves = DragToTargets(lattice, points, Offset(lattice, points, by));

    EXPECT_LE(moves.residual, 1e-13);
    std::vector<Vec3d> left = SolveDensely(lattice, points, by);
    double largest = 0;
    for (const Vec3d x : left) largest = std::max(largest, Norm(x));
    for (size_t n = 0; n < moves.indices.size(); ++n) left[moves.indices[n]] -= moves.offsets[n];
    for (const Vec3d x : left) EXPECT_LE(Norm(x), 1e-9 * largest);
  }
}

TEST(DirectManipulation, ContradictoryTargetsMeetInTheMiddle) {
  const Lattice lattice = MakeLattice({4, 4, 4}, {2, 2, 2}, kDragSeed);
  const Vec3d point{0.1, 0.6, 2.4}, at = Deform(lattice, point);
  const std::vector<Vec3d> points{point, point, {-0.7, 0.3, 2.9}};
  const std::vector<Vec3d> targets{at + Vec3d{0, 0, 1}, at - Vec3d{0, 0.5, 0},
                                   Deform(lattice, points[2])};

  const ControlPointMoves moves = DragToTargets(lattice, points, targets);

  const Lattice moved = Moved(lattice, moves);
  EXPECT_LE(Norm(Deform(moved, point) - 0.5 * (targets[0] + targets[1])), 1e-12);
  EXPECT_LE(Norm(Deform(moved, points[2]) - targets[2]), 1e-12);
  EXPECT_NEAR(moves.residual, 0.5 * Norm(targets[0] - targets[1]), 1e-12);
}

TEST(DirectManipulation, WhatIsOutsideTheFrameStays) {
  const Lattice lattice = MakeLattice({4, 4, 4}, {2, 2, 2}, kDragSeed);
  const std::vector<Vec3d> points{{0.2, 0.2, 2.2}, {5, 5, 5}};
  const std::vector<Vec3d> targets{{0, 0, 0}, {5, 5, 8}};

  const ControlPointMoves moves = DragToTargets(lattice, points, targets);
  const ControlPointMoves none =
      DragToTargets(lattice, std::vector{points[1]}, std::vector{targets[1]});

  EXPECT_DOUBLE_EQ(moves.residual, 3);
  EXPECT_LE(Norm(Deform(Moved(lattice, moves), points[0])), 1e-13);
  EXPECT_DOUBLE_EQ(none.residual, 3);
  EXPECT_TRUE(none.indices.empty());
}

TEST(DirectManipulation, MorePointsThanControlPointsLeaveTheLeastSquares) {
  const Lattice lattice = MakeLattice({2, 2, 2}, {1, 1, 1}, kDragSeed);
  const auto points = RandomPoints(1000, kDragSeed);
  const auto targets = Offset(lattice, points, RandomPoints(1000, kDragSeed + 3));

  const ControlPointMoves moves = DragToTargets(lattice, points, targets);

  const Lattice moved = Moved(lattice, moves);
  double largest = 0;
  std::vector<Vec3d> normal(8);  // N' times the residual
  for (size_t i = 0; i < points.size(); ++i) {
    const Vec3d left = targets[i] - Deform(moved, points[i]);
    largest = std::max(largest, Norm(left));
    const auto values = BasisValues(lattice, points[i]);
    for (size_t c = 0; c < 8; ++c) normal[c] += static_cast<double>(values[c]) * left;
  }
  EXPECT_NEAR(moves.residual, largest, 1e-12);
  EXPECT_GT(largest, 0.5);
  for (const Vec3d n : normal) EXPECT_LE(Norm(n), 1e-10);
}

TEST(DirectManipulation, PointsCloseToEachOther) {
  const Lattice lattice = MakeLattice({5, 5, 5}, {3, 3, 3}, kDragSeed);
  const Vec3d point{0.1, 0.4, 2.6};
  const auto drag = [&](double apart) {
    const std::vector<Vec3d> points{point, point + Vec3d{apart, 0, 0}};
    return DragToTargets(lattice, points, Offset(lattice, points, {{0, 1, 0}, {0, -1, 0}}));
  };

  const ControlPointMoves near = drag(1e-4), same = drag(1e-9);

  EXPECT_LE(near.residual, 1e-9) << "independent: their targets are reached";
  EXPECT_NEAR(same.residual, 1, 1e-6) << "dependent: nothing can take them apart";
  for (const Vec3d offset : same.offsets) EXPECT_LE(Norm(offset), 1e-6);
}

TEST(DirectManipulation, AsManyPointsAsAreAllowed) {
  const Lattice lattice = MakeLattice({16, 16, 16}, {2, 2, 2}, kDragSeed);
  const auto points = RandomPoints(limits::kMaxDragPoints, kDragSeed + 4);
  const auto by = RandomPoints(limits::kMaxDragPoints, kDragSeed + 5);

  const ControlPointMoves moves = DragToTargets(lattice, points, Offset(lattice, points, by));

  EXPECT_LE(moves.residual, 1e-9);
}

TEST(DirectManipulation, AnEditSaysWhatItLeft) {
  const Lattice lattice = MakeLattice({4, 4, 4}, {2, 2, 2}, kDragSeed);
  EditTarget target(lattice);
  const Vec3d inside{0, 0.5, 2.5};
  const auto initial = [&] { return lattice; };

  ASSERT_OK(ApplyEdit(DragPoints{{inside, {9, 0, 0}}, {{1, 2, 3}, {9, 0, 2}}}, initial, "edits[0]",
                      target));
  ASSERT_OK(ApplyEdit(DragPoints{{inside}, {{0, 0, 0}}}, initial, "edits[1]", target));

  EXPECT_DOUBLE_EQ(target.drag_residual, 2);
  EXPECT_LE(Norm(Deform(target.lattice, inside)), 1e-14);
  for (size_t i = 0; i < target.written.size(); ++i) {
    EXPECT_EQ(target.written[i],
              !SameBits(target.lattice.control_points[i], lattice.control_points[i]));
  }
}

}  // namespace
}  // namespace latticed
