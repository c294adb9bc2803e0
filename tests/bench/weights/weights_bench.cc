// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene with vertex weights and the same scene without. On the CPU they are evaluated by turns, so that a drift of the
// machine touches both; on a GPU one after the other.
//
//   weighted_ms, unweighted_ms   the least time of a frame; on a GPU, the median on the device; with a tolerance, by the
//                                host's clock from the launch to the result
//   ratio                        of the two
#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/gpu/gpu_scenario.h"
#include "tests/bench/scenario.h"
#include "tests/bench/verify.h"

namespace latticed::bench {
namespace {

// All weights from 0 to 1, smoothly.
VertexWeights Waves(const PolygonMesh& mesh) {
  std::vector<float> weights;
  weights.reserve(mesh.positions.size());
  for (const Vec3d p : mesh.positions) {
    weights.push_back(static_cast<float>(0.5 + 0.5 * std::sin(3 * p.x + 2 * p.y)));
  }
  return std::make_shared<const std::vector<float>>(std::move(weights));
}

double Frame(const Scenario& scenario, DeformView& view, size_t frame) {
  const auto begin = std::chrono::steady_clock::now();
  CheckOk(view.Evaluate(scenario.control_points[frame % 2], scenario.box, scenario.all_chunks));
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
      .count();
}

Scenario WithWaves(const Scenario& plain) {
  return MakeScenario("weighted", Checked(MakePlan(plain.plan->mesh, plain.plan->structure, {},
                                                   NeverStop, Waves(*plain.plan->mesh))));
}

void SetRatio(benchmark::State& state, double weighted_ms, double unweighted_ms) {
  state.counters["weighted_ms"] = weighted_ms;
  state.counters["unweighted_ms"] = unweighted_ms;
  state.counters["ratio"] = weighted_ms / unweighted_ms;
}

void ByTurns(benchmark::State& state, int degree, const ViewSpec& spec) {
  const Scenario& plain = SmallScenario(degree);
  const Scenario weighted = WithWaves(plain);
  const auto with = MakeView(weighted, Pipeline::kFused, spec, 1);
  const auto without = MakeView(plain, Pipeline::kFused, spec, 1);
  if (const absl::Status verified = Verify(weighted, Pipeline::kFused, *with); !verified.ok()) {
    state.SkipWithError(std::string(verified.message()).c_str());
    return;
  }
  std::vector<double> weighted_times, times;
  size_t frame = 0;
  for (auto _ : state) {
    ++frame;
    weighted_times.push_back(Frame(weighted, *with, frame));
    times.push_back(Frame(plain, *without, frame));
  }
  SetRatio(state, std::ranges::min(weighted_times), std::ranges::min(times));
}

void OnGpu(benchmark::State& state, int degree, const ViewSpec& spec) {
  constexpr int kRuns = 30;
  Gpu& gpu = **TheGpu();
  const Scenario& plain = ModelScenario(PaperModels().back(), {degree, degree, degree});
  const Scenario weighted = WithWaves(plain);
  const auto with = MakeGpuView(gpu.backend(), weighted, Pipeline::kFused, spec);
  const auto without = MakeGpuView(gpu.backend(), plain, Pipeline::kFused, spec);
  if (!with.ok()) return Skip(state, with.status());
  if (!without.ok()) return Skip(state, without.status());
  const GpuTimes time = gpu.DeviceTime(**with, AllChunks(weighted, **with), kRuns);
  SetTime(state, time);
  SetRatio(state, time.median,
           gpu.DeviceTime(**without, AllChunks(plain, **without), kRuns).median);
}

GpuTimes WithTolerance(Gpu& gpu, const Scenario& scenario, double share) {
  ViewSpec spec = GpuSpec(VertexFormat::kQuantised, NormalMode::kFacet, 32);
  spec.position_bits = 16;
  spec.tolerance = share * scenario.box.range;
  const auto target = Checked(gpu.backend().Prepare(scenario.plan, Pipeline::kFused));
  const auto view = Checked(target->CreateView(spec));
  const GpuTimes time = gpu.LaunchToResult(*view, AllChunks(scenario, *view), 30);
  if (!(view->certified_error() <= spec.tolerance)) {
    CheckOk(absl::InternalError("the tolerance is not met"));
  }
  return time;
}

// `share`: of the quantisation box's range.
void OnGpuWithTolerance(benchmark::State& state, double share) {
  const Scenario& plain = ModelScenario(PaperModels().back(), {2, 2, 2});
  const GpuTimes time = WithTolerance(**TheGpu(), WithWaves(plain), share);
  SetTime(state, time);
  SetRatio(state, time.median, WithTolerance(**TheGpu(), plain, share).median);
}

void RegisterWith(int degree, NormalMode normals, int segments) {
  const char* const name = normals == NormalMode::kFacet ? "facet" : "smooth";
  const ViewSpec spec{.segments = segments, .normals = normals};
  RegisterTimed(
      fmt::format("weights/torus-17k/degree{}/quantised/{}/{}segments", degree, name, segments),
      [=](benchmark::State& state) { ByTurns(state, degree, spec); });
  if (!TheGpu().ok()) return;
  for (const VertexFormat format : {VertexFormat::kQuantised, VertexFormat::kFloat32}) {
    RegisterOnce(
        fmt::format("gpu/weights/degree{}/{}/{}/{}segments", degree,
                    format == VertexFormat::kQuantised ? "quantised" : "float32", name, segments),
        [=](benchmark::State& state) { OnGpu(state, degree, GpuSpec(format, normals, segments)); });
  }
}

}  // namespace

void RegisterWeightsBenches() {
  for (const int degree : {1, 2, 3}) {
    for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
      for (const int segments : {3, 10}) RegisterWith(degree, normals, segments);
    }
  }
  if (!TheGpu().ok()) return;
  for (const auto& [name, share] : {std::pair{"1e-3", 1e-3}, std::pair{"1e-4", 1e-4}}) {
    RegisterOnce(fmt::format("gpu/weights/degree2/tolerance-{}", name),
                 [share = share](benchmark::State& state) { OnGpuWithTolerance(state, share); });
  }
}

}  // namespace latticed::bench
