// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluations with a tolerance, a share of the quantisation box's range. The row's time is by the host's clock, from the
// call of Evaluate until the vertices are in device memory: such an evaluation waits for the device, so no gate can hold
// its stream. "all" moves all control points, "one" the one that touches the most patches.
#include <algorithm>
#include <array>
#include <utility>

#include "core/adaptive/adaptive_pattern.h"
#include "core/adaptive/edge_levels.h"
#include "core/ffd/direct_ffd.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/gpu/gpu_scenario.h"
#include "tests/support/definition.h"

namespace latticed::bench {
namespace {

constexpr int kToleranceRuns = 50;
constexpr int kTolerancePositionBits = 16;
constexpr size_t kCheckedChunks = 64;

// Some chunks of a view that was evaluated with control_points[0]: each point, and the bound.
absl::Status CheckPoints(const Scenario& scenario, DeformView& view) {
  const DirectFfd definition(*scenario.plan, scenario.control_points[0]);
  const double allowed = PointError(scenario.box, kTolerancePositionBits);
  const size_t stride = std::max<size_t>(1, scenario.all_chunks.size() / kCheckedChunks);
  for (uint32_t chunk = 0; chunk < scenario.all_chunks.size();
       chunk += static_cast<uint32_t>(stride)) {
    std::vector<uint8_t> bytes(ChunkPoints(view, *scenario.plan, chunk) *
                               BytesPerPoint(view.spec()));
    CheckOk(view.Read(chunk, bytes));
    const auto points = testing::DecodePoints(*scenario.plan, view.spec(), scenario.box, bytes);
    size_t patch = scenario.plan->ChunkPatches(chunk)[0], next = 0;
    for (const uint16_t code : view.Patterns().OfChunk(chunk)) {
      const AdaptivePattern& pattern = AdaptivePattern::Get(*PatternKey::FromCode(code));
      for (const auto& steps : pattern.points) {
        std::array<double, 3> at{};
        for (size_t a = 0; a < 3; ++a) {
          at[a] = static_cast<double>(steps[a]) / pattern.denominator;
        }
        const Vec3d exact = definition.EvaluatePosition(patch, at).position;
        if (!(Norm(points[next++].position - exact) <= allowed)) {
          return absl::InternalError(fmt::format("a point of patch {} is wrong", patch));
        }
      }
      ++patch;
    }
  }
  if (view.certified_error() <= view.spec().tolerance) return absl::OkStatus();
  return absl::InternalError("the tolerance is not met");
}

void EvaluateWithTolerance(benchmark::State& state, const Scenario& scenario, double share,
                           bool one_point) {
  ViewSpec spec = GpuSpec(VertexFormat::kQuantised, NormalMode::kFacet, 10);
  spec.position_bits = kTolerancePositionBits;
  spec.tolerance = share * scenario.box.range;
  Gpu& gpu = **TheGpu();
  const auto target = Checked(gpu.backend().Prepare(
      scenario.plan, scenario.plan->turned.empty() ? Pipeline::kFused : Pipeline::kGemm));
  const auto view = Checked(target->CreateView(spec));
  CheckOk(view->Evaluate(scenario.control_points[0], scenario.box, scenario.all_chunks));
  if (const auto good = CheckPoints(scenario, *view); !good.ok()) return Skip(state, good);
  const size_t points = PatternPoints(view->Patterns().codes);

  const uint32_t moved = ControlPointsByEffect(scenario).back().point;
  std::array<std::vector<Vec3d>, 2> turns{scenario.control_points[0], scenario.control_points[1]};
  std::vector<uint32_t> chunks = scenario.all_chunks;
  if (one_point) {
    turns[1] = turns[0];
    turns[1][moved] = scenario.control_points[1][moved];
    chunks = DirtyChunks(scenario, moved);
  }
  const GpuWork work = [&](int run) {
    return view->Evaluate(turns[static_cast<size_t>(run + 1) % 2], scenario.box, chunks);
  };
  SetTime(state, gpu.LaunchToResult(*view, work, kToleranceRuns));
  const auto patches = static_cast<double>(scenario.plan->patches.size());
  state.counters["patches"] = patches;
  state.counters["points_patch"] = static_cast<double>(points) / patches;
  state.counters["chunks"] = static_cast<double>(chunks.size());
}

}  // namespace

void RegisterGpuToleranceBenches() {
  for (const auto& [name, share] :
       {std::pair{"1e-3", 1e-3}, std::pair{"1e-4", 1e-4}, std::pair{"4e-5", 4e-5}}) {
    for (const bool one_point : {false, true}) {
      RegisterOnce(fmt::format("gpu/tolerance/{}/{}", name, one_point ? "one" : "all"),
                   [share = share, one_point](benchmark::State& state) {
                     const Scenario& model = ModelScenario(PaperModels().back(), {2, 2, 2});
                     EvaluateWithTolerance(state, model, share, one_point);
                   });
    }
  }
  // Under two lattices that are turned against each other.
  for (const bool one_point : {false, true}) {
    RegisterOnce(fmt::format("gpu/tolerance/turned/1e-3/{}", one_point ? "one" : "all"),
                 [one_point](benchmark::State& state) {
                   EvaluateWithTolerance(state, TurnedTorus(), 1e-3, one_point);
                 });
  }
}

}  // namespace latticed::bench
