// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lattices continued outside their frame, compared with formula (1) of the given lattice, and their refusals.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "core/ffd/edit/knot_insertion.h"
#include "core/ffd/edit/lattice_edit.h"
#include "core/ffd/outside/outside_map.h"
#include "core/ffd/outside/outside_rules.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/mesh/sample_meshes.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::HasSubstr;

constexpr uint64_t kSeed = 20261129;

struct Mode {
  OutsideMode mode;
  bool smooth;
};
constexpr std::array<Mode, 3> kModes{
    {{OutsideMode::kFalloff, true}, {OutsideMode::kFalloff, false}, {OutsideMode::kLinear, true}}};

std::array<int, 3> MixOf(int mix) { return {1 + mix % 3, 1 + mix / 3 % 3, 1 + mix / 9}; }

Lattice ContinuedLattice(std::array<int, 3> degree, Mode mode, std::array<double, 6> widths) {
  Lattice lattice;
  LatticeStructure& s = lattice.structure;
  s.degree = degree;
  s.size = {degree[0] + 1, degree[1] + 2, degree[2] + 4};
  s.frame = {{-1, 2, 3}, {Vec3d{2, 0, 0.3}, Vec3d{0, 3, 0}, Vec3d{0.1, 0, 1}}};
  for (size_t a = 0; a < 3; ++a) s.knots[a] = ClampedUniformKnots(degree[a], s.size[a]);
  s.outside = {mode.mode, mode.smooth, widths, {}};
  s.outside = ResolvedOutside(s, {});
  lattice.control_points = IdentityControlPoints(s);
  return lattice;
}

Lattice ShakenLattice(std::array<int, 3> degree, Mode mode, std::array<double, 6> widths,
                      std::mt19937_64& random) {
  Lattice lattice = ContinuedLattice(degree, mode, widths);
  std::uniform_real_distribution<double> move(-0.5, 0.5);
  for (Vec3d& p : lattice.control_points) p += Vec3d{move(random), move(random), move(random)};
  return lattice;
}

constexpr std::array<double, 6> AllWidths(double w) { return {w, w, w, w, w, w}; }

// A point by its place in the frame: 0 to 1 inside.
Vec3d WorldAt(const LatticeStructure& s, Vec3d place) {
  return s.frame.origin + place.x * s.frame.edges[0] + place.y * s.frame.edges[1] +
         place.z * s.frame.edges[2];
}

struct Deformed {
  LatticeStructure structure;
  std::vector<Vec3d> points;

  explicit Deformed(const Lattice& lattice) {
    const OutsideMap map(lattice.structure);
    structure = map.continued();
    points = map.Continue(lattice.control_points);
  }
  DeformedPoint At(Vec3d world) const { return EvaluateWorld(structure, points, world); }
};

double Largest(const std::array<Vec3d, 3>& a, const std::array<Vec3d, 3>& b) {
  double most = 0;
  for (size_t c = 0; c < 3; ++c) most = std::max(most, Norm(a[c] - b[c]));
  return most;
}

TEST(OutsideTest, TheInsideStaysAsItIsAtEveryDegree) {
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(0, 1);
  double worst = 0;
  for (int mix = 0; mix < 27; ++mix) {
    for (const Mode mode : kModes) {
      const Lattice lattice = ShakenLattice(MixOf(mix), mode, AllWidths(0.3), random);
      ASSERT_TRUE(Validate(lattice).ok());
      const Deformed deformed(lattice);
      ASSERT_TRUE(Validate(deformed.structure).ok());
      for (int n = 0; n < 50; ++n) {
        const Vec3d p = WorldAt(lattice.structure, {unit(random), unit(random), unit(random)});
        const DeformedPoint got = deformed.At(p);
        const DeformedPoint want = EvaluateWorld(lattice.structure, lattice.control_points, p);
        worst = std::max(worst, Norm(got.position - want.position));
        ASSERT_LT(Largest(got.jacobian, want.jacobian), 1e-12) << mix;
      }
    }
  }
  EXPECT_LT(worst, 1e-14 * 6);  // of the lattice's diagonal, which is above 6 with its moves
  RecordProperty("worst", std::to_string(worst));
}

TEST(OutsideTest, NoGapAtTheFaceNorAtTheEnd) {
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> place(-0.29, 1.29);
  constexpr double kStep = 1e-7;
  for (int mix = 0; mix < 27; ++mix) {
    for (const Mode mode : kModes) {
      const std::array<int, 3> degree = MixOf(mix);
      const Lattice lattice = ShakenLattice(degree, mode, AllWidths(0.3), random);
      const Deformed deformed(lattice);
      for (int n = 0; n < 20; ++n) {
        Vec3d inner{place(random), place(random), place(random)};
        const int axis = n % 3;
        const double face = n / 3 % 2;
        const double out = face == 1 ? kStep : -kStep;
        Vec3d outer = inner;
        inner[axis] = face - out;
        outer[axis] = face + out;
        const auto a = deformed.At(WorldAt(lattice.structure, inner));
        const auto b = deformed.At(WorldAt(lattice.structure, outer));
        EXPECT_LT(Norm(a.position - b.position), 1e-5);
        const bool smooth = mode.mode == OutsideMode::kLinear ||
                            (mode.smooth && degree[static_cast<size_t>(axis)] > 1);
        if (smooth) {
          EXPECT_LT(Largest(a.jacobian, b.jacobian), 1e-4) << mix;
        }
        if (mode.mode == OutsideMode::kLinear) continue;
        outer[axis] = face + (face == 1 ? 0.3 : -0.3) * (1 - 1e-7);
        const Vec3d end = WorldAt(lattice.structure, outer);
        EXPECT_LT(Norm(deformed.At(end).position - end), 1e-5) << mix;
      }
    }
  }
}

TEST(OutsideTest, FalloffDoesNotOvershoot) {
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  std::array<double, 2> worst{};  // of C1, C0: by the largest move inside
  for (int mix = 0; mix < 27; ++mix) {
    for (size_t m = 0; m < 2; ++m) {
      const Lattice lattice = ShakenLattice(MixOf(mix), kModes[m], AllWidths(0.3), random);
      const Deformed deformed(lattice);
      double inside = 0, outside = 0;
      for (int k = -6; k <= 26; ++k) {
        for (int j = -6; j <= 26; ++j) {
          for (int i = -6; i <= 26; ++i) {
            const Vec3d p = WorldAt(lattice.structure, {i / 20.0, j / 20.0, k / 20.0});
            const double move = Norm(deformed.At(p).position - p);
            const bool in = std::min({i, j, k}) >= 0 && std::max({i, j, k}) <= 20;
            (in ? inside : outside) = std::max(in ? inside : outside, move);
          }
        }
      }
      worst[m] = std::max(worst[m], outside / inside);
    }
  }
  EXPECT_LE(worst[0], 2);
  EXPECT_LE(worst[1], 1 + 1e-12);
  RecordProperty("c1", std::to_string(worst[0]));
  RecordProperty("c0", std::to_string(worst[1]));
}

TEST(OutsideTest, ALinearContinuationIsTheTangent) {
  std::mt19937_64 random(kSeed);
  const Lattice lattice =
      ShakenLattice({3, 2, 3}, {OutsideMode::kLinear, true}, {0, 2, 0, 0, 0, 0}, random);
  const Deformed deformed(lattice);
  const auto face = deformed.At(WorldAt(lattice.structure, {1 - 1e-9, 0.3, 0.6}));
  for (const double u : {1.1, 1.7, 2.5, 2.9}) {
    const Vec3d p = WorldAt(lattice.structure, {u, 0.3, 0.6});
    const Vec3d out = p - WorldAt(lattice.structure, {1, 0.3, 0.6});
    const Vec3d want = face.position + out.x * face.jacobian[0] + out.y * face.jacobian[1] +
                       out.z * face.jacobian[2];
    EXPECT_LT(Norm(deformed.At(p).position - want), 1e-6) << u;
  }
}

TEST(OutsideTest, AnAffineMapGoesOnLinearly) {
  for (int mix = 0; mix < 27; ++mix) {
    Lattice lattice = ContinuedLattice(MixOf(mix), {OutsideMode::kLinear, true}, AllWidths(1.5));
    const auto shear = [](Vec3d p) {
      return Vec3d{p.x + 0.5 * p.y, p.y - 0.2 * p.z, 1.5 * p.z + 1};
    };
    for (Vec3d& p : lattice.control_points) p = shear(p);
    const Deformed deformed(lattice);
    const Vec3d p = WorldAt(lattice.structure, {-1.2, 2.1, 2.4});
    EXPECT_LT(Norm(deformed.At(p).position - shear(p)), 1e-12) << mix;
  }
}

TEST(OutsideTest, RestPointsAreAtTheirIdentityBitForBit) {
  std::mt19937_64 random(kSeed);
  Lattice lattice = ContinuedLattice({2, 3, 2}, kModes[0], AllWidths(0.7));
  const OutsideMap map(lattice.structure);
  const std::vector<Vec3d> rest = IdentityControlPoints(map.continued());
  // The middle of the w axis, and so of no face of w.
  const size_t moved = static_cast<size_t>(lattice.structure.Index(1, 2, 3));
  lattice.control_points[moved] += Vec3d{0.1, 0.2, 0.3};
  const std::vector<Vec3d> points = map.Continue(lattice.control_points);
  size_t moves = 0;
  for (size_t n = 0; n < points.size(); ++n) {
    bool depends = false;
    map.ForSources(n, [&](size_t source, double) { depends |= source == moved; });
    EXPECT_EQ(SameBits(points[n], rest[n]), !depends) << n;
    moves += depends ? 1 : 0;
  }
  // In u it is next to both faces, (1 of 3), in v and w beside none: its own place and two continued ones.
  EXPECT_EQ(moves, 3);
}

TEST(OutsideTest, TheTransposeIsTheTranspose) {
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> number(-1, 1);
  for (const Mode mode : kModes) {
    const OutsideMap map(ContinuedLattice({3, 1, 2}, mode, {0.3, 0, 0.2, 1, 0, 2}).structure);
    std::vector<Vec3d> d(static_cast<size_t>(map.structure().control_point_count()));
    std::vector<Vec3d> g(static_cast<size_t>(map.continued().control_point_count()));
    for (Vec3d& v : d) v = {number(random), number(random), number(random)};
    for (Vec3d& v : g) v = {number(random), number(random), number(random)};
    const auto forward = map.Apply(d), backward = map.ApplyTransposed(g);
    double left = 0, right = 0;
    for (size_t n = 0; n < g.size(); ++n) left += Dot(g[n], forward[n]);
    for (size_t n = 0; n < d.size(); ++n) right += Dot(backward[n], d[n]);
    EXPECT_NEAR(left, right, 1e-10 * (1 + std::abs(left)));
    EXPECT_NE(left, 0);
  }
}

TEST(OutsideTest, AnInsertedKnotKeepsTheShapeOutside) {
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> place(-0.3, 1.3);
  for (const Mode mode : kModes) {
    const Lattice before = ShakenLattice({2, 3, 2}, mode, AllWidths(0.3), random);
    const auto after = WithKnotInserted(before, 0, 0.1, "insert_knot");
    ASSERT_TRUE(after.ok());
    const Deformed a(before), b(*after);
    for (int n = 0; n < 200; ++n) {
      const Vec3d p = WorldAt(before.structure, {place(random), place(random), place(random)});
      EXPECT_LT(Norm(a.At(p).position - b.At(p).position), 1e-12);
    }
  }
}

TEST(OutsideTest, LinearReachesAsFarAsTheMesh) {
  LatticeStructure s = ContinuedLattice({2, 2, 2}, kModes[2], {}).structure;
  EXPECT_EQ(s.outside, Outside{});  // no points lie outside
  s.outside.mode = OutsideMode::kLinear;
  const std::vector<Vec3d> mesh{WorldAt(s, {-0.5, 0.5, 1 + 1e-12}), WorldAt(s, {0.5, 3, 0.5})};
  const Outside outside = ResolvedOutside(s, mesh);
  EXPECT_NEAR(outside.widths[0], 0.5 * 17 / 16, 1e-12);
  EXPECT_NEAR(outside.widths[3], 2.0 * 17 / 16, 1e-12);
  for (const size_t side : {1u, 2u, 4u, 5u}) EXPECT_EQ(outside.widths[side], 0) << side;
}

TEST(OutsideTest, WithoutWidthsNothingChanges) {
  const Lattice lattice = ContinuedLattice({2, 2, 2}, kModes[0], AllWidths(0));
  const OutsideMap map(lattice.structure);
  EXPECT_TRUE(map.is_identity());
  EXPECT_EQ(map.continued(), lattice.structure);
  EXPECT_EQ(map.Continue(lattice.control_points).size(), lattice.control_points.size());
}

TEST(OutsideTest, APlanIsOfTheContinuedLattice) {
  const LatticeStructure s = ContinuedLattice({2, 2, 2}, kModes[0], AllWidths(0.3)).structure;
  const auto mesh = std::make_shared<const PolygonMesh>(*MakeSampleMesh("beam"));
  EXPECT_THAT(MakePlan(mesh, s).status(),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("lattice.outside")));
  EXPECT_TRUE(MakePlan(mesh, OutsideMap(s).continued()).ok());
}

TEST(OutsideTest, RefusesBadWidths) {
  const auto check = [](double width, double step) {
    LatticeStructure s = ContinuedLattice({2, 2, 2}, kModes[0], AllWidths(0.3)).structure;
    s.outside.widths[3] = width;
    s.outside.steps[3] = step;
    return Validate(s);
  };
  EXPECT_TRUE(check(0.3, 0.1).ok());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(check(nan, 0.1),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("lattice.outside.widths[3]")));
  for (const double width : {-0.1, 1e-4, 1e4}) {
    EXPECT_THAT(check(width, 0.1), StatusIs(absl::StatusCode::kInvalidArgument,
                                            HasSubstr("lattice.outside.widths[3]")));
  }
  for (const double step : {0.0, 0.3, -0.1, 0.5, nan}) {
    EXPECT_THAT(check(0.3, step), StatusIs(absl::StatusCode::kInvalidArgument,
                                           HasSubstr("lattice.outside.steps[3]")));
  }
}

TEST(OutsideTest, RefusesAFixedOneWithWidths) {
  LatticeStructure s = ContinuedLattice({2, 2, 2}, kModes[0], AllWidths(0.3)).structure;
  s.outside.mode = OutsideMode::kFixed;
  EXPECT_THAT(Validate(s),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("lattice.outside.mode")));
}

TEST(OutsideTest, RefusesUnclampedKnotsAndTooManyControlPoints) {
  LatticeStructure s = ContinuedLattice({2, 2, 2}, kModes[0], {0, 0, 0, 0, 0, 0.3}).structure;
  s.knots[2].back() += 1;
  EXPECT_THAT(Validate(s), StatusIs(absl::StatusCode::kInvalidArgument,
                                    HasSubstr("lattice.knots_w must end with a knot")));
  s = ContinuedLattice({2, 2, 2}, kModes[0], AllWidths(0.3)).structure;
  s.size = {32, 32, 29};
  for (size_t a = 0; a < 3; ++a) s.knots[a] = ClampedUniformKnots(2, s.size[a]);
  EXPECT_THAT(Validate(s), StatusIs(absl::StatusCode::kInvalidArgument,
                                    HasSubstr("42768 control points, at most 32768")));
}

}  // namespace
}  // namespace latticed
