// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/adaptive/surface/sampled_surface.h"

#include <algorithm>

#include "core/adaptive/net_curvature.h"
#include "core/base/status_macros.h"
#include "core/cpu/adaptive/surface/raised_bounds.h"
#include "core/cpu/gemm/cpu_gemm.h"
#include "core/view/view_layout.h"

namespace latticed {

SampledSurface::Frame::Frame(const SampledSurface& surface, std::span<const Vec3d> control_points)
    : sampler(*surface.plan_, surface.stage_, control_points),
      direct(*surface.plan_, control_points),
      attached(AttachedSeams(*surface.plan_, control_points)),
      norms(surface.slack_.Norms(control_points)) {}

void SampledSurface::Begin(std::span<const Vec3d> control_points) {
  frame_.emplace(*this, control_points);
}

absl::Status SampledSurface::Bound(std::span<const uint32_t> chunks, Take take) {
  return arena_.TryEach(chunks.size(), [&](size_t i) { return BoundChunk(chunks[i], take); });
}

uint64_t SampledSurface::MostBytes(const DeformPlan& plan, size_t threads) {
  // Samples and nets of a chunk; control points and their norms.
  const auto m = static_cast<uint64_t>(BernsteinCount(plan.surface_degree()));
  return threads * 2 * 3 * limits::kPatchesPerChunk * m * sizeof(double) +
         plan.control_point_count() * (sizeof(Vec3d) + sizeof(double));
}

absl::Status SampledSurface::BoundChunk(uint32_t chunk, Take take) const {
  const auto [first, last] = plan_->ChunkPatches(chunk);
  const size_t count = last - first, m = stage_.m, columns = 3 * count;
  static thread_local std::vector<double> samples, nets;
  samples.resize(m * columns);
  nets.resize(m * columns);
  for (size_t t = 0; t < count; ++t) {
    frame_->sampler.Sample(first + t, samples.data() + t * m, nullptr, {}, count * m);
  }
  LATTICED_RETURN_IF_ERROR(CpuGemm(MatrixView<const double>{stage_.inverse.data(), m, m, m},
                                   MatrixView<const double>{samples.data(), m, columns, m},
                                   MatrixView<double>{nets.data(), m, columns, m}));
  for (size_t t = 0; t < count; ++t) {
    const auto net = [&](int i) {
      const double* x = nets.data() + t * m + i;
      return Vec3d{x[0], x[count * m], x[2 * count * m]};
    };
    const double slack = slack_.Of(first + t, frame_->norms);
    take(first + t, RaisedBounds(BoundNet(stage_.degree, net), slack));
  }
  return absl::OkStatus();
}

absl::Status SampledSurface::Write(std::span<const uint32_t> chunks,
                                   std::span<const uint16_t> codes, const QuantisationBox& box,
                                   ChunkVertices& vertices) {
  const VertexWriter writer = MakeVertexWriter(*plan_, spec_, box);
  arena_.ForEach(chunks.size(), [&](size_t i) { WriteChunk(chunks[i], codes, writer, vertices); });
  frame_.reset();
  return absl::OkStatus();
}

void SampledSurface::WriteChunk(uint32_t chunk, std::span<const uint16_t> codes,
                                const VertexWriter& writer, ChunkVertices& vertices) const {
  const auto [first, last] = plan_->ChunkPatches(chunk);
  const size_t points = PatternPoints(codes.subspan(first, last - first));
  PatchPlace place{vertices.Resize(chunk, points).data(), points, 0};
  for (size_t p = first; p < last; ++p) {
    const AdaptivePattern& pattern = AdaptivePattern::Get(*PatternKey::FromCode(codes[p]));
    const Target target{p, pattern, writer, place};
    WriteOwn(target);
    WriteShared(target);
    place.first_point += pattern.points.size();
  }
}

// Normals of all points, and positions inside; those on edges are written over.
void SampledSurface::WriteOwn(const Target& target) const {
  const bool smooth = spec_.normals == NormalMode::kSmooth;
  const auto kind = smooth ? DirectFfd::Normal::kSmooth : DirectFfd::Normal::kFacet;
  for (size_t i = 0; i < target.pattern.points.size(); ++i) {
    std::array<double, 3> b;
    for (size_t c = 0; c < 3; ++c) {
      b[c] = static_cast<double>(target.pattern.points[i][c]) / target.pattern.denominator;
    }
    if (spec_.normals == NormalMode::kNone) {
      if (*std::ranges::min_element(b) == 0) continue;  // on an edge
      const Vec3d world = frame_->direct.EvaluatePosition(target.patch, b).position;
      target.writer.WritePosition(target.place, i, world - plan_->local_origin);
      continue;
    }
    const DirectFfd::SurfacePoint point = frame_->direct.Evaluate(target.patch, b, kind);
    target.writer.WritePosition(target.place, i, point.position - plan_->local_origin);
    target.writer.WriteNormal(target.place, i, ToFloat(point.normal));
  }
}

void SampledSurface::WriteShared(const Target& target) const {
  const Patch& patch = plan_->patches[target.patch];
  for (size_t e = 0; e < 3; ++e) {
    const auto& points = target.pattern.edge_points[e];
    const size_t segments = points.size() - 1;
    const uint32_t v = patch.vertex[e];
    const PlanVertex& vertex = plan_->vertices[v];
    target.writer.WritePosition(target.place, points[0],
                                Shared(patch.box, vertex.box, vertex.seam, {v, v}, 0));
    const PlanEdge& edge = plan_->edges[patch.edge[e]];
    for (size_t k = 1; k < segments; ++k) {
      const double t = static_cast<double>(k) / static_cast<double>(segments);
      target.writer.WritePosition(target.place, points[patch.edge_reversed[e] ? segments - k : k],
                                  Shared(patch.box, edge.box, edge.seam, edge.vertex, t));
    }
  }
}

Vec3d SampledSurface::Shared(uint32_t patch_box, uint32_t box, uint32_t seam,
                             const std::array<uint32_t, 2>& ends, double t) const {
  const bool rests =
      patch_box == plan_->outside_box() || (seam != kNoIndex && frame_->attached[seam]);
  const uint32_t owner = rests ? plan_->outside_box() : box;
  return frame_->direct.OnEdge(owner, ends, t) - plan_->local_origin;
}

}  // namespace latticed
