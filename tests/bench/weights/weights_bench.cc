// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene with vertex weights and the same scene without. On the CPU they are evaluated by turns, so that a drift of the
// machine touches both; on a GPU one after the other.
//
//   weighted_ms, unweighted_ms   the least time of a frame; on a GPU, the median on the device; with a tolerance, by the
//                                host's clock from the launch to the result
//   ratio                        of the two
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/cpu/lane_order_view.h"
#include "tests/bench/gpu/gpu_scenario.h"
#include "tests/bench/scenario.h"
#include "tests/bench/turns.h"
#include "tests/bench/verify.h"

namespace latticed::bench {
namespace {

Scenario WithWaves(const Scenario& plain) {
  return MakeScenario("weighted", Checked(MakePlan(plain.plan->mesh, plain.plan->structure, {},
                                                   NeverStop, WavesOfWeights(*plain.plan->mesh))));
}

void SetRatio(benchmark::State& state, double weighted_ms, double unweighted_ms) {
  state.counters["weighted_ms"] = weighted_ms;
  state.counters["unweighted_ms"] = unweighted_ms;
  state.counters["ratio"] = weighted_ms / unweighted_ms;
}

// Floats in lane order: stores hide the least there.
std::unique_ptr<DeformView> MakeCpuView(const Scenario& scenario, const ViewSpec& spec) {
  if (spec.format == VertexFormat::kQuantised) {
    return MakeView(scenario, Pipeline::kFused, spec, 1);
  }
  auto view = MakeLaneOrderView(scenario.plan, spec, 1);
  CheckOk(view->Evaluate(scenario.control_points[0], scenario.box, scenario.all_chunks));
  return view;
}

void ByTurns(benchmark::State& state, int degree, const ViewSpec& spec) {
  const Scenario& plain = SmallScenario(degree);
  const Scenario weighted = WithWaves(plain);
  const auto with = MakeCpuView(weighted, spec);
  const auto without = MakeCpuView(plain, spec);
  if (const absl::Status verified = Verify(weighted, Pipeline::kFused, *with); !verified.ok()) {
    state.SkipWithError(std::string(verified.message()).c_str());
    return;
  }
  const auto evaluate = [](const Scenario& scenario, DeformView& view) {
    return [&](size_t frame) {
      CheckOk(view.Evaluate(scenario.control_points[frame % 2], scenario.box, scenario.all_chunks));
    };
  };
  TakeTurns(state, {"weighted", evaluate(weighted, *with)},
            {"unweighted", evaluate(plain, *without)});
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

void RegisterOnCpu(int degree, NormalMode normals, int segments) {
  for (const VertexFormat format : {VertexFormat::kQuantised, VertexFormat::kFloat32}) {
    const ViewSpec spec{.segments = segments, .normals = normals, .format = format};
    RegisterTurns(fmt::format("weights/torus-17k/degree{}/{}/{}/{}segments", degree,
                              format == VertexFormat::kQuantised ? "quantised" : "lane-order",
                              normals == NormalMode::kFacet ? "facet" : "smooth", segments),
                  [=](benchmark::State& state) { ByTurns(state, degree, spec); });
  }
}

void RegisterOnGpu(int degree, NormalMode normals, int segments) {
  for (const VertexFormat format : {VertexFormat::kQuantised, VertexFormat::kFloat32}) {
    RegisterOnce(
        fmt::format("gpu/weights/degree{}/{}/{}/{}segments", degree,
                    format == VertexFormat::kQuantised ? "quantised" : "float32",
                    normals == NormalMode::kFacet ? "facet" : "smooth", segments),
        [=](benchmark::State& state) { OnGpu(state, degree, GpuSpec(format, normals, segments)); });
  }
}

}  // namespace

void RegisterWeightsBenches() {
  for (const int degree : {1, 2, 3}) {
    for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
      for (const int segments : {1, 2, 3, 4, 10}) RegisterOnCpu(degree, normals, segments);
    }
  }
  if (!TheGpu().ok()) return;
  for (const int degree : {1, 2, 3}) {
    for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
      for (const int segments : {3, 10}) RegisterOnGpu(degree, normals, segments);
    }
  }
  for (const auto& [name, share] : {std::pair{"1e-3", 1e-3}, std::pair{"1e-4", 1e-4}}) {
    RegisterOnce(fmt::format("gpu/weights/degree2/tolerance-{}", name),
                 [share = share](benchmark::State& state) { OnGpuWithTolerance(state, share); });
  }
}

}  // namespace latticed::bench
