// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Sums of lattices, compared with the sum of their displacements by formula (1), and their refusals.
#include "core/ffd/sum/lattice_sum.h"

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "core/ffd/outside/outside_map.h"
#include "core/ffd/outside/outside_rules.h"
#include "core/ffd/sum/lattice_groups.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::HasSubstr;

constexpr uint64_t kSumSeed = 20261130;
constexpr std::array<Vec3d, 3> kEdges{Vec3d{2, 0, 0.3}, Vec3d{0, 3, 0}, Vec3d{0.1, 0, 1}};

std::array<int, 3> DegreeOf(int mix) { return {1 + mix % 3, 1 + mix / 3 % 3, 1 + mix / 9}; }

// A lattice over the box from `low` to `high` of the parallelepiped kEdges.
Lattice LatticeOver(Vec3d low, Vec3d high, std::array<int, 3> degree, std::array<int, 3> size,
                    Outside outside = {}) {
  Lattice lattice;
  LatticeStructure& s = lattice.structure;
  s.degree = degree;
  s.size = size;
  s.frame.origin = low.x * kEdges[0] + low.y * kEdges[1] + low.z * kEdges[2];
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<size_t>(a);
    s.frame.edges[axis] = (high[a] - low[a]) * kEdges[axis];
    s.knots[axis] = ClampedUniformKnots(degree[axis], size[axis]);
  }
  s.outside = outside;
  s.outside = ResolvedOutside(s, {});
  lattice.control_points = IdentityControlPoints(s);
  return lattice;
}

absl::StatusOr<LatticeSum> SumAll(const std::vector<LatticeStructure>& lattices,
                                  std::span<const Vec3d> mesh) {
  std::vector<size_t> members(lattices.size());
  std::iota(members.begin(), members.end(), size_t{0});
  return SumLattices(lattices, mesh, members);
}

void ShakeLattice(Lattice& lattice, std::mt19937_64& random) {
  std::uniform_real_distribution<double> move(-0.4, 0.4);
  for (Vec3d& p : lattice.control_points) p += Vec3d{move(random), move(random), move(random)};
}

// Points of the unit box of kEdges, the mesh of these tests, with its corners.
std::vector<Vec3d> MeshPoints(std::mt19937_64& random, int count) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Vec3d> points;
  for (int n = 0; n < count + 8; ++n) {
    const Vec3d place = n < 8 ? Vec3d{double(n & 1), double(n >> 1 & 1), double(n >> 2)}
                              : Vec3d{unit(random), unit(random), unit(random)};
    points.push_back(place.x * kEdges[0] + place.y * kEdges[1] + place.z * kEdges[2]);
  }
  return points;
}

std::vector<LatticeStructure> StructuresOf(const std::vector<Lattice>& lattices) {
  std::vector<LatticeStructure> structures;
  for (const Lattice& lattice : lattices) structures.push_back(lattice.structure);
  return structures;
}

DeformedPoint Continued(const Lattice& lattice, Vec3d p) {
  const OutsideMap map(lattice.structure);
  return EvaluateWorld(map.continued(), map.Continue(lattice.control_points), p);
}

// What the other lattices move the control points of the sum, if `last` is left out.
std::shared_ptr<const std::vector<Vec3d>> OthersOf(const std::vector<Lattice>& lattices,
                                                   const LatticeSum& sum, size_t last) {
  auto others = std::make_shared<std::vector<Vec3d>>(
      static_cast<size_t>(sum.structure.control_point_count()));
  for (size_t k = 0; k < lattices.size(); ++k) {
    if (k == last) continue;
    const Lattice& lattice = lattices[k];
    const OutsideMap map(lattice.structure, 1, sum.structure, sum.parts[k]);
    const std::vector<Vec3d> points = map.Continue(lattice.control_points);
    const std::vector<Vec3d> rest = IdentityControlPoints(sum.structure);
    for (size_t i = 0; i < rest.size(); ++i) (*others)[i] += points[i] - rest[i];
  }
  return others;
}

// Compares the sum with its definition at some points, with the last lattice's strength of `strength`.
void ExpectSum(const std::vector<Lattice>& lattices, double strength,
               const std::vector<Vec3d>& mesh, const std::vector<Vec3d>& at, double& worst) {
  const auto sum = SumAll(StructuresOf(lattices), mesh);
  ASSERT_TRUE(sum.ok()) << sum.status();
  ASSERT_TRUE(Validate(sum->structure).ok()) << Validate(sum->structure);
  const size_t last = lattices.size() - 1;
  OutsideMap map(lattices[last].structure, strength, sum->structure, sum->parts[last]);
  map.AddOthers(OthersOf(lattices, *sum, last));
  const std::vector<Vec3d> points = map.Continue(lattices[last].control_points);
  for (const Vec3d p : at) {
    Vec3d want = p;
    std::array<Vec3d, 3> jacobian{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
    const std::array<Vec3d, 3> identity = jacobian;
    for (size_t k = 0; k < lattices.size(); ++k) {
      const DeformedPoint one = Continued(lattices[k], p);
      const double s = k == last ? strength : 1;
      want += s * (one.position - p);
      for (size_t c = 0; c < 3; ++c) jacobian[c] += s * (one.jacobian[c] - identity[c]);
    }
    const DeformedPoint got = EvaluateWorld(sum->structure, points, p);
    worst = std::max(worst, Norm(got.position - want));
    for (size_t c = 0; c < 3; ++c) ASSERT_LT(Norm(got.jacobian[c] - jacobian[c]), 1e-11);
  }
}

TEST(LatticeSumTest, IsTheSumOfDisplacementsAtEveryMixOfDegrees) {
  SCOPED_TRACE(kSumSeed);
  std::mt19937_64 random(kSumSeed);
  double worst = 0;
  for (int mix = 0; mix < 27; ++mix) {
    for (int other = 0; other < 27; ++other) {
      std::vector<Lattice> lattices{
          LatticeOver({-0.1, -0.1, -0.1}, {1.1, 1.1, 1.1}, DegreeOf(mix), {5, 4, 6}),
          LatticeOver({-0.05, -0.2, -0.1}, {1.3, 1.1, 1.01}, DegreeOf(other), {4, 5, 4})};
      for (Lattice& lattice : lattices) ShakeLattice(lattice, random);
      const std::vector<Vec3d> mesh = MeshPoints(random, 20);
      ExpectSum(lattices, 1, mesh, mesh, worst);
      if (HasFatalFailure()) FAIL() << mix << " and " << other;
    }
  }
  EXPECT_LT(worst, 1e-14 * 6);  // of the diagonal
}

TEST(LatticeSumTest, SpotsFadeOutInsideTheMesh) {
  SCOPED_TRACE(kSumSeed);
  std::mt19937_64 random(kSumSeed);
  double worst = 0;
  for (int mix = 0; mix < 27; ++mix) {
    for (const bool smooth : {true, false}) {
      const Outside outside{OutsideMode::kFalloff, smooth, {0.3, 0.3, 0.2, 0.4, 0.3, 0.3}, {}};
      std::vector<Lattice> lattices{
          LatticeOver({-0.1, -0.1, -0.1}, {1.1, 1.1, 1.1}, {2, 2, 2}, {4, 4, 4}),
          LatticeOver({0.2, 0.3, 0.2}, {0.5, 0.6, 0.6}, DegreeOf(mix), {4, 4, 5}, outside),
          LatticeOver({0.6, 0.3, 0.5}, {0.9, 0.6, 0.9}, {2, 1, 2}, {4, 2, 3}, outside)};
      for (Lattice& lattice : lattices) ShakeLattice(lattice, random);
      const std::vector<Vec3d> mesh = MeshPoints(random, 200);
      ExpectSum(lattices, 0.3, mesh, mesh, worst);
      if (HasFatalFailure()) FAIL() << mix;
    }
  }
  EXPECT_LT(worst, 2e-14 * 6);
}

// As points of the flow around a body.
TEST(LatticeSumTest, LatticesThatFadeOutMovePointsBeyondTheMesh) {
  SCOPED_TRACE(kSumSeed);
  std::mt19937_64 random(kSumSeed);
  const Outside outside{OutsideMode::kFalloff, true, {0.3, 0.3, 0.2, 0.4, 0.3, 0.3}, {}};
  std::vector<Lattice> lattices{
      LatticeOver({-0.2, -0.2, -0.2}, {1.1, 1.2, 1.2}, {2, 2, 2}, {4, 4, 4}, outside),
      LatticeOver({-0.4, 0.3, 0.2}, {0.5, 1.4, 0.6}, {3, 1, 2}, {4, 4, 5}, outside)};
  for (Lattice& lattice : lattices) ShakeLattice(lattice, random);
  std::vector<Vec3d> corners = MeshPoints(random, 0), flow;
  std::uniform_real_distribution<double> place(-1, 2.5);
  for (int n = 0; n < 400; ++n) {
    flow.push_back(place(random) * kEdges[0] + place(random) * kEdges[1] +
                   place(random) * kEdges[2]);
  }
  double worst = 0;
  ExpectSum(lattices, 0.7, corners, flow, worst);
  EXPECT_LT(worst, 2e-14 * 6);
}

TEST(LatticeSumTest, ALatticeAndItselfKeepTheKnots) {
  const Lattice lattice = LatticeOver({0, 0, 0}, {1, 1, 1}, {1, 2, 3}, {3, 5, 6});
  const std::vector<LatticeStructure> twice{lattice.structure, lattice.structure};
  const std::vector<Vec3d> mesh{{0.5, 1, 0.4}};
  const auto sum = SumAll(twice, mesh);
  ASSERT_TRUE(sum.ok()) << sum.status();
  EXPECT_EQ(sum->structure.knots, lattice.structure.knots);
  EXPECT_EQ(sum->structure.degree, lattice.structure.degree);
  for (size_t a = 0; a < 3; ++a) {
    EXPECT_LT(Norm(sum->structure.frame.edges[a] - kEdges[a]), 1e-15);
  }
  for (const RefinedAxes& part : sum->parts) {
    for (const std::vector<RefinedPoint>& axis : part) {
      for (size_t i = 0; i < axis.size(); ++i) {
        for (int k = 0; k < axis[i].count; ++k) {
          EXPECT_EQ(axis[i].weight[static_cast<size_t>(k)],
                    axis[i].first + k == static_cast<int>(i) ? 1 : 0);
        }
      }
    }
  }
}

TEST(LatticeSumTest, LatticesAtRestLeaveTheOtherAsItIs) {
  SCOPED_TRACE(kSumSeed);
  std::mt19937_64 random(kSumSeed);
  std::vector<Lattice> lattices{
      LatticeOver({-0.1, -0.1, -0.1}, {1.1, 1.1, 1.1}, {2, 2, 2}, {5, 5, 5}),
      LatticeOver({-0.3, -0.1, -0.1}, {1.2, 1.1, 1.1}, {3, 1, 2}, {5, 4, 6})};
  const std::vector<Vec3d> mesh = MeshPoints(random, 0);
  const auto sum = SumAll(StructuresOf(lattices), mesh);
  ASSERT_TRUE(sum.ok()) << sum.status();
  OutsideMap map(lattices[1].structure, 1, sum->structure, sum->parts[1]);
  map.AddOthers(OthersOf(lattices, *sum, 1));
  EXPECT_EQ(map.Continue(lattices[1].control_points), IdentityControlPoints(sum->structure));
}

TEST(LatticeSumTest, TheTransposeIsTheTranspose) {
  SCOPED_TRACE(kSumSeed);
  std::mt19937_64 random(kSumSeed);
  const Outside outside{OutsideMode::kFalloff, true, {0.3, 0.3, 0.3, 0.3, 0.3, 0.3}, {}};
  const std::vector<Lattice> lattices{
      LatticeOver({-0.1, -0.1, -0.1}, {1.1, 1.1, 1.1}, {2, 2, 2}, {5, 5, 5}),
      LatticeOver({0.2, 0.3, 0.2}, {0.5, 0.6, 0.6}, {3, 1, 2}, {5, 4, 6}, outside)};
  const auto sum = SumAll(StructuresOf(lattices), MeshPoints(random, 0));
  ASSERT_TRUE(sum.ok()) << sum.status();
  const OutsideMap map(lattices[1].structure, 0.7, sum->structure, sum->parts[1]);
  std::uniform_real_distribution<double> move(-1, 1);
  std::vector<Vec3d> d(lattices[1].control_points.size());
  std::vector<Vec3d> g(static_cast<size_t>(sum->structure.control_point_count()));
  for (Vec3d& v : d) v = {move(random), move(random), move(random)};
  for (Vec3d& v : g) v = {move(random), move(random), move(random)};
  const std::vector<Vec3d> forward = map.Apply(d), back = map.ApplyTransposed(g);
  double one = 0, other = 0, by_sources = 0;
  for (size_t i = 0; i < g.size(); ++i) {
    one += Dot(forward[i], g[i]);
    map.ForSources(i, [&](size_t source, double w) { by_sources += w * Dot(d[source], g[i]); });
  }
  for (size_t i = 0; i < d.size(); ++i) other += Dot(d[i], back[i]);
  EXPECT_NEAR(one, other, 1e-12 * std::abs(one));
  EXPECT_NEAR(one, by_sources, 1e-12 * std::abs(one));
}

TEST(LatticeSumTest, KnotsThatAlmostMeetAreOnePlane) {
  Lattice one = LatticeOver({0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {5, 5, 5});  // knots at thirds
  const Lattice other = LatticeOver({0, 0, 0}, {1.0 / 3 * 3, 1, 1}, {3, 2, 1}, {6, 5, 4});
  one.structure.frame.edges[0] = (1 + 1e-14) * one.structure.frame.edges[0];
  const std::vector<LatticeStructure> both{one.structure, other.structure};
  const std::vector<Vec3d> mesh{{0.5, 1, 0.4}};
  const auto sum = SumAll(both, mesh);
  ASSERT_TRUE(sum.ok()) << sum.status();
  // Degree 3: the quadratic's two knots are double.
  EXPECT_EQ(sum->structure.knots[0].size(), 4U + 2 * 2 + 4);
  EXPECT_EQ(sum->structure.knots[1], one.structure.knots[1]);
}

TEST(LatticeGroupsTest, TurnedFramesAreGroupsOfTheirOwn) {
  const Lattice one = LatticeOver({0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {4, 4, 4});
  const Lattice larger = LatticeOver({-1, -1, -1}, {2, 2, 2}, {1, 1, 1}, {2, 2, 2});
  Lattice sheared = larger, mirrored = larger;
  sheared.structure.frame.edges[0] += Vec3d{0, 0.01, 0};
  mirrored.structure.frame.origin += mirrored.structure.frame.edges[1];
  mirrored.structure.frame.edges[1] = -mirrored.structure.frame.edges[1];
  const std::vector<LatticeStructure> all{one.structure, sheared.structure, larger.structure,
                                          mirrored.structure, sheared.structure};
  const std::vector<Vec3d> mesh{{0.5, 1, 0.4}};
  const auto groups = GroupLattices(all, mesh);
  ASSERT_TRUE(groups.ok()) << groups.status();
  ASSERT_EQ(groups->size(), 3u);
  EXPECT_EQ((*groups)[0].members, (std::vector<size_t>{0, 2}));
  EXPECT_EQ((*groups)[1].members, (std::vector<size_t>{1, 4}));
  EXPECT_EQ((*groups)[2].members, (std::vector<size_t>{3}));
  EXPECT_EQ((*groups)[2].sum.structure, mirrored.structure);
}

// Alone, a lattice may end inside the mesh. Beside others the surface would tear where others move it.
TEST(LatticeGroupsTest, ATurnedLatticeThatEndsInTheMeshMustFadeOut) {
  std::mt19937_64 random(kSumSeed);
  const std::vector<Vec3d> mesh = MeshPoints(random, 0);
  const Lattice one = LatticeOver({0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {4, 4, 4});
  Lattice spot = LatticeOver({0.2, 0.2, 0.2}, {0.6, 0.6, 0.6}, {2, 2, 2}, {4, 4, 4});
  spot.structure.frame.edges[2] += Vec3d{0.1, 0, 0};
  std::vector<LatticeStructure> both{one.structure, spot.structure};
  EXPECT_THAT(GroupLattices(both, mesh).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("lattices[1].outside: the lattice ends inside the mesh")));
  both[1].outside = {OutsideMode::kFalloff, true, {0.3, 0.3, 0.3, 0.3, 0.3, 0.3}, {}};
  both[1].outside = ResolvedOutside(both[1], {});
  EXPECT_TRUE(GroupLattices(both, mesh).ok());
}

TEST(LatticeGroupsTest, AMapOfOneGroupLeavesTheOthersAtRest) {
  std::mt19937_64 random(kSumSeed);
  const std::vector<Vec3d> mesh = MeshPoints(random, 0);
  Lattice one = LatticeOver({0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {4, 4, 4});
  Lattice other = LatticeOver({-1, -1, -1}, {2, 2, 2}, {2, 1, 2}, {4, 3, 4});
  other.structure.frame.edges[2] += Vec3d{0.1, 0, 0};
  ShakeLattice(other, random);
  auto rest = std::make_shared<std::vector<Vec3d>>(one.control_points);
  const std::vector<Vec3d> own = IdentityControlPoints(other.structure);
  rest->insert(rest->end(), own.begin(), own.end());
  OutsideMap map(other.structure, 0.5);
  const size_t first = one.control_points.size(), count = own.size();
  map.PlaceAmong(first, rest);
  ASSERT_EQ(map.planned_count(), first + count);
  const std::vector<Vec3d> planned = map.Continue(other.control_points);
  for (size_t i = 0; i < first; ++i) EXPECT_EQ(planned[i], (*rest)[i]);
  for (size_t i = 0; i < count; ++i) {
    const Vec3d halfway = 0.5 * own[i] + 0.5 * other.control_points[i];
    EXPECT_LE(Norm(planned[first + i] - halfway), 1e-14);
  }
  std::vector<Vec3d> gradient(first + count, Vec3d{1, 2, 3});
  EXPECT_EQ(map.ApplyTransposed(gradient), std::vector<Vec3d>(count, Vec3d{0.5, 1, 1.5}));
  map.ForSources(first - 1, [](size_t, double) { ADD_FAILURE() << "of the other lattice"; });
  map.ForSources(first + 2, [](size_t source, double weight) {
    EXPECT_EQ(source, 2u);
    EXPECT_EQ(weight, 0.5);
  });
}

TEST(LatticeSumTest, RefusesALatticeThatEndsInTheMesh) {
  std::mt19937_64 random(kSumSeed);
  const Lattice one = LatticeOver({0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {4, 4, 4});
  const Lattice spot = LatticeOver({0, 0.2, 0}, {1, 1, 1}, {2, 2, 2}, {4, 4, 4});
  const std::vector<LatticeStructure> both{one.structure, spot.structure};
  EXPECT_THAT(SumAll(both, MeshPoints(random, 0)).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("lattices[1].outside: the lattice ends inside the mesh, at the "
                                 "begin of v")));
}

TEST(LatticeSumTest, RefusesASumOfTooManyControlPoints) {
  std::mt19937_64 random(kSumSeed);
  const Lattice one = LatticeOver({-0.2, -0.2, -0.2}, {1.1, 1.2, 1.3}, {2, 2, 2}, {25, 25, 25});
  const Lattice other = LatticeOver({-0.1, -0.1, -0.1}, {1.1, 1.1, 1.1}, {1, 1, 1}, {20, 20, 20});
  const std::vector<LatticeStructure> both{one.structure, other.structure};
  EXPECT_THAT(SumAll(both, MeshPoints(random, 0)).status(),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("lattices: their sum has")));
}

}  // namespace
}  // namespace latticed
