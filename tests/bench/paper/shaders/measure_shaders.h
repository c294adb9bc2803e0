// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The tessellation-shader comparator on a scenario, verified, then timed; and the drawing of vertices.
// A build without libepoxy compiles measure_shaders_stub.cc instead of measure_shaders.cc.
//
// Times    of the tessellation or the drawing alone, by the device's clock (GL_TIME_ELAPSED). CUDA makes the nets
//          and times that part. Handing the nets from CUDA to OpenGL is not counted
// Errors   kUnimplemented in the stub; kUnavailable if there is no matching device; kInternal if
//          captured vertices differ from the definition
// Threads  one, always the same: the context stays until the process ends
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_MEASURE_SHADERS_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_MEASURE_SHADERS_H_

#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "tests/bench/gpu/gpu.h"
#include "tests/bench/paper/bezier_net/bezier_net.h"
#include "tests/bench/paper/shaders/shader_device.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {

inline constexpr int kShaderLevel = 10;

struct ShaderTimes {
  std::string device;
  GpuTimes control;  // by formula (6); MeasureShaders gets the nets and leaves it unset
  size_t triangles = 0, distinct_points = 0;  // per patch
  // Control points as vertices of patches (small nets only), and read from a buffer.
  struct Source {
    static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    GpuTimes captured{kNone, kNone};  // into memory: positions and normals
    GpuTimes drawn{kNone, kNone};     // into a picture
  };
  Source vertices, buffer;

  // By the faster source.
  double captured() const { return std::fmin(vertices.captured.median, buffer.captured.median); }
  double drawn() const { return std::fmin(vertices.drawn.median, buffer.drawn.median); }
};

// `nets` belong to control_points[0].
[[nodiscard]] absl::StatusOr<ShaderTimes> MeasureShaders(const Scenario& scenario,
                                                         std::span<const NetPoint> nets,
                                                         ShaderDevice device, int runs);

// Drawing of vertices that are in the device's memory (drawing/vertex_drawing.h).
struct DrawingTimes {
  std::string device;
  size_t triangles = 0;  // of all patches
  GpuTimes times;
};

// Draws the vertices of `view`, which is verified, for control_points[0]. kInvalidArgument unless they
// are float32 with normals and have no tolerance. kInternal if the device draws another number of triangles.
[[nodiscard]] absl::StatusOr<DrawingTimes> MeasureDrawing(const Scenario& scenario,
                                                          DeformView& view, ShaderDevice device,
                                                          int runs);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_MEASURE_SHADERS_H_
