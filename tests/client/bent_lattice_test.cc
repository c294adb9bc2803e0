// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/geometry/bent_lattice.h"

#include <cmath>
#include <numbers>

#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "client/cpp/library/patches/lattice_from_proto.h"
#include "tests/client/latticectl_fixture.h"

namespace latticed::client {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRounding = 1e-14;

// A lattice of degree 1 around a box whose longest edge is `axis`. Its control points are 0, ±1 or ±4 from (1, 2, 3).
Lattice Box(int axis) {
  Vec3d half{1, 1, 1};
  half[axis] = 4;
  Bounds bounds;
  bounds.Extend(Vec3d{1, 2, 3} - half);
  bounds.Extend(Vec3d{1, 2, 3} + half);
  auto lattice = FitLattice(bounds, {3, 3, 3}, {1, 1, 1}, 0);
  EXPECT_OK(lattice);
  return *std::move(lattice);
}

// The control point (i, j, k) along the longest edge and the next two, minus the centre, in that order.
Vec3d At(const Lattice& lattice, int axis, int i, int j, int k) {
  std::array<int, 3> index{};
  index[static_cast<size_t>(axis)] = i;
  index[static_cast<size_t>((axis + 1) % 3)] = j;
  index[static_cast<size_t>((axis + 2) % 3)] = k;
  const Vec3d p = lattice.control_points[static_cast<size_t>(
                      lattice.structure.Index(index[0], index[1], index[2]))] -
                  Vec3d{1, 2, 3};
  return {p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]};
}

void ExpectNear(Vec3d got, Vec3d wanted) { EXPECT_LE(Norm(got - wanted), 10 * kRounding); }

TEST(BentLatticeTest, NothingChangesWithoutAngles) {
  Lattice lattice = Box(0);
  BendLattice(0, 0, lattice);
  EXPECT_EQ(lattice.control_points, Box(0).control_points);
}

TEST(BentLatticeTest, TwistTurnsTheEndsAgainstEachOther) {
  for (int axis = 0; axis < 3; ++axis) {
    SCOPED_TRACE(axis);
    Lattice lattice = Box(axis);
    BendLattice(kPi, 0, lattice);  // the ends by a quarter turn each
    ExpectNear(At(lattice, axis, 2, 2, 1), {4, 0, 1});
    ExpectNear(At(lattice, axis, 0, 2, 1), {-4, 0, -1});
    ExpectNear(At(lattice, axis, 1, 2, 2), {0, 1, 1});
  }
}

TEST(BentLatticeTest, BendMakesTheEdgeAnArcTowardsThePositiveAxis) {
  for (int axis = 0; axis < 3; ++axis) {
    SCOPED_TRACE(axis);
    Lattice lattice = Box(axis);
    BendLattice(0, kPi, lattice);
    const double radius = 8 / kPi;
    ExpectNear(At(lattice, axis, 1, 1, 1), {0, 0, 0});
    ExpectNear(At(lattice, axis, 2, 1, 1), {radius, 0, radius});
    ExpectNear(At(lattice, axis, 0, 2, 1), {-radius, 1, radius});
    ExpectNear(At(lattice, axis, 2, 1, 2), {radius - 1, 0, radius});  // inside of the arc
    ExpectNear(At(lattice, axis, 1, 1, 2), {0, 0, 1});
  }
}

TEST(BentLatticeTest, TwistComesFirst) {
  Lattice lattice = Box(0);
  BendLattice(kPi, kPi, lattice);
  const double radius = 8 / kPi;
  // At the end, the twist takes (y, z) = (1, 0) to (0, 1), which is 1 inside of the arc.
  ExpectNear(At(lattice, 0, 2, 2, 1), {radius - 1, 0, radius});
}

TEST(BentLatticeTest, ATinyBendIsAlmostNone) {
  Lattice lattice = Box(0);
  BendLattice(0, 1e-12, lattice);
  for (size_t i = 0; i < lattice.control_points.size(); ++i) {
    EXPECT_LE(Norm(lattice.control_points[i] - Box(0).control_points[i]), 1e-11);
  }
}

TEST(BentLatticeTest, TheFirstOfEqualEdgesIsTheLongest) {
  Bounds bounds;
  bounds.Extend(Vec3d{0, 0, 0});
  bounds.Extend(Vec3d{1, 1, 1});
  auto lattice = FitLattice(bounds, {2, 2, 2}, {1, 1, 1}, 0);
  ASSERT_OK(lattice);
  BendLattice(kPi, 0, *lattice);
  ExpectNear(lattice->control_points[0], {0, 0, 1});  // x stays
}

class LatticectlBend : public LatticectlTest {};

TEST_F(LatticectlBend, TakesDegrees) {
  MustRun({"sample", "beam", "-o", Path("beam.obj")});
  MustRun({"lattice", Path("beam.obj"), "--size", "9,3,3", "--degree", "3,2,2", "-o",
           Path("rest.json")});
  MustRun({"lattice", Path("beam.obj"), "--size", "9,3,3", "--degree", "3,2,2", "--twist", "180",
           "--bend", "-90", "-o", Path("L.json")});
  const auto rest = ReadLattice(Path("rest.json"));
  const auto bent = ReadLattice(Path("L.json"));
  ASSERT_OK(rest);
  ASSERT_OK(bent);
  auto expected = FromProto(*rest);
  ASSERT_OK(expected);
  BendLattice(kPi, -kPi / 2, *expected);
  const auto got = FromProto(*bent);
  ASSERT_OK(got);
  EXPECT_EQ(got->control_points, expected->control_points);
  for (const char* angle : {"nan", "inf", "3601", "x"}) {
    const RunResult result = Latticectl({"lattice", "a.obj", "--twist", angle});
    EXPECT_EQ(result.code, 2);
    EXPECT_THAT(result.err, ::testing::HasSubstr("is not an angle of -3600 to 3600 degrees"));
  }
}

}  // namespace
}  // namespace latticed::client
