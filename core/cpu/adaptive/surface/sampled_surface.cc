// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/adaptive/surface/sampled_surface.h"

#include <algorithm>

#include "core/adaptive/net_curvature.h"
#include "core/base/status_macros.h"
#include "core/cpu/adaptive/surface/raised_bounds.h"
#include "core/cpu/gemm/cpu_gemm.h"
#include "core/points/local_map.h"
#include "core/points/normal_kernel.h"
#include "core/points/point_blocks.h"
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
  const AdaptivePattern& pattern = target.pattern;
  const bool has_normals = spec_.normals != NormalMode::kNone;
  static thread_local OwnBlock block;
  auto& [places, numbers, values] = block;
  for (size_t i = 0; i < pattern.points.size();) {
    places.count = 0;
    for (; i < pattern.points.size() && places.count < points::kBlockPoints; ++i) {
      const auto& steps = pattern.points[i];
      if (!has_normals && *std::ranges::min_element(steps) == 0) continue;  // on an edge
      for (size_t c = 0; c < 3; ++c) {
        places.barycentrics[c][places.count] = static_cast<double>(steps[c]) / pattern.denominator;
      }
      numbers[places.count++] = i;
    }
    frame_->sampler.sums().Evaluate(
        target.patch, places,
        has_normals ? std::span<const Vec3d>(kWorldMap.scale) : std::span<const Vec3d>(), values);
    for (size_t k = 0; k < places.count; ++k) {
      target.writer.WritePosition(target.place, numbers[k], points::At(values.position, k));
    }
    if (has_normals) WriteNormals(target, block);
  }
}

void SampledSurface::WriteNormals(const Target& target, const OwnBlock& block) const {
  const bool smooth = spec_.normals == NormalMode::kSmooth;
  const DirectFfd& direct = frame_->direct;
  const Vec3d facet = smooth ? Vec3d{} : direct.RestFacetNormal(target.patch);
  const auto& [places, numbers, values] = block;
  points::BlockVec rest;
  for (size_t k = 0; k < places.count; ++k) {
    const auto& b = places.barycentrics;
    points::Set(
        rest, k,
        smooth ? Unit(direct.RestSmoothNormal(target.patch, {b[0][k], b[1][k], b[2][k]})) : facet);
  }
  points::BlockNormals normals;
  points::MakeNormals(kWorldMap, values.along, {rest[0].data(), rest[1].data(), rest[2].data()},
                      places.count, normals);
  for (size_t k = 0; k < places.count; ++k) {
    Vec3d normal = points::At(normals.value, k);
    if (normal == Vec3d{}) {
      normal = direct.SubstituteNormal(
          target.patch, smooth ? DirectFfd::Normal::kSmooth : DirectFfd::Normal::kFacet);
    }
    target.writer.WriteNormal(target.place, numbers[k], ToFloat(normal));
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
