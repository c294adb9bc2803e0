// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/shaders/measure_shaders.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include "core/base/status_macros.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "tests/bench/paper/shaders/drawing/vertex_drawing.h"
#include "tests/bench/paper/shaders/gl_context.h"
#include "tests/bench/paper/shaders/shader_tessellator.h"
#include "tests/bench/paper/shaders/shader_verify.h"

namespace latticed::bench {
namespace {

// The number of places whose vertices are compared, each with the patches of one chunk, as in Verify.
constexpr size_t kVerifiedPlaces = 64;

// Made on the first call.
const absl::StatusOr<std::unique_ptr<GlContext>>& TheContext(ShaderDevice device) {
  using Context = absl::StatusOr<std::unique_ptr<GlContext>>;
  static auto* const contexts = new std::map<ShaderDevice, Context>;
  const auto found = contexts->find(device);
  if (found != contexts->end()) return found->second;
  return contexts->emplace(device, GlContext::Create(device)).first->second;
}

// Half the side of a cube around the local origin that holds all control points, and with them the
// surface.
float Extent(const Scenario& scenario) {
  double extent = 0;
  for (const Vec3d& p : scenario.control_points[0]) {
    const Vec3d relative = p - scenario.plan->local_origin;
    for (int axis = 0; axis < 3; ++axis) extent = std::max(extent, std::abs(relative[axis]));
  }
  return static_cast<float>(extent);
}

absl::StatusOr<ComparatorPrecision> Compare(const Scenario& scenario,
                                            ShaderTessellator& tessellator) {
  constexpr size_t kTogether = limits::kPatchesPerChunk;
  const size_t patches = tessellator.patches();
  const size_t stride = std::max(kTogether, patches / kVerifiedPlaces);
  ComparatorPrecision worst;
  for (size_t first = 0; first < patches; first += stride) {
    const size_t count = std::min(kTogether, patches - first);
    LATTICED_ASSIGN_OR_RETURN(const auto vertices, tessellator.Capture(first, count));
    LATTICED_ASSIGN_OR_RETURN(
        const auto found,
        CompareShaders(*scenario.plan, scenario.control_points[0], first, count, vertices));
    worst.Include(found);
  }
  return worst;
}

absl::Status MeasureSource(const Scenario& scenario, std::span<const NetPoint> nets,
                           NetSource source, int runs, ShaderTimes& times) {
  LATTICED_ASSIGN_OR_RETURN(
      const auto tessellator,
      ShaderTessellator::Create({.degree = scenario.plan->structure.patch_degree(),
                                 .level = kShaderLevel,
                                 .source = source},
                                nets));
  LATTICED_ASSIGN_OR_RETURN(const auto precision, Compare(scenario, *tessellator));
  LATTICED_RETURN_IF_ERROR(precision.Check(kShaderNormalError));
  LATTICED_ASSIGN_OR_RETURN(const auto captured, tessellator->TimeCaptured(runs));
  LATTICED_ASSIGN_OR_RETURN(const auto drawn, tessellator->TimeDrawn(Extent(scenario), runs));
  times.triangles = tessellator->triangles_per_patch();
  times.distinct_points = precision.distinct_points;
  (source == NetSource::kBuffer ? times.buffer : times.vertices) = {captured, drawn};
  return absl::OkStatus();
}

// The vertices of all chunks.
absl::StatusOr<std::vector<float>> ReadAll(const Scenario& scenario, DeformView& view) {
  const int segments = view.spec().segments;
  const size_t points =
      scenario.plan->patches.size() * static_cast<size_t>(PointsPerPatch(segments));
  std::vector<float> vertices(points * VertexDrawing::kFloatsPerVertex);
  auto bytes =
      std::span(reinterpret_cast<uint8_t*>(vertices.data()), vertices.size() * sizeof(float));
  for (const uint32_t chunk : scenario.all_chunks) {
    const size_t size = ChunkPoints(*scenario.plan, chunk, segments) * BytesPerPoint(view.spec());
    LATTICED_RETURN_IF_ERROR(view.Read(chunk, bytes.first(size)));
    bytes = bytes.subspan(size);
  }
  return vertices;
}

}  // namespace

absl::StatusOr<ShaderTimes> MeasureShaders(const Scenario& scenario, std::span<const NetPoint> nets,
                                           ShaderDevice device, int runs) {
  const auto& context = TheContext(device);
  if (!context.ok()) return context.status();
  LATTICED_RETURN_IF_ERROR((*context)->MakeCurrent());
  ShaderTimes times{.device = (*context)->description()};
  const int points = BernsteinCount(scenario.plan->structure.patch_degree()) + 1;
  if (points <= kMostPatchVertices) {
    LATTICED_RETURN_IF_ERROR(MeasureSource(scenario, nets, NetSource::kVertices, runs, times));
  }
  LATTICED_RETURN_IF_ERROR(MeasureSource(scenario, nets, NetSource::kBuffer, runs, times));
  return times;
}

absl::StatusOr<DrawingTimes> MeasureDrawing(const Scenario& scenario, DeformView& view,
                                            ShaderDevice device, int runs) {
  const ViewSpec& spec = view.spec();
  constexpr size_t kBytes = VertexDrawing::kFloatsPerVertex * sizeof(float);
  if (spec.format != VertexFormat::kFloat32 || spec.tolerance > 0 ||
      BytesPerPoint(spec) != kBytes) {
    return absl::InvalidArgumentError("only float32 with normals and without a tolerance is drawn");
  }
  const auto& context = TheContext(device);
  if (!context.ok()) return context.status();
  LATTICED_RETURN_IF_ERROR((*context)->MakeCurrent());
  LATTICED_RETURN_IF_ERROR(
      view.Evaluate(scenario.control_points[0], scenario.box, scenario.all_chunks));
  LATTICED_ASSIGN_OR_RETURN(const auto vertices, ReadAll(scenario, view));
  LATTICED_ASSIGN_OR_RETURN(const auto drawing, VertexDrawing::Create(vertices, spec.segments));
  DrawingTimes times{
      .device = (*context)->description(), .triangles = drawing->CountTriangles(), .times = {}};
  const size_t expected =
      scenario.plan->patches.size() * static_cast<size_t>(TrianglesPerPatch(spec.segments));
  if (times.triangles != expected) {
    return absl::InternalError(
        fmt::format("OpenGL drew {} triangles of {}", times.triangles, expected));
  }
  LATTICED_ASSIGN_OR_RETURN(times.times, drawing->TimeDrawn(Extent(scenario), runs));
  return times;
}

}  // namespace latticed::bench
