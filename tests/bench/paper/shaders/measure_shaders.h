// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The tessellation-shader comparator on a scenario: verified, then timed. A build without libepoxy
// compiles measure_shaders_stub.cc instead of measure_shaders.cc.
//
// Times    of the tessellation alone, by the device's clock (GL_TIME_ELAPSED); making the nets is
//          CUDA's part and timed there, and nothing is counted for handing them from one to the other
// Errors   kUnimplemented in the stub; kUnavailable without such a device; kInternal where captured
//          vertices are not what the definition says
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
  GpuTimes control;  // by formula (6): not of MeasureShaders, which is given the nets
  size_t triangles = 0, distinct_points = 0;  // a patch
  // Control points as vertices of patches, and read from a buffer; the former for small nets alone.
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

// `nets` are those of control_points[0].
[[nodiscard]] absl::StatusOr<ShaderTimes> MeasureShaders(const Scenario& scenario,
                                                         std::span<const NetPoint> nets,
                                                         ShaderDevice device, int runs);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_MEASURE_SHADERS_H_
