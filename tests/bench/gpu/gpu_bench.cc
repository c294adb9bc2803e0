// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Rows of the CUDA backend, beside the limits of the same device in the same run (gpu.h):
//
//   the row's time  one Evaluate on the device, from the copy of control points to the last vertex
//   kernels_ms      sum of its stages without that copy
//   bytes_ms        lower bound: bytes of vertices / measured write bandwidth
//   fma_ms          lower bound: multiply-adds of the method (work.h) / measured rate
//   of_floor        the larger bound / kernels_ms
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/gpu/gpu_scenario.h"
#include "tests/bench/work.h"
#include "tests/support/pipeline_name.h"

namespace latticed::bench {
namespace {

constexpr int kRuns = 50;
constexpr int kStageRuns = 30;
constexpr double kMsPerSecond = 1e3, kTera = 1e12, kGiga = 1e9;

struct GpuCase {
  Pipeline pipeline = Pipeline::kFused;
  ViewSpec spec;
};

std::string DegreeName(const std::array<int, 3>& degree) {
  return fmt::format("{}x{}x{}", degree[0], degree[1], degree[2]);
}

const char* OutputName(const ViewSpec& spec) {
  return spec.format == VertexFormat::kQuantised ? "quantised" : "float32";
}

const char* NormalsName(const ViewSpec& spec) {
  return spec.normals == NormalMode::kSmooth ? "smooth" : "facet";
}

void SetFloors(benchmark::State& state, const Scenario& scenario, const GpuCase& c,
               const GpuFloors& floors, double kernels_ms) {
  const DeformPlan& plan = *scenario.plan;
  const auto patches = static_cast<double>(plan.patches.size());
  const double bytes =
      static_cast<double>(scenario.points(c.spec.segments) * BytesPerPoint(c.spec));
  const double work = c.pipeline == Pipeline::kFused
                          ? FusedWork(plan.structure.degree, c.spec.segments)
                          : ProductWork(plan.structure.patch_degree(), c.spec.segments);
  const double bytes_ms = kMsPerSecond * bytes / floors.written;
  const double fma_ms = kMsPerSecond * patches * work / floors.multiply_adds;
  state.counters["bytes_ms"] = bytes_ms;
  state.counters["fma_ms"] = fma_ms;
  state.counters["of_floor"] = std::max(bytes_ms, fma_ms) / kernels_ms;
  state.counters["write_share"] = bytes_ms / kernels_ms;
  state.counters["TB_s"] = bytes / kTera / (kernels_ms / kMsPerSecond);
  state.counters["ns_patch"] = kernels_ms * 1e6 / patches;
}

// The stage "samples" becomes the counter "ms:samples".
void SetStages(benchmark::State& state, const std::vector<GpuStage>& stages) {
  for (const GpuStage& stage : stages) state.counters["ms:" + stage.name] = stage.device_ms;
}

// Evaluates all chunks, with new control points each time.
void Frames(benchmark::State& state, const Scenario& scenario, const GpuCase& c) {
  Gpu& gpu = **TheGpu();
  const auto view = MakeGpuView(gpu.backend(), scenario, c.pipeline, c.spec);
  if (!view.ok()) return Skip(state, view.status());
  const GpuWork work = AllChunks(scenario, **view);
  const GpuTimes whole = gpu.DeviceTime(**view, work, kRuns);
  const std::vector<GpuStage> stages = gpu.Stages(**view, work, kStageRuns);
  const double kernels_ms = SumMs(stages) - StageMs(stages, "copy");
  SetTime(state, whole);
  state.counters["patches"] = static_cast<double>(scenario.plan->patches.size());
  state.counters["kernels_ms"] = kernels_ms;
  SetStages(state, stages);
  SetFloors(state, scenario, c, gpu.floors(), kernels_ms);
}

void Register(const std::string& model, const std::array<int, 3>& degree, const GpuCase& c,
              std::function<const Scenario&()> scenario) {
  RegisterOnce(
      fmt::format("gpu/{}/{}/{}/{}/{}/{}segments", model, PipelineName(c.pipeline),
                  DegreeName(degree), OutputName(c.spec), NormalsName(c.spec), c.spec.segments),
      [c, scenario = std::move(scenario)](benchmark::State& state) {
        Frames(state, scenario(), c);
      });
}

void RegisterModel(const PaperModel& model, const std::array<int, 3>& degree, Pipeline pipeline,
                   VertexFormat format, NormalMode normals, int segments = 10) {
  Register(fmt::format("{}-{}", model.name, model.patches), degree,
           {pipeline, GpuSpec(format, normals, segments)},
           [&model, degree]() -> const Scenario& { return ModelScenario(model, degree); });
}

// The paper's models: the fused pipeline in all forms, the others in one. The largest model has all.
void RegisterModels() {
  constexpr std::array kPaper{2, 2, 2};
  for (const PaperModel& model : PaperModels()) {
    const bool largest = &model == &PaperModels().back();
    for (const Pipeline pipeline :
         {Pipeline::kFused, Pipeline::kGemm, Pipeline::kGemm12, Pipeline::kControlNet}) {
      const bool all = largest || pipeline == Pipeline::kFused;
      for (const VertexFormat format : {VertexFormat::kFloat32, VertexFormat::kQuantised}) {
        for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
          const bool plain = format == VertexFormat::kFloat32 && normals == NormalMode::kFacet;
          if (all || plain) RegisterModel(model, kPaper, pipeline, format, normals);
        }
      }
    }
  }
}

// Around the number of segments from which `fused` composes (MostDirectSegments).
void RegisterFewSegments(VertexFormat format) {
  for (const int segments : {1, 2, 3, 4, 5, 6}) {
    for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
      for (const std::array<int, 3> degree :
           {std::array{1, 1, 1}, std::array{2, 2, 2}, std::array{3, 3, 3}}) {
        RegisterModel(PaperModels().back(), degree, Pipeline::kFused, format, normals, segments);
      }
      RegisterModel(PaperModels().front(), {2, 2, 2}, Pipeline::kFused, format, normals, segments);
    }
  }
}

// Two lattices that are turned against each other.
void RegisterTurned() {
  for (const VertexFormat format : {VertexFormat::kFloat32, VertexFormat::kQuantised}) {
    Register("turned", {2, 2, 2}, {Pipeline::kGemm, GpuSpec(format, NormalMode::kFacet, 10)},
             []() -> const Scenario& { return TurnedTorus(); });
  }
}

// Other degrees and segments, for the largest model.
void RegisterShapes() {
  const PaperModel& model = PaperModels().back();
  for (const VertexFormat format : {VertexFormat::kFloat32, VertexFormat::kQuantised}) {
    for (const std::array<int, 3> degree :
         {std::array{1, 1, 1}, std::array{3, 3, 3}, std::array{1, 2, 3}}) {
      RegisterModel(model, degree, Pipeline::kFused, format, NormalMode::kFacet);
    }
    RegisterModel(model, {2, 2, 2}, Pipeline::kFused, format, NormalMode::kFacet, 20);
    RegisterFewSegments(format);
  }
  for (const std::array<int, 3> degree :
       {std::array{1, 1, 1}, std::array{3, 3, 3}, std::array{1, 2, 3}}) {
    RegisterModel(model, degree, Pipeline::kGemm, VertexFormat::kFloat32, NormalMode::kFacet);
  }
}

// The paper's comparators, for its smallest and largest model.
void TensorProduct(benchmark::State& state, const PaperModel& model) {
  const auto run = MeasureTensorProduct(**TheGpu(), ModelScenario(model, {2, 2, 2}), kRuns);
  if (!run.ok()) return Skip(state, run.status());
  const auto points = static_cast<double>(run->points);
  SetTime(state, run->times.whole);
  SetStages(state, run->times.stages);
  state.counters["surfaces"] = static_cast<double>(run->surfaces);
  state.counters["points"] = points;
  state.counters["triangles"] = static_cast<double>(run->triangles);
  state.counters["ns_point"] = run->times.whole.median * 1e6 / points;
}

void RegisterTensorProduct() {
  for (const PaperModel* model : {&PaperModels().front(), &PaperModels().back()}) {
    RegisterOnce(fmt::format("gpu/{}-{}/tensor-product-2013/2x2x2/float32/facet/10segments",
                             model->name, model->patches),
                 [model](benchmark::State& state) { TensorProduct(state, *model); });
  }
}

// The row's time is that of the control points plus the captured tessellation, by the faster source.
void TessellationShaders(benchmark::State& state, const PaperModel& model) {
  Gpu& gpu = **TheGpu();
  const Scenario& scenario = ModelScenario(model, {2, 2, 2});
  const auto times = MeasureShaderAlgorithm(gpu, scenario, kRuns);
  if (absl::IsUnavailable(times.status())) return SkipNotHere(state, times.status());
  if (!times.ok()) return Skip(state, times.status());
  const double total = times->control.median + times->captured();
  const auto points = static_cast<double>(scenario.plan->patches.size() * times->distinct_points);
  SetTime(state, {total, times->control.least + std::fmin(times->vertices.captured.least,
                                                          times->buffer.captured.least)});
  state.counters["ms:control points"] = times->control.median;
  state.counters["ms:captured, vertices"] = times->vertices.captured.median;
  state.counters["ms:captured, buffer"] = times->buffer.captured.median;
  state.counters["ms:drawn, vertices"] = times->vertices.drawn.median;
  state.counters["ms:drawn, buffer"] = times->buffer.drawn.median;
  state.counters["patch_points"] = static_cast<double>(times->distinct_points);
  state.counters["patch_triangles"] = static_cast<double>(times->triangles);
  state.counters["ns_point"] = total * 1e6 / points;
}

void RegisterTessellationShaders() {
  for (const PaperModel* model : {&PaperModels().front(), &PaperModels().back()}) {
    RegisterOnce(fmt::format("gpu/{}-{}/tessellation-shaders-2014/2x2x2/float32/facet/level{}",
                             model->name, model->patches, kShaderLevel),
                 [model](benchmark::State& state) { TessellationShaders(state, *model); });
  }
}

void RegisterScale(bool large) {
  std::vector<size_t> scale{10'000, 100'000, 1'000'000};
  if (large) scale.push_back(10'000'000);
  for (const size_t patches : scale) {
    const auto scenario = [patches]() -> const Scenario& { return ScaleScenario(patches); };
    const auto form = [&](Pipeline pipeline, VertexFormat format) {
      Register(fmt::format("scale-{}", patches), {2, 2, 2},
               {pipeline, GpuSpec(format, NormalMode::kFacet, 10)}, scenario);
    };
    form(Pipeline::kFused, VertexFormat::kFloat32);
    form(Pipeline::kFused, VertexFormat::kQuantised);
    form(Pipeline::kGemm, VertexFormat::kFloat32);
  }
}

// Device memory that a plan takes once it has a view with these normals. Nothing is timed.
void PlanMemory(benchmark::State& state, Pipeline pipeline, NormalMode normals) {
  const Scenario& scenario = ModelScenario(PaperModels().back(), {2, 2, 2});
  const auto target = Checked((**TheGpu()).backend().Prepare(scenario.plan, pipeline));
  CheckOk(target->CreateView({.segments = 1, .normals = normals}).status());
  const auto bytes = static_cast<double>(target->memory().at("device_plan"));
  const auto patches = static_cast<double>(scenario.plan->patches.size());
  SetTime(state, {});
  state.counters["patches"] = patches;
  state.counters["bytes_patch"] = bytes / patches;
}

void RegisterPlanMemory() {
  const PaperModel& model = PaperModels().back();
  for (const Pipeline pipeline :
       {Pipeline::kFused, Pipeline::kGemm, Pipeline::kGemm12, Pipeline::kControlNet}) {
    for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
      RegisterOnce(fmt::format("gpu/plan-memory/{}-{}/{}/{}", model.name, model.patches,
                               PipelineName(pipeline), NormalsName({.normals = normals})),
                   [=](benchmark::State& state) { PlanMemory(state, pipeline, normals); });
    }
  }
}

void Floors(benchmark::State& state) {
  const GpuFloors& floors = (**TheGpu()).floors();
  SetTime(state, {});
  state.counters["write_TB_s"] = floors.written / kTera;
  state.counters["copy_TB_s"] = floors.copied / kTera;
  state.counters["to_device_GB_s"] = floors.to_device / kGiga;
  state.counters["to_host_GB_s"] = floors.to_host / kGiga;
  state.counters["fma_T_s"] = floors.multiply_adds / kTera;
}

}  // namespace

void RegisterGpuBenches(bool large) {
  if (const auto gpu = TheGpu(); !gpu.ok()) {
    fmt::print(stderr, "latticed_bench: GPU benchmarks skipped: {}\n",
               std::string(gpu.status().message()));
    return;
  }
  RegisterOnce("gpu/floors", Floors);
  RegisterModels();
  RegisterTensorProduct();
  RegisterTessellationShaders();
  RegisterShapes();
  RegisterTurned();
  RegisterPlanMemory();
  RegisterGpuEditBenches();
  RegisterGpuToleranceBenches();
  RegisterGpuEncodeBenches();
  RegisterScale(large);
  RegisterGpuDevicesBenches(large);
}

}  // namespace latticed::bench
