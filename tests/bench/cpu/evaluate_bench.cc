// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <vector>

#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/cpu/lane_order_view.h"
#include "tests/bench/scenario.h"
#include "tests/bench/verify.h"
#include "tests/support/pipeline_name.h"

namespace latticed::bench {
namespace {

struct Case {
  Pipeline pipeline = Pipeline::kFused;
  ViewSpec spec;
  int threads = 1;
  bool lane_order = false;  // fused only: its fastest stores
};

ViewSpec Float32(NormalMode normals, int segments = 10) {
  return {.segments = segments, .normals = normals, .format = VertexFormat::kFloat32};
}

Case Lanes(NormalMode normals, int threads = 1, int segments = 10) {
  return {Pipeline::kFused, Float32(normals, segments), threads, /*lane_order=*/true};
}

ViewSpec Quantised(NormalMode normals, int segments = 10) {
  return {.segments = segments,
          .normals = normals,
          .format = VertexFormat::kQuantised,
          .position_bits = 12,
          .normal_bits = 8};
}

const char* OutputName(const Case& c) {
  if (c.spec.format == VertexFormat::kQuantised) return "quantised";
  return c.lane_order ? "lane-order" : "point-order";
}

std::unique_ptr<DeformView> MakeCaseView(const Scenario& scenario, const Case& c) {
  if (!c.lane_order) return MakeView(scenario, c.pipeline, c.spec, c.threads);
  auto view = MakeLaneOrderView(scenario.plan, c.spec, c.threads);
  CheckOk(view->Evaluate(scenario.control_points[0], scenario.box, scenario.all_chunks));
  return view;
}

const char* NormalsName(NormalMode normals) {
  switch (normals) {
    case NormalMode::kNone:
      return "none";
    case NormalMode::kFacet:
      return "facet";
    case NormalMode::kSmooth:
      return "smooth";
  }
  return "";
}

// Each iteration evaluates all chunks for new control points.
void Frames(benchmark::State& state, const Scenario& scenario, const Case& c) {
  const auto view = MakeCaseView(scenario, c);
  if (const absl::Status verified = Verify(scenario, c.pipeline, *view); !verified.ok()) {
    state.SkipWithError(std::string(verified.message()).c_str());
    return;
  }
  size_t frame = 0;
  for (auto _ : state) {
    CheckOk(
        view->Evaluate(scenario.control_points[++frame % 2], scenario.box, scenario.all_chunks));
  }
  state.counters["patches"] = static_cast<double>(scenario.plan->patches.size());
  CountPoints(state, scenario.points(c.spec.segments));
}

void Register(const char* scenario_name, int degree, std::vector<Case> cases,
              const std::function<const Scenario&()>& scenario) {
  for (const Case& c : cases) {
    const std::string name = fmt::format(
        "evaluate/{}/{}/degree{}/{}/{}/{}segments/{}t", scenario_name, PipelineName(c.pipeline),
        degree, OutputName(c), NormalsName(c.spec.normals), c.spec.segments, c.threads);
    RegisterTimed(name, [c, scenario](benchmark::State& state) { Frames(state, scenario(), c); });
  }
}

// Around the number of segments from which composing a patch's own polynomial is faster.
void RegisterFewSegments() {
  std::vector<Case> cases, other_degrees;
  for (const int segments : {1, 2, 3, 4, 5, 6}) {
    other_degrees.push_back(Lanes(NormalMode::kFacet, 1, segments));
    cases.push_back(other_degrees.back());
    cases.push_back(Lanes(NormalMode::kSmooth, 1, segments));
    cases.push_back({Pipeline::kFused, Quantised(NormalMode::kFacet, segments), 1});
  }
  Register("torus-17k", 2, cases, []() -> const Scenario& { return SmallScenario(2); });
  for (const int degree : {1, 3}) {
    Register("torus-17k", degree, other_degrees,
             [degree]() -> const Scenario& { return SmallScenario(degree); });
  }
}

}  // namespace

void RegisterEvaluateBenches() {
  const ViewSpec point = Float32(NormalMode::kFacet);
  const ViewSpec streamed = Quantised(NormalMode::kFacet);
  Register("torus-17k", 2,
           {Lanes(NormalMode::kFacet),
            Lanes(NormalMode::kFacet, 2),
            Lanes(NormalMode::kSmooth),
            Lanes(NormalMode::kNone),
            {Pipeline::kFused, point, 1},
            {Pipeline::kFused, streamed, 1},
            {Pipeline::kFused, streamed, 2},
            {Pipeline::kFused, Quantised(NormalMode::kSmooth), 1},
            Lanes(NormalMode::kFacet, 1, 20),
            {Pipeline::kGemm, point, 1},
            {Pipeline::kGemm, point, 2},
            {Pipeline::kGemm12, point, 1},
            {Pipeline::kControlNet, point, 1}},
           []() -> const Scenario& { return SmallScenario(2); });
  for (const int degree : {1, 3}) {
    Register("torus-17k", degree, {Lanes(NormalMode::kFacet), {Pipeline::kGemm, point, 1}},
             [degree]() -> const Scenario& { return SmallScenario(degree); });
  }
  Register("torus-114k", 2,
           {Lanes(NormalMode::kFacet),
            Lanes(NormalMode::kFacet, 2),
            {Pipeline::kFused, streamed, 1},
            {Pipeline::kGemm, point, 1}},
           []() -> const Scenario& { return LargeScenario(); });
  RegisterFewSegments();
}

}  // namespace latticed::bench
