// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lattices: refusals with their fields, fitting, the identity and frames.
#include "core/ffd/lattice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "core/base/error.h"
#include "core/ffd/bspline_basis.h"
#include "core/ffd/direct_ffd.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::testing::HasSubstr;
using testing::StatusIs;
constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

Bounds UnitBox() {
  Bounds bounds;
  bounds.Extend(Vec3d{0, 0, 0});
  bounds.Extend(Vec3d{1, 2, 3});
  return bounds;
}

Lattice Fitted() {
  auto lattice = FitLattice(UnitBox(), {5, 4, 6}, {2, 1, 3}, 0.1);
  EXPECT_OK(lattice);
  return *std::move(lattice);
}

std::string FieldOf(const absl::Status& status) { return error::DetailsOf(status).field; }

TEST(Lattice, FitsWithPaddingOfTheLongestEdgeOnEverySide) {
  const Lattice lattice = Fitted();
  const LatticeStructure& s = lattice.structure;

  EXPECT_DOUBLE_EQ(s.frame.origin.x, -0.3);
  EXPECT_DOUBLE_EQ(s.frame.origin.z, -0.3);
  EXPECT_DOUBLE_EQ(s.frame.edges[0].x, 1.6);
  EXPECT_DOUBLE_EQ(s.frame.edges[2].z, 3.6);
  EXPECT_EQ(s.knots[0], (std::vector<double>{0, 0, 0, 1, 2, 3, 3, 3}));
  EXPECT_EQ(lattice.control_points.size(), 5u * 4 * 6);
  EXPECT_OK(Validate(lattice));
}

TEST(Lattice, IdentityReproducesTheWorldInObliqueMirroredFrames) {
  LatticeStructure s = Fitted().structure;
  s.frame = {{7, -3, 2}, {Vec3d{-2, 0.3, 0.1}, Vec3d{0.2, 1.5, 0.4}, Vec3d{0.1, 0.2, 3}}};
  s.knots[0] = {-1, 0, 0.5, 1.25, 3, 4, 4.5, 6};  // unclamped, uneven
  ASSERT_OK(Validate(s));
  const std::vector<Vec3d> points = IdentityControlPoints(s);
  const FrameMap map(s);
  for (double u : {0.0, 0.3, 1.0}) {
    for (double v : {0.0, 0.7, 1.0}) {
      const Vec3d world =
          s.frame.origin + u * s.frame.edges[0] + v * s.frame.edges[1] + 0.4 * s.frame.edges[2];
      EXPECT_LT(Norm(map.ToWorld(map.ToParameter(world)) - world), 1e-14);
      EXPECT_LT(Norm(EvaluateWorld(s, points, world).position - world), 1e-14);
    }
  }
}

TEST(Lattice, MissingKnotsAreClampedAndUniform) {
  EXPECT_EQ(KnotsOrDefault({}, 2, 4), (std::vector<double>{0, 0, 0, 1, 2, 2, 2}));
  const std::vector<double> given{7, 3};  // Validate checks what is given
  EXPECT_EQ(KnotsOrDefault(given, 2, 4), given);
  for (const auto& [degree, size] :
       {std::pair{0, 4}, {4, 5}, {2, 2}, {2, -1}, {2, 2'000'000'000}}) {
    EXPECT_TRUE(KnotsOrDefault({}, degree, size).empty()) << degree << ", " << size;
  }
}

TEST(Lattice, PointsAreReadFromAFlatList) {
  const std::vector<double> flat{1, 2, 3, 4, 5, 6};
  const auto points = PointsFromFlat(flat, 2, "field");
  ASSERT_OK(points);
  EXPECT_EQ(*points, (std::vector<Vec3d>{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_THAT(PointsFromFlat(flat, 1, "field").status(),
              StatusIs(kInvalid, HasSubstr("field: got 2")));
  EXPECT_THAT(PointsFromFlat(std::span(flat).first(5), 2, "field").status(),
              StatusIs(kInvalid, HasSubstr("got 5 numbers, x y z per point are needed")));
  const std::vector<double> infinite{1, 2, INFINITY};
  EXPECT_EQ(FieldOf(PointsFromFlat(infinite, 2, "field").status()), "field");
}

TEST(Lattice, RefusesBadFits) {
  EXPECT_EQ(FieldOf(FitLattice(UnitBox(), {2, 4, 4}, {2, 2, 2}, 0).status()), "fit.size.u");
  EXPECT_EQ(FieldOf(FitLattice(UnitBox(), {4, 4, 4}, {2, 4, 2}, 0).status()), "fit.degree.v");
  EXPECT_EQ(FieldOf(FitLattice(UnitBox(), {4, 4, 4}, {2, 2, 0}, 0).status()), "fit.degree.w");
  EXPECT_EQ(FieldOf(FitLattice(UnitBox(), {33, 32, 32}, {2, 2, 2}, 0).status()), "fit.size");
  EXPECT_EQ(FieldOf(FitLattice(UnitBox(), {4, 4, 4}, {2, 2, 2}, -0.1).status()), "fit.padding");
  EXPECT_EQ(FieldOf(FitLattice(UnitBox(), {4, 4, 4}, {2, 2, 2}, NAN).status()), "fit.padding");
}

TEST(Lattice, FlatMeshesNeedPadding) {
  Bounds flat;
  flat.Extend(Vec3d{0, 0, 1});
  flat.Extend(Vec3d{2, 1, 1});
  EXPECT_THAT(FitLattice(flat, {4, 4, 4}, {2, 2, 2}, 0), StatusIs(kInvalid, HasSubstr("flat")));
  ASSERT_OK_AND_ASSIGN(const auto fitted, FitLattice(flat, {4, 4, 4}, {2, 2, 2}, 0.05));
  EXPECT_DOUBLE_EQ(fitted.structure.frame.edges[2].z, 0.2);
}

TEST(Lattice, RefusesBadStructuresNamingTheField) {
  const auto refused = [](auto change) {
    Lattice lattice = Fitted();
    change(lattice);
    const absl::Status status = Validate(lattice);
    EXPECT_EQ(status.code(), kInvalid);
    return FieldOf(status);
  };
  EXPECT_EQ(refused([](Lattice& l) { l.structure.degree[0] = 0; }), "lattice.degree.u");
  EXPECT_EQ(refused([](Lattice& l) { l.structure.degree[2] = 4; }), "lattice.degree.w");
  EXPECT_EQ(refused([](Lattice& l) { l.structure.size[1] = 1; }), "lattice.size.v");
  EXPECT_EQ(refused([](Lattice& l) { l.structure.size = {40, 40, 40}; }), "lattice.size");
  EXPECT_EQ(refused([](Lattice& l) { l.structure.knots[0].pop_back(); }), "lattice.knots_u");
  EXPECT_EQ(refused([](Lattice& l) { l.structure.knots[1][2] = INFINITY; }), "lattice.knots_v");
  EXPECT_EQ(refused([](Lattice& l) { l.structure.knots[0][4] = 0.5; }), "lattice.knots_u");
  EXPECT_EQ(refused([](Lattice& l) { l.structure.knots[1] = {0, 0, 1, 1, 2, 2}; }),
            "lattice.knots_v");  // interior multiplicity 2 at degree 1
  EXPECT_EQ(refused([](Lattice& l) { l.structure.knots[1].assign(6, 3.0); }), "lattice.knots_v");
  EXPECT_EQ(refused([](Lattice& l) { l.structure.frame.origin.x = NAN; }), "lattice.frame.origin");
  EXPECT_EQ(refused([](Lattice& l) { l.structure.frame.edges[1].y = INFINITY; }),
            "lattice.frame.v");
  EXPECT_EQ(refused([](Lattice& l) { l.structure.frame.edges[1] = l.structure.frame.edges[0]; }),
            "lattice.frame");
  EXPECT_EQ(refused([](Lattice& l) { l.control_points.pop_back(); }), "lattice.control_points");
  EXPECT_EQ(refused([](Lattice& l) { l.control_points[7].z = NAN; }), "lattice.control_points");
  EXPECT_EQ(refused([](Lattice& l) { l.control_points[7].z = 1e19; }), "lattice.control_points");
  EXPECT_EQ(refused([](Lattice& l) { l.structure.frame.origin.y = -1e19; }),
            "lattice.frame.origin");
}

TEST(BsplineBasis, LowerSpanOwnsItsUpperKnot) {
  const std::vector<double> knots{0, 0, 0, 1, 1, 2, 3, 3, 3};  // degree 2, size 6, double knot at 1
  EXPECT_EQ(FindLowerSpan(knots.data(), 2, 6, 0.0), 2);
  EXPECT_EQ(FindLowerSpan(knots.data(), 2, 6, 1.0), 2);
  EXPECT_EQ(FindLowerSpan(knots.data(), 2, 6, 1.5), 4);
  EXPECT_EQ(FindLowerSpan(knots.data(), 2, 6, 2.0), 4);
  EXPECT_EQ(FindLowerSpan(knots.data(), 2, 6, 3.0), 5);
}

}  // namespace
}  // namespace latticed
