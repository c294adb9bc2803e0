// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/fold_certifier.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/core/folds/fold_fixtures.h"

namespace latticed {
namespace {

using testing::CubeMesh;
using testing::DrawLattice;
using testing::FoldCase;
using testing::PlanOf;
using testing::TorusMesh;

// 5^3 control points of degree 2, and a torus in its middle layer of knot boxes.
std::shared_ptr<const DeformPlan> TorusPlan() {
  LatticeStructure structure{.degree = {2, 2, 2}, .size = {5, 5, 5}};
  for (auto& knots : structure.knots) knots = ClampedUniformKnots(2, 5);
  structure.frame = {{-2, -2, -2}, {Vec3d{4, 0, 0}, Vec3d{0, 4, 0}, Vec3d{0, 0, 4}}};
  return PlanOf(structure, TorusMesh(12, 6));
}

FoldReport Certify(const FoldCertifier& certifier, std::span<const Vec3d> points) {
  auto report = certifier.Certify(points);
  EXPECT_TRUE(report.ok());
  return *std::move(report);
}

TEST(FoldCertifier, CertifiesTheIdentity) {
  const auto plan = TorusPlan();
  for (const FoldScope scope : {FoldScope::kSurface, FoldScope::kVolume}) {
    const FoldReport report = Certify(FoldCertifier(plan, scope), plan->identity_points);

    EXPECT_TRUE(report.certified());
    EXPECT_EQ(report.boxes, scope == FoldScope::kVolume ? 27 : 9);  // the middle layer
  }
}

TEST(FoldCertifier, NamesTheBoxThePointAndTheDeterminant) {
  const auto plan = TorusPlan();
  std::vector<Vec3d> points = plan->identity_points;
  const auto corner = static_cast<size_t>(plan->structure.Index(4, 4, 0));
  points[corner] += Vec3d{-2, 0, 0};  // beyond its neighbour, in the corner box only

  const FoldReport report = Certify(FoldCertifier(plan, FoldScope::kVolume), points);

  ASSERT_EQ(report.places.size(), 1);
  const FoldedBox& place = report.places[0];
  EXPECT_EQ(place.state, FoldState::kFolded);
  EXPECT_EQ(place.place, (std::array{2, 2, 0}));
  EXPECT_EQ(place.box, 8);
  EXPECT_LE(place.determinant, 0);
  const DeformedPoint there = EvaluateWorld(plan->structure, points, place.rest_point);
  const auto& j = there.jacobian;
  EXPECT_NEAR(Dot(j[0], Cross(j[1], j[2])), place.determinant, 1e-12);
}

TEST(FoldCertifier, TheSurfaceScopeLooksAtThePatchesBoundsOnly) {
  const auto plan = TorusPlan();
  std::vector<Vec3d> points = plan->identity_points;
  points[static_cast<size_t>(plan->structure.Index(4, 4, 0))] += Vec3d{-2, 0, 0};

  const FoldReport report = Certify(FoldCertifier(plan, FoldScope::kSurface), points);

  EXPECT_TRUE(report.certified());
}

TEST(FoldCertifier, AFlattenedLatticeIsFoldedEverywhere) {
  const auto plan = TorusPlan();
  std::vector<Vec3d> points = plan->identity_points;
  for (Vec3d& p : points) p.z = 0.25;

  const FoldReport report = Certify(FoldCertifier(plan, FoldScope::kVolume), points);

  EXPECT_EQ(report.Count(FoldState::kFolded), 27);
  EXPECT_EQ(report.places[0].determinant, 0);
}

TEST(FoldCertifier, AMirrorImageIsFoldedEverywhere) {
  const auto plan = TorusPlan();
  std::vector<Vec3d> points = plan->identity_points;
  for (Vec3d& p : points) p.z = -p.z;

  const FoldReport report = Certify(FoldCertifier(plan, FoldScope::kVolume), points);

  EXPECT_EQ(report.Count(FoldState::kFolded), 27);
  EXPECT_NEAR(report.places[0].determinant, -1, 1e-13);
}

// The faces of the cube lie in faces of the frame: bounds of patches are flat.
TEST(FoldCertifier, LooksAtFlatParts) {
  LatticeStructure structure{.degree = {2, 1, 3}, .size = {4, 3, 5}};
  for (const size_t a : {0u, 1u, 2u}) {
    structure.knots[a] = ClampedUniformKnots(structure.degree[a], structure.size[a]);
  }
  structure.frame = {{0, 0, 0}, {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}};
  const auto plan = PlanOf(structure, testing::FlatGrid(4, 0));
  const FoldCertifier certifier(plan, FoldScope::kSurface);
  EXPECT_EQ(Certify(certifier, plan->identity_points), (FoldReport{.boxes = 4}));
  std::vector<Vec3d> points = plan->identity_points;
  for (size_t i = 0; i < points.size() / 5; ++i)
    points[i].z += 0.7;  // the face, past the next layer

  EXPECT_EQ(Certify(certifier, points).Count(FoldState::kFolded), 4);
}

TEST(FoldCertifier, AMeshOutsideHasNoBoxes) {
  auto structure = TorusPlan()->structure;
  structure.frame.origin = {10, 10, 10};
  const auto plan = PlanOf(structure, TorusMesh(12, 6));

  const FoldReport report =
      Certify(FoldCertifier(plan, FoldScope::kSurface), plan->identity_points);

  EXPECT_EQ(report.boxes, 0);
  EXPECT_TRUE(report.certified());
}

TEST(FoldCertifier, RecertifyLeadsToTheSameReport) {
  for (uint32_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    FoldCase lattice = DrawLattice(seed, seed, 0.3);
    const auto plan = PlanOf(lattice.structure, CubeMesh(3));
    ASSERT_NE(plan, nullptr);
    for (const FoldScope scope : {FoldScope::kSurface, FoldScope::kVolume}) {
      const FoldCertifier certifier(plan, scope);
      FoldReport report = Certify(certifier, lattice.control_points);
      std::mt19937 random(seed);
      std::uniform_real_distribution<double> uniform(-0.3, 0.3);
      for (int edit = 0; edit < 20; ++edit) {
        std::vector<uint32_t> changed;
        for (size_t n = random() % 3 + 1; n-- > 0;) {
          changed.push_back(static_cast<uint32_t>(random() % lattice.control_points.size()));
          lattice.control_points[changed.back()] +=
              Vec3d{uniform(random), uniform(random), uniform(random)};
        }
        report = certifier.Recertify(report, changed, lattice.control_points);
        ASSERT_EQ(report, Certify(certifier, lattice.control_points));
      }
    }
  }
}

TEST(FoldCertifier, PlacesCountIntervalsThatAreNotEmpty) {
  LatticeStructure structure{.degree = {1, 2, 1}, .size = {3, 5, 4}};
  structure.knots = {
      std::vector<double>{0, 0, 1, 2, 2}, {0, 0, 0, 1, 1, 2, 2, 2}, {0, 0, 1, 2, 3, 3}};
  structure.frame = {{0, 0, 0}, {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}};
  const auto plan = PlanOf(structure, CubeMesh(2));
  std::vector<Vec3d> points = plan->identity_points;
  for (Vec3d& p : points) p.x = -p.x;

  const FoldReport report = Certify(FoldCertifier(plan, FoldScope::kVolume), points);

  ASSERT_EQ(report.places.size(), 12);
  for (int i = 0; i < 12; ++i) {
    EXPECT_EQ(report.places[static_cast<size_t>(i)].place, (std::array{i % 2, i / 2 % 2, i / 4}));
  }
}

TEST(FoldCertifier, StopsWhenTold) {
  const auto plan = TorusPlan();
  const auto report = FoldCertifier(plan, FoldScope::kVolume).Certify(plan->identity_points, [] {
    return absl::CancelledError();
  });
  EXPECT_TRUE(absl::IsCancelled(report.status()));
}

TEST(FoldReport, ANewFoldIsABoxThatGetsWorse) {
  const FoldedBox folded{.box = 3}, undecided{.box = 3, .state = FoldState::kUndecided},
      neighbour{.box = 4};
  const FoldReport none, one{.places = {folded}}, unsure{.places = {undecided}},
      two{.places = {folded, neighbour}};

  EXPECT_EQ(NewFold(none, none), nullptr);
  EXPECT_EQ(NewFold(one, one), nullptr);
  EXPECT_EQ(NewFold(one, none), nullptr);
  EXPECT_EQ(NewFold(one, unsure), nullptr);
  EXPECT_EQ(NewFold(two, one), nullptr);
  EXPECT_EQ(NewFold(none, one)->box, 3);
  EXPECT_EQ(NewFold(none, unsure)->box, 3);
  EXPECT_EQ(NewFold(unsure, one)->box, 3);
  EXPECT_EQ(NewFold(one, two)->box, 4);
}

}  // namespace
}  // namespace latticed
