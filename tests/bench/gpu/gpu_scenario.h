// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What benchmarks on a GPU run on: as many patches as the paper's models have, or as a scale asks
// for (exact_mesh.h), and views of them that are verified before anybody times them.
#ifndef LATTICED_TESTS_BENCH_GPU_GPU_SCENARIO_H_
#define LATTICED_TESTS_BENCH_GPU_GPU_SCENARIO_H_

#include <array>
#include <compare>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tests/bench/gpu/gpu.h"
#include "tests/bench/paper/shaders/measure_shaders.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {

struct PaperModel {
  const char* name;
  size_t patches;
};

// In the order of the paper's tables.
[[nodiscard]] std::span<const PaperModel> PaperModels();

// Made on the first call and kept: exactly as many patches; a few percent more above a million.
[[nodiscard]] const Scenario& ModelScenario(const PaperModel& model, std::array<int, 3> degree);
[[nodiscard]] const Scenario& ScaleScenario(size_t patches);

// Evaluated with control_points[0] and compared with the definition. kUnimplemented where the backend
// lacks the pipeline, kInternal where the result is wrong; other errors end the program.
[[nodiscard]] absl::StatusOr<std::unique_ptr<DeformView>> MakeGpuView(Backend& backend,
                                                                      const Scenario& scenario,
                                                                      Pipeline pipeline,
                                                                      const ViewSpec& spec);

// The tensor-product comparator: its surfaces are verified (tensor_verify.h), then timed.
// kUnimplemented where there can be none of the plan, kInternal where they are wrong.
struct TensorRun {
  size_t surfaces = 0, points = 0, triangles = 0;
  TensorTimes times;
};
[[nodiscard]] absl::StatusOr<TensorRun> MeasureTensorProduct(Gpu& gpu, const Scenario& scenario,
                                                             int runs);

// The tessellation-shader comparator, verified too: control points by CUDA, tessellation by OpenGL
// on the same device. The errors are those of measure_shaders.h.
[[nodiscard]] absl::StatusOr<ShaderTimes> MeasureShaderAlgorithm(Gpu& gpu, const Scenario& scenario,
                                                                 int runs);

// Control points that touch patches, and how many; those that touch the fewest first.
struct ControlPointEffect {
  uint64_t patches;
  uint32_t point;
  friend auto operator<=>(const ControlPointEffect&, const ControlPointEffect&) = default;
};
[[nodiscard]] std::vector<ControlPointEffect> ControlPointsByEffect(const Scenario& scenario);
// Those that one touches.
[[nodiscard]] std::vector<uint32_t> DirtyChunks(const Scenario& scenario, uint32_t control_point);

// All chunks, control points by turns.
[[nodiscard]] GpuWork AllChunks(const Scenario& scenario, DeformView& view);

[[nodiscard]] ViewSpec GpuSpec(VertexFormat format, NormalMode normals, int segments);

// Device time of one stage, 0 where there is none; of all of them.
[[nodiscard]] double StageMs(const std::vector<GpuStage>& stages, std::string_view name);
[[nodiscard]] double SumMs(const std::vector<GpuStage>& stages);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_GPU_GPU_SCENARIO_H_
