// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Measures of the exact surface and the kept volume: a torus in an 8 x 8 x 8 lattice whose control points all move, one
// core. V with its gradient must not depend on the number of patches, and takes a part of a millisecond an edit. With vertex
// weights it is compared with the integration of each patch.
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <utility>

#include "core/measure/enclosed_volume.h"
#include "core/measure/kept_volume.h"
#include "core/measure/surface_area.h"
#include "core/measure/weighted_integrals.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {
namespace {

using Order = SurfaceMoments::Order;

struct MeasuredScene {
  MeasuredScene(int around, int across, int degree, bool weighted) {
    const auto mesh = MakeTorus(around, across);
    const auto lattice =
        Checked(FitLattice(mesh->ComputeBounds(), {8, 8, 8}, {degree, degree, degree}, 0.05));
    plan = Checked(MakePlan(mesh, lattice.structure, {}, NeverStop,
                            weighted ? WeightsAlongX(*mesh) : nullptr));
    points = lattice.control_points;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> noise(-0.05, 0.05);
    for (Vec3d& p : points) p += {noise(random), noise(random), noise(random)};
  }
  static VertexWeights WeightsAlongX(const PolygonMesh& mesh) {
    const Bounds bounds = mesh.ComputeBounds();
    std::vector<float> weights;
    for (const Vec3d p : mesh.positions) {
      weights.push_back(static_cast<float>((p.x - bounds.min.x) / bounds.extent().x));
    }
    return std::make_shared<const std::vector<float>>(std::move(weights));
  }
  std::shared_ptr<const DeformPlan> plan;
  std::vector<Vec3d> points;
};

void Count(benchmark::State& state, const MeasuredScene& scene, const SurfaceMoments& moments) {
  state.counters["patches"] = static_cast<double>(scene.plan->patches.size());
  state.counters["boxes"] = static_cast<double>(moments.boxes().size());
}

void Moments(benchmark::State& state, const MeasuredScene& scene) {
  for (auto _ : state) benchmark::DoNotOptimize(SurfaceMoments::Make(scene.plan, Order::kVolume));
}

void Volume(benchmark::State& state, const MeasuredScene& scene) {
  const auto moments = Checked(SurfaceMoments::Make(scene.plan, Order::kVolume));
  for (auto _ : state) benchmark::DoNotOptimize(MeasureVolume(*moments, scene.points));
  Count(state, scene, *moments);
}

void PatchByPatch(benchmark::State& state, const MeasuredScene& scene) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(IntegrateWeighted(*scene.plan, scene.points, false));
  }
}

void Centroid(benchmark::State& state, const MeasuredScene& scene) {
  const auto moments = Checked(SurfaceMoments::Make(scene.plan, Order::kCentroid));
  for (auto _ : state) benchmark::DoNotOptimize(MeasureCentroid(*moments, scene.points));
  Count(state, scene, *moments);
}

void Area(benchmark::State& state, const MeasuredScene& scene) {
  constexpr double kTolerance = 1e-6;
  for (auto _ : state) {
    benchmark::DoNotOptimize(MeasureArea(*scene.plan, scene.points, kTolerance, false));
  }
}

void Keep(benchmark::State& state, const MeasuredScene& scene) {
  const auto moments = Checked(SurfaceMoments::Make(scene.plan, Order::kVolume));
  const KeptVolume kept{.volume = RestVolume(*moments)};
  const std::vector<bool> none(scene.points.size());
  int steps = 0;
  double error = 0;
  for (auto _ : state) {
    std::vector<Vec3d> points = scene.points;
    steps = Checked(KeepVolume(*moments, kept, nullptr, none, points));
    error = std::abs(MeasureVolume(*moments, points).volume / *kept.volume - 1);
  }
  state.counters["steps"] = steps;
  state.counters["error_1e-12"] = error / kVolumeTolerance;
}

}  // namespace

void RegisterMeasureBenches() {
  for (const int degree : {2, 3}) {
    for (const auto& [around, across] : {std::array{250, 100}, std::array{1000, 400}}) {
      const auto name = [&, faces = around * across](const char* what) {
        return fmt::format("measure/{}/degree{}/{}-faces", what, degree, faces);
      };
      const auto scene = [around = around, across = across, degree](auto body,
                                                                    bool weighted = false) {
        return [=](benchmark::State& state) {
          body(state, MeasuredScene(around, across, degree, weighted));
        };
      };
      RegisterTimed(name("moments"), scene(Moments));
      RegisterTimed(name("volume"), scene(Volume));
      RegisterTimed(name("centroid"), scene(Centroid));
      RegisterTimed(name("area"), scene(Area));
      RegisterTimed(name("keep"), scene(Keep));
      RegisterTimed(name("weighted-moments"), scene(Moments, true));
      RegisterTimed(name("weighted-volume"), scene(Volume, true));
      RegisterTimed(name("weighted-patch-by-patch"), scene(PatchByPatch, true));
      RegisterTimed(name("weighted-keep"), scene(Keep, true));
    }
  }
}

}  // namespace latticed::bench
