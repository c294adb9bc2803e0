// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/shaders/measure_shaders.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "tests/bench/shaders/gl_context.h"
#include "tests/bench/shaders/shader_tessellator.h"
#include "tests/bench/shaders/shader_verify.h"

namespace latticed::bench {
namespace {

// As many places of as many patches each as views are compared at.
constexpr size_t kVerifiedPlaces = 64;

// Made on the first call.
const absl::StatusOr<std::unique_ptr<GlContext>>& TheContext(ShaderDevice device) {
  using Context = absl::StatusOr<std::unique_ptr<GlContext>>;
  static auto* const contexts = new std::map<ShaderDevice, Context>;
  const auto found = contexts->find(device);
  if (found != contexts->end()) return found->second;
  return contexts->emplace(device, GlContext::Create(device)).first->second;
}

// Half the side of a cube around the local origin that holds the surface: the hull of its control
// points.
float Extent(const Scenario& scenario) {
  double extent = 0;
  for (const Vec3d& p : scenario.control_points[0]) {
    const Vec3d relative = p - scenario.plan->local_origin;
    for (int axis = 0; axis < 3; ++axis) extent = std::max(extent, std::abs(relative[axis]));
  }
  return static_cast<float>(extent);
}

absl::StatusOr<ShaderPrecision> Compare(const Scenario& scenario, ShaderTessellator& tessellator) {
  constexpr size_t kTogether = limits::kPatchesPerChunk;
  const size_t patches = tessellator.patches();
  const size_t stride = std::max(kTogether, patches / kVerifiedPlaces);
  ShaderPrecision worst;
  for (size_t first = 0; first < patches; first += stride) {
    const size_t count = std::min(kTogether, patches - first);
    const auto vertices = tessellator.Capture(first, count);
    if (!vertices.ok()) return vertices.status();
    const auto found =
        CompareShaders(*scenario.plan, scenario.control_points[0], first, count, *vertices);
    if (!found.ok()) return found.status();
    worst.Include(*found);
  }
  return worst;
}

absl::Status MeasureSource(const Scenario& scenario, std::span<const NetPoint> nets,
                           NetSource source, int runs, ShaderTimes& times) {
  const auto tessellator = ShaderTessellator::Create(
      {.degree = scenario.plan->structure.patch_degree(), .level = kShaderLevel, .source = source},
      nets);
  if (!tessellator.ok()) return tessellator.status();
  const auto precision = Compare(scenario, **tessellator);
  if (!precision.ok()) return precision.status();
  if (auto s = CheckShaders(*precision); !s.ok()) return s;
  const auto captured = (*tessellator)->TimeCaptured(runs);
  if (!captured.ok()) return captured.status();
  const auto drawn = (*tessellator)->TimeDrawn(Extent(scenario), runs);
  if (!drawn.ok()) return drawn.status();
  times.triangles = (*tessellator)->triangles_per_patch();
  times.distinct_points = precision->distinct_points;
  (source == NetSource::kBuffer ? times.buffer : times.vertices) = {*captured, *drawn};
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ShaderTimes> MeasureShaders(const Scenario& scenario, std::span<const NetPoint> nets,
                                           ShaderDevice device, int runs) {
  const auto& context = TheContext(device);
  if (!context.ok()) return context.status();
  if (auto s = (*context)->MakeCurrent(); !s.ok()) return s;
  ShaderTimes times{.device = (*context)->description()};
  const int points = BernsteinCount(scenario.plan->structure.patch_degree()) + 1;
  if (points <= kMostPatchVertices) {
    if (auto s = MeasureSource(scenario, nets, NetSource::kVertices, runs, times); !s.ok()) {
      return s;
    }
  }
  if (auto s = MeasureSource(scenario, nets, NetSource::kBuffer, runs, times); !s.ok()) return s;
  return times;
}

}  // namespace latticed::bench
