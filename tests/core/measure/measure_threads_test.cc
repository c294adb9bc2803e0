// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Measures patch by patch have the same bits on any number of threads.
#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/ffd/pick/patch_tree.h"
#include "core/measure/enclosed_volume.h"
#include "core/measure/kept_volume.h"
#include "core/measure/surface_area.h"
#include "core/measure/surface_bounds.h"
#include "core/view/cpu_arena.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

std::shared_ptr<const DeformPlan> PlanUnderTurned(bool is_weighted) {
  const auto mesh = std::make_shared<const PolygonMesh>(TorusMesh(90, 60));
  const std::array structures{
      MakeStructure(mesh->ComputeBounds(), {.degree = {2, 1, 2}}),
      MakeStructure(mesh->ComputeBounds(), {.extra = {2, 2, 2}, .scale = 1.8, .turn = 0.7})};
  VertexWeights weights;
  if (is_weighted) {
    std::vector<float> waves;
    for (const Vec3d p : mesh->positions) {
      waves.push_back(static_cast<float>(0.5 + 0.5 * std::sin(3 * p.x + 2 * p.y)));
    }
    weights = std::make_shared<const std::vector<float>>(std::move(waves));
  }
  return *MakePlan(mesh, structures[0], {}, NeverStop, weights, std::span(structures).subspan(1));
}

// All measures, one number after the other.
std::vector<double> MeasuresOf(const std::shared_ptr<const DeformPlan>& plan,
                               const std::vector<Vec3d>& points, CpuArena* arena) {
  std::vector<double> numbers;
  const auto append = [&](Vec3d v) { numbers.insert(numbers.end(), {v.x, v.y, v.z}); };
  const auto volume = *MeasureVolumeByPatches(*plan, points, NeverStop, arena);
  numbers.push_back(volume.volume);
  for (const Vec3d g : volume.gradient) append(g);
  const auto centroid = *MeasureCentroidByPatches(*plan, points, NeverStop, arena);
  append(centroid.centroid);
  for (const auto& by_point : centroid.gradient) {
    for (const Vec3d g : by_point) append(g);
  }
  const auto area = *MeasureArea(*plan, points, 1e-7, true, NeverStop, arena);
  numbers.insert(numbers.end(), {area.area, area.error});
  for (const Vec3d g : area.gradient) append(g);
  const Bounds bounds = *MeasureBounds(*plan, PatchTree(*plan), points, NeverStop, arena);
  append(bounds.min);
  append(bounds.max);
  const auto moments = *SurfaceMoments::Make(plan, SurfaceMoments::Order::kVolume);
  std::vector<Vec3d> kept = points;
  EXPECT_OK(KeepVolume(*moments, {.volume = 1.01 * volume.volume}, nullptr,
                       std::vector<bool>(points.size()), kept, nullptr, arena));
  for (const Vec3d p : kept) append(p);
  return numbers;
}

TEST(MeasuresByPatches, HaveTheSameBitsOnAnyNumberOfThreads) {
  for (const bool is_weighted : {false, true}) {
    const auto plan = PlanUnderTurned(is_weighted);
    ASSERT_GT(plan->patches.size(), 10'000u);  // more runs than are summed together
    std::vector<Vec3d> points = Jitter(plan->structure, 0.08, 1);
    const auto more = Jitter(plan->turned[0].structure, 0.08, 2);
    points.insert(points.end(), more.begin(), more.end());

    const auto want = MeasuresOf(plan, points, nullptr);

    for (const int threads : {1, 3, 8}) {
      CpuArena arena(threads);
      EXPECT_EQ(MeasuresOf(plan, points, &arena), want);
    }
  }
}

TEST(MeasuresByPatches, Stop) {
  const auto plan = PlanUnderTurned(false);
  const std::vector<Vec3d>& points = plan->identity_points;
  const auto stop = [] { return absl::CancelledError(); };
  CpuArena arena(2);
  const auto is_cancelled = StatusIs(absl::StatusCode::kCancelled);
  EXPECT_THAT(MeasureVolumeByPatches(*plan, points, stop, &arena), is_cancelled);
  EXPECT_THAT(MeasureCentroidByPatches(*plan, points, stop, &arena), is_cancelled);
  EXPECT_THAT(MeasureArea(*plan, points, 1e-6, true, stop, &arena), is_cancelled);
  EXPECT_THAT(MeasureBounds(*plan, PatchTree(*plan), points, stop, &arena), is_cancelled);
}

}  // namespace
}  // namespace latticed::testing
