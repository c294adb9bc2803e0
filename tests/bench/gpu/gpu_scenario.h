// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The scenarios of GPU benchmarks: the patch counts of the paper's models, or a given count
// (exact_mesh.h). Their views are verified before they are timed.
#ifndef LATTICED_TESTS_BENCH_GPU_GPU_SCENARIO_H_
#define LATTICED_TESTS_BENCH_GPU_GPU_SCENARIO_H_

#include <array>
#include <compare>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tests/bench/gpu/gpu.h"
#include "tests/bench/paper/printed_tables.h"
#include "tests/bench/paper/shaders/measure_shaders.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {

// In the order of the paper's tables.
[[nodiscard]] inline std::span<const PaperModel> PaperModels() { return kPaperModels; }

// Made on the first call and kept. Exactly the number of patches; above a million, a few percent more.
[[nodiscard]] const Scenario& ModelScenario(const PaperModel& model, std::array<int, 3> degree);
[[nodiscard]] const Scenario& ScaleScenario(size_t patches);
// A torus of 93,312 triangles under two lattices (MakeTurnedScenario).
[[nodiscard]] const Scenario& TurnedTorus();

// A view, evaluated with control_points[0] and compared with the definition. kUnimplemented if the
// backend lacks the pipeline, kInternal if the result is wrong. Other errors end the program.
[[nodiscard]] absl::StatusOr<std::unique_ptr<DeformView>> MakeGpuView(Backend& backend,
                                                                      const Scenario& scenario,
                                                                      Pipeline pipeline,
                                                                      const ViewSpec& spec);

// Verifies the surfaces of the tensor-product comparator (tensor_verify.h), then times them.
// kUnimplemented if the plan can have none, kInternal if they are wrong.
struct TensorRun {
  size_t surfaces = 0, points = 0, triangles = 0;
  TensorTimes times;
};
[[nodiscard]] absl::StatusOr<TensorRun> MeasureTensorProduct(Gpu& gpu, const Scenario& scenario,
                                                             int runs);

// Verifies and times the tessellation-shader comparator: control points by CUDA, tessellation by
// OpenGL on the same device. Its errors are in measure_shaders.h.
[[nodiscard]] absl::StatusOr<ShaderTimes> MeasureShaderAlgorithm(Gpu& gpu, const Scenario& scenario,
                                                                 int runs);

// A control point and how many patches it touches. Points that touch none are left out; ascending.
struct ControlPointEffect {
  uint64_t patches;
  uint32_t point;
  friend auto operator<=>(const ControlPointEffect&, const ControlPointEffect&) = default;
};
[[nodiscard]] std::vector<ControlPointEffect> ControlPointsByEffect(const Scenario& scenario);
// The chunks that the control point touches.
[[nodiscard]] std::vector<uint32_t> DirtyChunks(const Scenario& scenario, uint32_t control_point);

// Evaluates all chunks, alternating between the two sets of control points.
[[nodiscard]] GpuWork AllChunks(const Scenario& scenario, DeformView& view);

[[nodiscard]] ViewSpec GpuSpec(VertexFormat format, NormalMode normals, int segments);

// Device time of one stage (0 if there is none), and of all stages.
[[nodiscard]] inline double StageMs(const std::vector<GpuStage>& stages, std::string_view name) {
  for (const GpuStage& stage : stages) {
    if (stage.name == name) return stage.device_ms;
  }
  return 0;
}
[[nodiscard]] double SumMs(const std::vector<GpuStage>& stages);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_GPU_GPU_SCENARIO_H_
