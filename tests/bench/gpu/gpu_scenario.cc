// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/gpu/gpu_scenario.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/base/status_macros.h"
#include "core/ffd/plan/dirty_set.h"
#include "fmt/format.h"
#include "tests/bench/exact_mesh.h"
#include "tests/bench/paper/tensor/tensor_verify.h"
#include "tests/bench/verify.h"

namespace latticed::bench {
namespace {

// Up to this size a plan is exact, which means making it twice.
constexpr size_t kMostExact = 1'000'000;
// Larger plans take seconds, so the reason for the wait is printed.
constexpr size_t kManyPatches = 500'000;
// Verify compares about this number of a view's patches.
constexpr size_t kVerifiedSurfaces = 2'000;

// Made on the first call and kept.
const Scenario& Kept(const std::string& name, std::array<int, 3> degree, const auto& make_plan) {
  static auto* const scenarios = new std::map<std::pair<std::string, std::array<int, 3>>, Scenario>;
  const auto found = scenarios->find({name, degree});
  if (found != scenarios->end()) return found->second;
  return scenarios->emplace(std::pair(name, degree), MakeScenario(name, Checked(make_plan())))
      .first->second;
}

}  // namespace

const Scenario& ModelScenario(const PaperModel& model, std::array<int, 3> degree) {
  return Kept(fmt::format("{}-{}", model.name, model.patches), degree,
              [&] { return MakeExactPlan(model.patches, degree); });
}

const Scenario& ScaleScenario(size_t patches) {
  constexpr std::array kDegree{2, 2, 2};
  return Kept(fmt::format("scale-{}", patches), kDegree, [&] {
    if (patches > kManyPatches) {
      fmt::print(stderr, "latticed_bench: planning {} patches\n", patches);
    }
    return patches > kMostExact ? MakeRoughPlan(patches, kDegree) : MakeExactPlan(patches, kDegree);
  });
}

const Scenario& TurnedTorus() {
  static const Scenario* const scenario =
      new Scenario(MakeTurnedScenario("torus-turned", MakeTorus(324, 144)));
  return *scenario;
}

absl::StatusOr<std::unique_ptr<DeformView>> MakeGpuView(Backend& backend, const Scenario& scenario,
                                                        Pipeline pipeline, const ViewSpec& spec) {
  const auto target = backend.Prepare(scenario.plan, pipeline);
  if (absl::IsUnimplemented(target.status())) return target.status();
  CheckOk(target.status());
  auto view = (*target)->CreateView(spec);
  if (absl::IsUnimplemented(view.status())) return view;
  CheckOk(view.status());
  CheckOk((*view)->Evaluate(scenario.control_points[0], scenario.box, scenario.all_chunks));
  LATTICED_RETURN_IF_ERROR(Verify(scenario, pipeline, **view));
  return view;
}

absl::StatusOr<TensorRun> MeasureTensorProduct(Gpu& gpu, const Scenario& scenario, int runs) {
  LATTICED_ASSIGN_OR_RETURN(const auto surfaces, MakeTensorSurfaces(*scenario.plan));
  const size_t stride = std::max<size_t>(1, surfaces.count() / kVerifiedSurfaces);
  const auto check = [&](std::span<const TensorVertex> vertices) {
    const auto precision =
        CompareTensor(*scenario.plan, scenario.control_points[0], surfaces, vertices, stride);
    return precision.ok() ? precision->Check(kTensorNormalError) : precision.status();
  };
  LATTICED_ASSIGN_OR_RETURN(
      const auto times,
      gpu.TensorProduct(scenario.plan, surfaces, scenario.control_points, check, runs));
  return TensorRun{.surfaces = surfaces.count(),
                   .points = surfaces.points.size(),
                   .triangles = surfaces.triangles,
                   .times = times};
}

absl::StatusOr<ShaderTimes> MeasureShaderAlgorithm(Gpu& gpu, const Scenario& scenario, int runs) {
  const BezierNets made = gpu.ControlNets(scenario.plan, scenario.control_points, runs);
  auto times = MeasureShaders(scenario, made.nets, ShaderDevice::kCuda, runs);
  if (times.ok()) times->control = made.times;
  return times;
}

std::vector<ControlPointEffect> ControlPointsByEffect(const Scenario& scenario) {
  std::vector<ControlPointEffect> effects;
  const auto count = static_cast<uint32_t>(scenario.plan->structure.control_point_count());
  for (uint32_t point = 0; point < count; ++point) {
    const uint64_t patches = DirtyByControlPoints(*scenario.plan, {&point, 1}).patches;
    if (patches > 0) effects.push_back({patches, point});
  }
  std::sort(effects.begin(), effects.end());
  return effects;
}

std::vector<uint32_t> DirtyChunks(const Scenario& scenario, uint32_t control_point) {
  return DirtyByControlPoints(*scenario.plan, {&control_point, 1}).chunks;
}

GpuWork AllChunks(const Scenario& scenario, DeformView& view) {
  return [&scenario, &view](int run) {
    return view.Evaluate(scenario.control_points[static_cast<size_t>(run + 1) % 2], scenario.box,
                         scenario.all_chunks);
  };
}

ViewSpec GpuSpec(VertexFormat format, NormalMode normals, int segments) {
  return {.segments = segments,
          .normals = normals,
          .format = format,
          .position_bits = 12,
          .normal_bits = 8};
}

double SumMs(const std::vector<GpuStage>& stages) {
  double sum = 0;
  for (const GpuStage& stage : stages) sum += stage.device_ms;
  return sum;
}

}  // namespace latticed::bench
