// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/paper_measure.h"

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "tests/bench/verify.h"

namespace latticed::bench {
namespace {

constexpr int kGpuRuns = 40;
constexpr int kCpuRuns = 5;

using Clock = std::chrono::steady_clock;

ViewSpec PaperSpec() { return GpuSpec(VertexFormat::kFloat32, NormalMode::kFacet, 10); }

// Null if the backend lacks the pipeline.
std::unique_ptr<DeformView> View(Gpu& gpu, const Scenario& scenario, Pipeline pipeline) {
  auto view = MakeGpuView(gpu.backend(), scenario, pipeline, PaperSpec());
  if (absl::IsUnimplemented(view.status())) return nullptr;
  CheckOk(view.status());
  return *std::move(view);
}

void MeasureTrivial(Gpu& gpu, const Scenario& scenario, PaperGpuTimes& times) {
  const auto view = View(gpu, scenario, Pipeline::kGemm12);
  const GpuWork work = AllChunks(scenario, *view);
  const auto stages = gpu.Stages(*view, work, kGpuRuns);
  times.formula18 = StageMs(stages, "stack");
  times.formulas2123 = StageMs(stages, "products");
  times.trivial = gpu.DeviceTime(*view, work, kGpuRuns).median;
}

void MeasureOptimal(Gpu& gpu, const Scenario& scenario, PaperGpuTimes& times) {
  const auto view = View(gpu, scenario, Pipeline::kGemm);
  const GpuWork work = AllChunks(scenario, *view);
  const auto stages = gpu.Stages(*view, work, kGpuRuns);
  for (const GpuStage& stage : stages) {
    if (stage.name == "copy") times.edit = stage.host_ms;
  }
  times.copy = StageMs(stages, "copy");
  times.samples = StageMs(stages, "samples");
  times.formula25 = StageMs(stages, "products");
  times.rearrange = StageMs(stages, "rearrange");
  times.shared = StageMs(stages, "rest");
  times.formula24 =
      gpu.Formula24(scenario.plan->structure.patch_degree(), PaperSpec().segments, kGpuRuns).median;
  times.optimal = gpu.DeviceTime(*view, work, kGpuRuns).median;
}

double CpuTime(const Scenario& scenario, Pipeline pipeline, int threads) {
  const auto view = MakeView(scenario, pipeline, PaperSpec(), threads);
  CheckOk(Verify(scenario, pipeline, *view));
  std::vector<double> times;
  for (size_t run = 0; run < kCpuRuns; ++run) {
    const auto start = Clock::now();
    CheckOk(
        view->Evaluate(scenario.control_points[(run + 1) % 2], scenario.box, scenario.all_chunks));
    times.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

}  // namespace

PaperGpuTimes MeasureOnGpu(const Scenario& scenario) {
  PaperGpuTimes times;
  const auto found = TheGpu();
  if (!found.ok()) return times;
  Gpu& gpu = **found;
  MeasureTrivial(gpu, scenario, times);
  MeasureOptimal(gpu, scenario, times);
  times.tensor = MeasureTensorProduct(gpu, scenario, kGpuRuns);
  if (!absl::IsUnimplemented(times.tensor.status())) CheckOk(times.tensor.status());
  times.shaders = MeasureShaderAlgorithm(gpu, scenario, kGpuRuns);
  if (absl::IsInternal(times.shaders.status())) CheckOk(times.shaders.status());
  {
    const auto view = View(gpu, scenario, Pipeline::kControlNet);
    times.formulas617 =
        StageMs(gpu.Stages(*view, AllChunks(scenario, *view), kGpuRuns), "products");
  }
  if (const auto view = View(gpu, scenario, Pipeline::kFused); view != nullptr) {
    times.fused = gpu.DeviceTime(*view, AllChunks(scenario, *view), kGpuRuns).median;
    times.drawing = MeasureDrawing(scenario, *view, ShaderDevice::kCuda, kGpuRuns);
    if (absl::IsInternal(times.drawing.status())) CheckOk(times.drawing.status());
  }
  return times;
}

PaperCpuTimes MeasureOnCpu(const Scenario& scenario) {
  constexpr int kAllThreads = 0;
  return {.trivial = CpuTime(scenario, Pipeline::kGemm12, kAllThreads),
          .optimal = CpuTime(scenario, Pipeline::kGemm, kAllThreads),
          .fused = CpuTime(scenario, Pipeline::kFused, kAllThreads),
          .optimal_alone = CpuTime(scenario, Pipeline::kGemm, 1)};
}

}  // namespace latticed::bench
