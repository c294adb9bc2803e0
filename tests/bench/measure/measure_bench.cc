// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Measures of the exact surface and the kept volume: a torus in an 8 x 8 x 8 lattice whose control points all move, one
// core. V with its gradient must not depend on the number of patches, and takes a part of a millisecond an edit.
//
//   measure/<what>/degree<n>/<faces>-faces
//   measure/weighted-{moments,by-patches,keep}/…      with vertex weights; by-patches integrates each patch anew
//   measure/weighted-{volume,area}/…                  with vertex weights and without, by turns (turns.h), compared with
//                                                     quadrature of the definition before it is timed
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <utility>

#include "core/measure/enclosed_volume.h"
#include "core/measure/kept_volume.h"
#include "core/measure/patch_integrals.h"
#include "core/measure/surface_area.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"
#include "tests/bench/turns.h"
#include "tests/core/measure/measured_patches.h"

namespace latticed::bench {
namespace {

using Order = SurfaceMoments::Order;

constexpr double kAreaTolerance = 1e-6;

struct MeasuredScene {
  MeasuredScene(int around, int across, int degree, bool weighted = false) {
    const auto mesh = MakeTorus(around, across);
    const auto lattice =
        Checked(FitLattice(mesh->ComputeBounds(), {8, 8, 8}, {degree, degree, degree}, 0.05));
    plan = Checked(MakePlan(mesh, lattice.structure, {}, NeverStop,
                            weighted ? WavesOfWeights(*mesh) : nullptr));
    points = lattice.control_points;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> noise(-0.05, 0.05);
    for (Vec3d& p : points) p += {noise(random), noise(random), noise(random)};
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

void Centroid(benchmark::State& state, const MeasuredScene& scene) {
  const auto moments = Checked(SurfaceMoments::Make(scene.plan, Order::kCentroid));
  for (auto _ : state) benchmark::DoNotOptimize(MeasureCentroid(*moments, scene.points));
  Count(state, scene, *moments);
}

void Area(benchmark::State& state, const MeasuredScene& scene) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(MeasureArea(*scene.plan, scene.points, kAreaTolerance, false));
  }
}

void PatchByPatch(benchmark::State& state, const MeasuredScene& scene) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(IntegratePatches(*scene.plan, scene.points, false)->volume);
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

// The volume to 1e-10, and the area to ten times its tolerance.
absl::Status CheckMeasures(const MeasuredScene& scene) {
  constexpr int kRule = 10;  // points on an axis: exact for the volume of patches of degree 7
  constexpr double kVolumeError = 1e-10;
  const auto want = testing::MeasurePatches(*scene.plan, scene.points, kRule);
  const auto moments = Checked(SurfaceMoments::Make(scene.plan, Order::kVolume));
  const double volume = MeasureVolume(*moments, scene.points).volume;
  const double area = Checked(MeasureArea(*scene.plan, scene.points, kAreaTolerance, false)).area;
  if (!(std::abs(volume / want.volume - 1) <= kVolumeError)) {
    return absl::InternalError("the volume differs");
  }
  if (!(std::abs(area / want.area - 1) <= 10 * kAreaTolerance)) {
    return absl::InternalError("the area differs");
  }
  return absl::OkStatus();
}

// Both scenes are made and checked once.
const std::pair<MeasuredScene, MeasuredScene>& WithAndWithoutWeights(int around, int across) {
  static const auto* scenes = [&] {
    auto* made = new std::pair(MeasuredScene(around, across, 2, /*weighted=*/true),
                               MeasuredScene(around, across, 2));
    CheckOk(CheckMeasures(made->first));
    CheckOk(CheckMeasures(made->second));
    return made;
  }();
  return *scenes;
}

void WeightedVolume(benchmark::State& state, const MeasuredScene& with,
                    const MeasuredScene& without) {
  const auto moments = Checked(SurfaceMoments::Make(with.plan, Order::kVolume));
  const auto plain = Checked(SurfaceMoments::Make(without.plan, Order::kVolume));
  TakeTurns(
      state,
      {"weighted", [&](size_t) { benchmark::DoNotOptimize(MeasureVolume(*moments, with.points)); }},
      {"unweighted",
       [&](size_t) { benchmark::DoNotOptimize(MeasureVolume(*plain, without.points)); }});
}

void WeightedArea(benchmark::State& state, const MeasuredScene& with,
                  const MeasuredScene& without) {
  const auto area = [](const MeasuredScene& scene) {
    return [&scene](size_t) {
      benchmark::DoNotOptimize(MeasureArea(*scene.plan, scene.points, kAreaTolerance, false));
    };
  };
  TakeTurns(state, {"weighted", area(with)}, {"unweighted", area(without)});
}

void RegisterWeightedMeasures() {
  constexpr int kAround = 125, kAcross = 50;
  const auto add = [&](const char* what, auto body) {
    RegisterTurns(fmt::format("measure/weighted-{}/degree2/{}-faces", what, kAround * kAcross),
                  [=](benchmark::State& state) {
                    const auto& [with, without] = WithAndWithoutWeights(kAround, kAcross);
                    body(state, with, without);
                    state.counters["patches"] = static_cast<double>(with.plan->patches.size());
                  });
  };
  add("volume", WeightedVolume);
  add("area", WeightedArea);
}

}  // namespace

void RegisterMeasureBenches() {
  RegisterWeightedMeasures();
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
      RegisterTimed(name("weighted-by-patches"), scene(PatchByPatch, true));
      RegisterTimed(name("weighted-keep"), scene(Keep, true));
    }
  }
}

}  // namespace latticed::bench
