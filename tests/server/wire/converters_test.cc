// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/converters.h"

#include <string>

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr absl::StatusCode kInvalid = absl::StatusCode::kInvalidArgument;

// A lattice whose frame is the unit cube. All else is unset.
v1::Lattice UnitLattice() {
  v1::Lattice lattice;
  lattice.mutable_frame()->mutable_origin();
  lattice.mutable_frame()->mutable_u()->set_x(1);
  lattice.mutable_frame()->mutable_v()->set_y(1);
  lattice.mutable_frame()->mutable_w()->set_z(1);
  return lattice;
}

Lattice SkewLattice() {
  Lattice lattice;
  lattice.structure.degree = {1, 2, 3};
  lattice.structure.size = {2, 4, 5};
  lattice.structure.knots = {
      {{-1, 0, 2, 2.5}, {0, 0, 0, 0.25, 1, 1, 1}, {0, 1, 2, 3, 4, 5, 6, 7, 8}}};
  lattice.structure.frame = {{1, 2, 3}, {{{2, 0.5, 0}, {0, -3, 0}, {0.25, 0, 1e3}}}};
  lattice.control_points = IdentityControlPoints(lattice.structure);
  lattice.control_points[7] = {1e9, -1e-9, 0.1};
  return lattice;
}

TEST(LatticeConverter, RoundTripKeepsEveryBit) {
  const Lattice lattice = SkewLattice();

  const auto back = FromProto(ToProto(lattice), "lattice");

  ASSERT_OK(back);
  EXPECT_EQ(back->structure, lattice.structure);
  EXPECT_EQ(back->control_points, lattice.control_points);
}

TEST(LatticeConverter, RoundTripKeepsWhatGoesOnOutside) {
  Lattice lattice;
  lattice.structure.frame.edges = {Vec3d{1, 0, 0}, Vec3d{0, 2, 0}, Vec3d{0, 0, 3}};
  for (auto& knots : lattice.structure.knots) knots = ClampedUniformKnots(2, 4);
  lattice.control_points = IdentityControlPoints(lattice.structure);
  for (const Outside& outside : {Outside{OutsideMode::kFalloff,
                                         false,
                                         {0, 0.1, 0.2, 0.3, 0.4, 1e3},
                                         {0, 0.05, 0.1, 0.1, 0.3, 7}},
                                 Outside{OutsideMode::kLinear, true, {1, 2, 3, 4, 5, 6}, {}}}) {
    lattice.structure.outside = outside;
    const auto back = FromProto(ToProto(lattice), "lattice");
    ASSERT_OK(back);
    EXPECT_EQ(back->structure, lattice.structure);
  }
  v1::Lattice one = ToProto(lattice);
  one.mutable_outside()->clear_widths();
  one.mutable_outside()->add_widths(0.5);
  EXPECT_EQ(FromProto(one, "lattice")->structure.outside.widths[4], 0.5);
}

TEST(LatticeConverter, JsonHasTheFormThatOtherProgramsWrite) {
  const std::string json = R"({"frame":{"origin":{"x":0,"y":0,"z":0},"u":{"x":1,"y":0,"z":0},
    "v":{"x":0,"y":2,"z":0},"w":{"x":0,"y":0,"z":3}},"degree":{"u":1,"v":1,"w":1},
    "size":{"u":2,"v":2,"w":3},"knotsU":[0,0,1,1],"knotsW":[0,0,0.5,1,1],
    "controlPoints":[0,0,0, 1,0,0, 0,2,0, 1,2,0,  0,0,1, 1,0,1, 0,2,1, 1,2,1,
                     0,0,3, 1,0,3, 0,2,3, 1,2,4]})";
  v1::Lattice message;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(json, &message).ok());

  const auto lattice = FromProto(message, "lattice");

  ASSERT_OK(lattice);
  EXPECT_EQ(lattice->structure.size, (std::array<int, 3>{2, 2, 3}));
  EXPECT_THAT(lattice->structure.knots[1], ElementsAre(0, 0, 1, 1));
  EXPECT_THAT(lattice->structure.knots[2], ElementsAre(0, 0, 0.5, 1, 1));
  EXPECT_EQ(lattice->structure.frame.edges[2], (Vec3d{0, 0, 3}));
  // u runs fastest: point (1, 1, 2) is the last.
  EXPECT_EQ(lattice->control_points[static_cast<size_t>(lattice->structure.Index(1, 0, 0))],
            (Vec3d{1, 0, 0}));
  EXPECT_EQ(lattice->control_points.back(), (Vec3d{1, 2, 4}));
  std::string written;
  ASSERT_TRUE(google::protobuf::util::MessageToJsonString(message, &written).ok());
  for (const char* name : {"\"frame\":{\"origin\":", "\"degree\":{\"u\":1", "\"size\":{\"u\":2",
                           "\"knotsU\":[", "\"knotsW\":[", "\"controlPoints\":["}) {
    EXPECT_THAT(written, HasSubstr(name));
  }
}

TEST(LatticeConverter, UnsetPartsHaveTheDocumentedDefaults) {
  const auto lattice = FromProto(UnitLattice(), "lattice");

  ASSERT_OK(lattice);
  EXPECT_EQ(lattice->structure.degree, (std::array<int, 3>{2, 2, 2}));
  EXPECT_EQ(lattice->structure.size, (std::array<int, 3>{4, 4, 4}));
  EXPECT_THAT(lattice->structure.knots[0], ElementsAre(0, 0, 0, 1, 2, 2, 2));
  ASSERT_EQ(lattice->control_points.size(), 64U);
  // Greville abscissae of the clamped knots on [0, 2]: 0, 1/2, 3/2, 2.
  EXPECT_DOUBLE_EQ(lattice->control_points[1].x, 0.25);
  EXPECT_DOUBLE_EQ(lattice->control_points[63].z, 1.0);
}

TEST(LatticeConverter, FitSurroundsTheMeshWithTheDefaultMargin) {
  Bounds bounds;
  bounds.Extend(Vec3d{0, 0, 0});
  bounds.Extend(Vec3d{10, 4, 0});

  const auto lattice = FromProto(v1::LatticeSource(), bounds, "lattices[0]");

  ASSERT_OK(lattice);
  EXPECT_EQ(lattice->structure.size, (std::array<int, 3>{4, 4, 4}));
  EXPECT_DOUBLE_EQ(lattice->structure.frame.origin.z, -0.5);
  EXPECT_DOUBLE_EQ(lattice->structure.frame.edges[0].x, 11.0);
  EXPECT_DOUBLE_EQ(lattice->structure.frame.edges[2].z, 1.0);
  v1::LatticeSource falloff;
  falloff.mutable_fit()->mutable_outside()->set_mode(v1::OUTSIDE_MODE_FALLOFF);
  falloff.mutable_fit()->mutable_outside()->add_widths(0.3);
  const auto goes_on = FromProto(falloff, bounds, "lattices[0]");
  ASSERT_OK(goes_on);
  EXPECT_EQ(goes_on->structure.outside.widths, (std::array{0.3, 0.3, 0.3, 0.3, 0.3, 0.3}));
  EXPECT_EQ(goes_on->structure.outside.steps[0], 0.125);  // a quarter of the first knot span of 1/2
  EXPECT_EQ(goes_on->control_points, lattice->control_points);
  v1::LatticeSource bad;
  bad.mutable_fit()->set_padding(-1);
  EXPECT_THAT(FromProto(bad, bounds, "lattices[0]"),
              StatusIs(kInvalid, StartsWith("lattices[0].fit.padding")));
}

}  // namespace
}  // namespace latticed
