// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene with vertex weights and the same scene without, evaluated by turns, so that a drift of the machine touches both.
//
//   weighted_ms, unweighted_ms   the least time of a frame
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

void ByTurns(benchmark::State& state, int degree, const ViewSpec& spec) {
  const Scenario& plain = SmallScenario(degree);
  const Scenario weighted =
      MakeScenario("weighted", Checked(MakePlan(plain.plan->mesh, plain.plan->structure, {},
                                                NeverStop, Waves(*plain.plan->mesh))));
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
  const double weighted_ms = std::ranges::min(weighted_times),
               unweighted_ms = std::ranges::min(times);
  state.counters["weighted_ms"] = weighted_ms;
  state.counters["unweighted_ms"] = unweighted_ms;
  state.counters["ratio"] = weighted_ms / unweighted_ms;
}

}  // namespace

void RegisterWeightsBenches() {
  for (const int degree : {1, 2, 3}) {
    for (const auto& [normals, name] :
         {std::pair{NormalMode::kFacet, "facet"}, std::pair{NormalMode::kSmooth, "smooth"}}) {
      for (const int segments : {3, 10}) {
        const ViewSpec spec{.segments = segments, .normals = normals};
        RegisterTimed(fmt::format("weights/torus-17k/degree{}/quantised/{}/{}segments", degree,
                                  name, segments),
                      [=](benchmark::State& state) { ByTurns(state, degree, spec); });
      }
    }
  }
}

}  // namespace latticed::bench
