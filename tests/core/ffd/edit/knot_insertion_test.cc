// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Knot insertion, compared with formula (1) before and after, and its refusals.
#include "core/ffd/edit/knot_insertion.h"

#include <cmath>
#include <limits>
#include <random>

#include "core/ffd/bspline_basis.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/edit/lattice_edit.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::HasSubstr;

Vec3d Evaluate(const Lattice& lattice, Vec3d parameter) {
  const LatticeStructure& s = lattice.structure;
  std::array<int, 3> span;
  for (size_t a = 0; a < 3; ++a) {
    span[a] =
        FindLowerSpan(s.knots[a].data(), s.degree[a], s.size[a], parameter[static_cast<int>(a)]);
  }
  return EvaluateVolume(s, lattice.control_points, span, parameter).position;
}

Lattice MakeLattice(std::array<int, 3> degree, std::array<int, 3> size, bool clamped) {
  Lattice lattice;
  LatticeStructure& s = lattice.structure;
  s.degree = degree;
  s.size = size;
  s.frame = {{-1, 2, 3}, {Vec3d{2, 0, 0.3}, Vec3d{0, 3, 0}, Vec3d{0.1, 0, 1}}};
  for (size_t a = 0; a < 3; ++a) {
    s.knots[a] = ClampedUniformKnots(degree[a], size[a]);
    if (clamped) continue;
    for (size_t i = 0; i < s.knots[a].size(); ++i)
      s.knots[a][i] = std::pow(static_cast<double>(i), 1.3);
  }
  lattice.control_points = IdentityControlPoints(s);
  return lattice;
}

void Shake(Lattice& lattice, std::mt19937_64& random) {
  std::uniform_real_distribution<double> move(-0.5, 0.5);
  for (Vec3d& p : lattice.control_points) p += Vec3d{move(random), move(random), move(random)};
}

TEST(KnotInsertionTest, KeepsTheShapeAtEveryDegreeClampedAndUnclamped) {
  constexpr uint64_t kSeed = 20260101;
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(0, 1);
  const Vec3d offset{5000, -7000, 100};  // far from the origin: results must not depend on it
  for (int mix = 0; mix < 27; ++mix) {
    const std::array<int, 3> degree{1 + mix % 3, 1 + mix / 3 % 3, 1 + mix / 9};
    for (const bool clamped : {true, false}) {
      Lattice lattice = MakeLattice(degree, {5, 6, 4}, clamped);
      if (mix % 2 == 1) lattice.structure.frame.origin += offset;
      lattice.control_points = IdentityControlPoints(lattice.structure);
      Shake(lattice, random);
      Bounds bounds;
      for (const Vec3d p : lattice.control_points) bounds.Extend(p);
      Lattice refined = lattice;
      for (int n = 0; n < 6; ++n) {
        const int axis = n % 3;
        const double begin = refined.structure.domain_begin(axis);
        const double end = refined.structure.domain_end(axis);
        ASSERT_OK_AND_ASSIGN(
            auto next, WithKnotInserted(refined, axis, begin + unit(random) * (end - begin), "f"));
        refined = std::move(next);
      }
      ASSERT_OK(Validate(refined));
      ASSERT_EQ(refined.control_points.size(), 7u * 8u * 6u);
      for (int n = 0; n < 200; ++n) {
        Vec3d t;
        for (int a = 0; a < 3; ++a) {
          const double begin = lattice.structure.domain_begin(a);
          t[a] = begin + unit(random) * (lattice.structure.domain_end(a) - begin);
        }
        const double moved = Norm(Evaluate(refined, t) - Evaluate(lattice, t));
        // Knot insertion keeps the shape to 1e-12 of the diagonal, plus the rounding of the
        // coordinates, which grows far from the origin.
        const double rounding = 4 * std::numeric_limits<double>::epsilon() * Norm(bounds.max);
        ASSERT_LE(moved, 1e-12 * bounds.diagonal() + rounding)
            << "degrees " << degree[0] << degree[1] << degree[2] << " clamped " << clamped;
      }
    }
  }
}

TEST(KnotInsertionTest, DoublesAKnotUpToTheDegree) {
  Lattice lattice = MakeLattice({2, 2, 2}, {5, 5, 5}, true);

  ASSERT_OK_AND_ASSIGN(auto twice, WithKnotInserted(lattice, 1, 1.0, "edits[0].insert_knot"));
  EXPECT_EQ(twice.structure.knots[1], (std::vector<double>{0, 0, 0, 1, 1, 2, 3, 3, 3}));
  EXPECT_THAT(
      WithKnotInserted(twice, 1, 1.0, "edits[0].insert_knot"),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("edits[0].insert_knot.value")));
}

TEST(KnotInsertionTest, PointsAtRestStayAtRestBitForBit) {
  const Lattice lattice = MakeLattice({3, 2, 1}, {6, 5, 4}, true);

  ASSERT_OK_AND_ASSIGN(auto refined, WithKnotInserted(lattice, 0, 1.37, "f"));
  const auto identity = IdentityControlPoints(refined.structure);
  for (size_t i = 0; i < identity.size(); ++i) {
    EXPECT_TRUE(SameBits(identity[i], refined.control_points[i])) << i;
  }
}

TEST(KnotInsertionTest, FollowsTheKnotsOfAnotherStructure) {
  Lattice lattice = MakeLattice({2, 2, 2}, {4, 4, 4}, true);
  ASSERT_OK_AND_ASSIGN(auto one, WithKnotInserted(lattice, 0, 0.5, "f"));
  ASSERT_OK_AND_ASSIGN(auto two, WithKnotInserted(one, 2, 1.0, "f"));

  ASSERT_OK_AND_ASSIGN(auto refined, WithKnotsOf(lattice, two.structure));
  EXPECT_EQ(refined.structure, two.structure);
}

TEST(KnotInsertionTest, RefusesWhatIsNoKnotOfTheDomain) {
  const Lattice lattice = MakeLattice({2, 2, 2}, {4, 4, 4}, true);  // domain [0, 2]
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double value : {-0.1, 0.0, 2.0, 2.5, nan, HUGE_VAL}) {
    EXPECT_THAT(WithKnotInserted(lattice, 0, value, "f"),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("f.value")))
        << value;
  }
  EXPECT_THAT(WithKnotInserted(lattice, 3, 1, "f"),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("f.axis")));
}

TEST(KnotInsertionTest, RefusesTooManyControlPoints) {
  const Lattice lattice = MakeLattice({2, 2, 2}, {32, 32, 32}, true);
  EXPECT_THAT(WithKnotInserted(lattice, 0, 0.5, "f"),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("32768")));
}

}  // namespace
}  // namespace latticed
