// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// lattice --turn: the rotation, its order, and what stays exact.
#include "client/cpp/latticectl/geometry/turn_lattice.h"

#include <cmath>
#include <numbers>

#include "client/cpp/latticectl/geometry/bent_lattice.h"
#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "client/cpp/library/patches/lattice_from_proto.h"
#include "tests/client/latticectl_fixture.h"

namespace latticed::client {
namespace {

using ::testing::HasSubstr;

// Around (1, 2, 3), with edges of 2, 4 and 6.
Lattice UnturnedBox() {
  Bounds bounds;
  bounds.Extend(Vec3d{0, 0, 0});
  bounds.Extend(Vec3d{2, 4, 6});
  auto lattice = FitLattice(bounds, {3, 4, 5}, {2, 2, 2}, 0);
  EXPECT_OK(lattice);
  return *std::move(lattice);
}

Vec3d CentreOf(const LatticeFrame& frame) {
  return frame.origin + 0.5 * (frame.edges[0] + frame.edges[1] + frame.edges[2]);
}

TEST(TurnLatticeTest, KeepsEveryBitWithoutAngles) {
  Lattice lattice = UnturnedBox();
  BendLattice(1, 1, lattice);
  const Lattice before = lattice;
  TurnLattice({}, lattice);
  EXPECT_EQ(lattice.structure, before.structure);
  EXPECT_EQ(lattice.control_points, before.control_points);
}

TEST(TurnLatticeTest, QuarterTurnsAreExactAndRightHanded) {
  Lattice about_x = UnturnedBox(), about_y = UnturnedBox(), about_z = UnturnedBox();
  TurnLattice({90, 0, 0}, about_x);
  TurnLattice({0, -270, 0}, about_y);
  TurnLattice({0, 0, 450}, about_z);
  EXPECT_EQ(about_x.structure.frame,
            (LatticeFrame{{0, 5, 1}, {Vec3d{2, 0, 0}, Vec3d{0, 0, 4}, Vec3d{0, -6, 0}}}));
  EXPECT_EQ(about_y.structure.frame,
            (LatticeFrame{{-2, 0, 4}, {Vec3d{0, 0, -2}, Vec3d{0, 4, 0}, Vec3d{6, 0, 0}}}));
  EXPECT_EQ(about_z.structure.frame,
            (LatticeFrame{{3, 1, 0}, {Vec3d{0, 2, 0}, Vec3d{-4, 0, 0}, Vec3d{0, 0, 6}}}));
}

TEST(TurnLatticeTest, TurnsAboutXThenYThenZ) {
  Lattice lattice = UnturnedBox();
  TurnLattice({90, 90, 0}, lattice);
  // x turns y to z, then y turns z to x.
  EXPECT_EQ(lattice.structure.frame.edges[1], (Vec3d{4, 0, 0}));
  lattice = UnturnedBox();
  TurnLattice({0, 90, 90}, lattice);
  // y turns z to x, then z turns x to y.
  EXPECT_EQ(lattice.structure.frame.edges[2], (Vec3d{0, 6, 0}));
}

TEST(TurnLatticeTest, ARestLatticeStaysAtRestBitForBit) {
  Lattice lattice = UnturnedBox();
  TurnLattice({17, -31, 112.5}, lattice);
  EXPECT_EQ(lattice.control_points, IdentityControlPoints(lattice.structure));
  EXPECT_LE(Norm(CentreOf(lattice.structure.frame) - Vec3d{1, 2, 3}), 1e-14);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(Norm(lattice.structure.frame.edges[static_cast<size_t>(axis)]), 2 * (axis + 1),
                1e-14);
  }
}

TEST(TurnLatticeTest, MovedControlPointsTurnWithTheFrame) {
  Lattice bent = UnturnedBox();
  BendLattice(0.5, 1, bent);
  Lattice turned = bent;
  constexpr double kDegrees = 35;
  TurnLattice({0, 0, kDegrees}, turned);
  const double angle = kDegrees * std::numbers::pi / 180;
  const Vec3d middle{1, 2, 3};
  for (size_t i = 0; i < bent.control_points.size(); ++i) {
    const Vec3d from = bent.control_points[i] - middle;
    const Vec3d expected{std::cos(angle) * from.x - std::sin(angle) * from.y,
                         std::sin(angle) * from.x + std::cos(angle) * from.y, from.z};
    EXPECT_LE(Norm(turned.control_points[i] - middle - expected), 1e-13);
  }
}

class LatticectlTurn : public LatticectlTest {};

TEST_F(LatticectlTurn, TurnsABoxAndAFit) {
  MustRun({"sample", "beam", "-o", Path("beam.obj")});
  const auto made = [this](std::vector<std::string> options) {
    options.insert(options.begin(), {"lattice", Path("beam.obj"), "-o", Path("L.json")});
    MustRun(options);
    const auto proto = ReadLattice(Path("L.json"));
    EXPECT_OK(proto);
    return *FromProto(*proto);
  };
  for (const std::vector<std::string>& box :
       {std::vector<std::string>{}, {"--box", "-1,-2,-3,1,2,3", "--outside", "falloff:0.5"}}) {
    Lattice expected = made(box);
    TurnLattice({10, 20, 30}, expected);
    std::vector<std::string> turned = box;
    turned.insert(turned.end(), {"--turn", "10,20,30"});
    const Lattice got = made(turned);
    EXPECT_EQ(got.structure, expected.structure);
    EXPECT_EQ(got.control_points, expected.control_points);
  }
}

TEST_F(LatticectlTurn, RefusesWhatAreNoThreeAngles) {
  for (const char* turn : {"nan,0,0", "0,3601,0", "0,0,x"}) {
    const RunResult result = Latticectl({"lattice", "a.obj", "--turn", turn});
    EXPECT_EQ(result.code, 2);
    EXPECT_THAT(result.err, HasSubstr("is not an angle of -3600 to 3600 degrees"));
  }
  const RunResult two = Latticectl({"lattice", "a.obj", "--turn", "10,20"});
  EXPECT_EQ(two.code, 2);
  EXPECT_THAT(two.err, HasSubstr("--turn"));
  EXPECT_THAT(MustRun({"lattice", "--help"}), HasSubstr("Blender's Euler XYZ"));
}

}  // namespace
}  // namespace latticed::client
