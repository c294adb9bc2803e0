// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The times of the paper's tables (paper.h) for one model: medians, in milliseconds. Every view is
// verified first; a wrong one ends the program. NaN if there is no GPU or no such pipeline.
#ifndef LATTICED_TESTS_BENCH_PAPER_PAPER_MEASURE_H_
#define LATTICED_TESTS_BENCH_PAPER_PAPER_MEASURE_H_

#include <limits>
#include <string_view>

#include "tests/bench/gpu/gpu_scenario.h"

namespace latticed::bench {

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

struct PaperGpuTimes {
  // gemm12
  double formula18 = kNotMeasured;     // three products and the rounding to float32
  double formulas2123 = kNotMeasured;  // nine products
  double trivial = kNotMeasured;       // one whole evaluation
  // gemm
  double edit = kNotMeasured;  // host: control points prepared and the copy enqueued
  double copy = kNotMeasured;
  double samples = kNotMeasured;
  double formula24 = kNotMeasured;  // timed apart, because the pipeline keeps its result
  double formula25 = kNotMeasured;
  double rearrange = kNotMeasured;  // includes normals
  double shared = kNotMeasured;     // shared points for watertightness, not in the paper
  double optimal = kNotMeasured;    // one whole evaluation, without (24)
  // control-net
  double formulas617 = kNotMeasured;  // both products
  // the tensor-product comparator, or why there is none
  absl::StatusOr<TensorRun> tensor = absl::UnavailableError("there is no GPU");
  // the tessellation-shader comparator, or why there is none
  absl::StatusOr<ShaderTimes> shaders = absl::UnavailableError("there is no GPU");
  // fused
  double fused = kNotMeasured;
  // drawing of the vertices that any of the pipelines leaves, or why there is none
  absl::StatusOr<DrawingTimes> drawing = absl::UnavailableError("there is no GPU");

  // kNotMeasured where there is no such time.
  double drawing_ms() const { return drawing.ok() ? drawing->times.median : kNotMeasured; }
  double tensor_ms() const { return tensor.ok() ? tensor->times.whole.median : kNotMeasured; }
  double tensor_stage_ms(std::string_view stage) const {
    return tensor.ok() ? StageMs(tensor->times.stages, stage) : kNotMeasured;
  }
  // Control points, tessellation and drawing.
  double drawn_shaders_ms() const {
    return shaders.ok() ? shaders->control.median + shaders->drawn() : kNotMeasured;
  }
};
[[nodiscard]] PaperGpuTimes MeasureOnGpu(const Scenario& scenario);

struct PaperCpuTimes {
  double trivial = 0, optimal = 0, fused = 0;  // all threads
  double optimal_alone = 0;                    // one thread
};
[[nodiscard]] PaperCpuTimes MeasureOnCpu(const Scenario& scenario);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_PAPER_MEASURE_H_
