// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The least move that restores a volume.
#include "core/measure/kept_volume.h"

#include <cmath>
#include <memory>
#include <utility>

#include "core/base/error.h"
#include "core/measure/enclosed_volume.h"
#include "core/measure/surface_closure.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

std::shared_ptr<const SurfaceMoments> MomentsFor(PolygonMesh mesh, const LatticeOptions& options) {
  const auto structure = MakeStructure(mesh.ComputeBounds(), options);
  return *SurfaceMoments::Make(
      *MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), structure),
      SurfaceMoments::Order::kVolume);
}

// Control points at rest, of which a corner region was pulled out: the edit.
struct Pulled {
  explicit Pulled(const SurfaceMoments& moments)
      : points(moments.plan().identity_points), named(points.size()) {
    for (size_t i = 0; i < points.size() / 2; ++i) {
      points[i] += Vec3d{0.2, 0.1 * std::sin(static_cast<double>(i)), -0.3};
      named[i] = true;
    }
  }
  std::vector<Vec3d> points;
  std::vector<bool> named;
};

double ErrorOf(const SurfaceMoments& moments, const std::vector<Vec3d>& points) {
  return std::abs(MeasureVolume(moments, points).volume / RestVolume(moments) - 1);
}

TEST(KeptVolumeTest, RestoresTheRestVolumeByTheOtherPoints) {
  for (int degree = 1; degree <= 3; ++degree) {
    const auto moments =
        MomentsFor(TorusMesh(20, 12), {.degree = {degree, degree, degree}, .extra = {2, 2, 2}});
    Pulled edit(*moments);
    const auto before = edit.points;
    ASSERT_GT(ErrorOf(*moments, before), 1e-3);

    const int steps = *KeepVolume(*moments, {}, nullptr, edit.named, edit.points);

    EXPECT_LE(steps, kMostVolumeSteps);
    EXPECT_LE(ErrorOf(*moments, edit.points), kVolumeTolerance);
    for (size_t i = 0; i < before.size(); ++i) {
      if (edit.named[i]) {
        EXPECT_EQ(edit.points[i], before[i]);
      }
    }
  }
}

// At the least move it is parallel to the gradient: no other move of the same length restores as much.
TEST(KeptVolumeTest, MovesTheLeast) {
  const auto moments = MomentsFor(TorusMesh(20, 12), {});
  Pulled edit(*moments);
  const auto before = edit.points;
  const std::vector<bool> none(before.size());

  ASSERT_TRUE(KeepVolume(*moments, {}, nullptr, none, edit.points).ok());

  const auto gradient = MeasureVolume(*moments, edit.points).gradient;
  double along = 0, move2 = 0, gradient2 = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    const Vec3d move = edit.points[i] - before[i];
    along += Dot(move, gradient[i]);
    move2 += Dot(move, move);
    gradient2 += Dot(gradient[i], gradient[i]);
  }
  EXPECT_NEAR(std::abs(along) / std::sqrt(move2 * gradient2), 1, 1e-10);
}

TEST(KeptVolumeTest, AlongOneAxisTakesOneStep) {
  const auto moments = MomentsFor(TorusMesh(20, 12), {.shear = 0.2});
  Pulled edit(*moments);
  const auto before = edit.points;
  const Vec3d edge = moments->plan().structure.frame.edges[1];

  const int steps = *KeepVolume(*moments, {.axis = 1}, nullptr, edit.named, edit.points);

  EXPECT_LE(steps, 2);  // a second one for rounding
  EXPECT_LE(ErrorOf(*moments, edit.points), kVolumeTolerance);
  for (size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR(Norm(Cross(edit.points[i] - before[i], edge)), 0, 1e-14);
  }
}

TEST(KeptVolumeTest, RestoresAGivenVolume) {
  const auto moments = MomentsFor(TorusMesh(20, 12), {});
  const double volume = 1.5 * RestVolume(*moments);
  auto points = moments->plan().identity_points;

  ASSERT_TRUE(
      KeepVolume(*moments, {.volume = volume}, nullptr, std::vector<bool>(points.size()), points)
          .ok());

  EXPECT_NEAR(MeasureVolume(*moments, points).volume / volume, 1, kVolumeTolerance);
}

TEST(KeptVolumeTest, LeavesHeldPointsAndKeepsSymmetry) {
  const auto moments = MomentsFor(TorusMesh(20, 12), {.extra = {3, 2, 2}});
  const LatticeStructure& s = moments->plan().structure;
  const PointFreedom freedom(
      {.held_layers = {{.axis = 2, .at_end = true, .layers = 2}}, .mirror = 0}, s);
  Pulled edit(*moments);
  for (size_t i = 0; i < edit.points.size(); ++i) {  // a symmetric edit
    edit.points[i] = moments->plan().identity_points[i];
    edit.named[i] = i < static_cast<size_t>(2 * s.size[0] * s.size[1]);
    if (edit.named[i]) edit.points[i] += Vec3d{0, 0, -0.3};
  }
  const auto before = edit.points;

  ASSERT_TRUE(KeepVolume(*moments, {}, &freedom, edit.named, edit.points).ok());

  EXPECT_LE(ErrorOf(*moments, edit.points), kVolumeTolerance);
  for (size_t i = 0; i < before.size(); ++i) {
    if (freedom.is_held(i)) {
      EXPECT_EQ(edit.points[i], before[i]);
    }
    const Vec3d move = edit.points[i] - before[i];
    const size_t image = freedom.ImageOf(i);
    EXPECT_NEAR(Norm(freedom.Reflect(move) - (edit.points[image] - before[image])), 0, 1e-14);
  }
}

TEST(KeptVolumeTest, TakesNamedPointsWhereAllAreNamed) {
  const auto moments = MomentsFor(TorusMesh(20, 12), {});
  Pulled edit(*moments);
  edit.named.assign(edit.named.size(), true);

  ASSERT_TRUE(KeepVolume(*moments, {}, nullptr, edit.named, edit.points).ok());

  EXPECT_LE(ErrorOf(*moments, edit.points), kVolumeTolerance);
}

TEST(KeptVolumeTest, TearsNoSeam) {
  const auto moments = MomentsFor(TorusMesh(16, 8), {.extra = {4, 4, 4}, .scale = 0.8});
  const DeformPlan& plan = moments->plan();
  ASSERT_GT(plan.outside_patches, 0u);
  auto points = plan.identity_points;
  std::vector<bool> named(points.size());
  const auto inner = static_cast<size_t>(plan.structure.Index(3, 3, 3));
  points[inner] += Vec3d{0.1, 0.2, 0.1};
  named[inner] = true;
  ASSERT_EQ(CountTornEdges(plan, points), 0u);

  ASSERT_TRUE(KeepVolume(*moments, {}, nullptr, named, points).ok());

  EXPECT_EQ(CountTornEdges(plan, points), 0u);
  EXPECT_LE(ErrorOf(*moments, points), kVolumeTolerance);
}

TEST(KeptVolumeTest, RefusesWhereNothingIsFree) {
  const auto moments = MomentsFor(TorusMesh(20, 12), {});
  const LatticeStructure& s = moments->plan().structure;
  std::vector<uint32_t> held;
  for (int i = 0; i < s.control_point_count(); ++i) held.push_back(static_cast<uint32_t>(i));
  const PointFreedom freedom({.held = held}, s);
  Pulled edit(*moments);
  const auto before = edit.points;

  const auto got = KeepVolume(*moments, {}, &freedom, edit.named, edit.points);

  EXPECT_THAT(got, StatusIs(absl::StatusCode::kFailedPrecondition));
  EXPECT_EQ(error::DetailsOf(got.status()).reason, "VOLUME_NOT_KEPT");
  EXPECT_EQ(edit.points, before);
}

}  // namespace
}  // namespace latticed::testing
