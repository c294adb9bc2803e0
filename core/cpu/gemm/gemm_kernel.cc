// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/gemm/gemm_kernel.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/status_macros.h"
#include "core/ffd/plan/dirty_set.h"
#include "core/ffd/tessellation_pattern.h"
#include "core/ffd/weights/weight_change.h"
#include "core/view/view_layout.h"

namespace latticed {
namespace {

constexpr size_t kCopiesPerTask = 2'048;  // about 100 us

// Whether the surface's derivatives are those of the definition. In a patch whose source triangle is so thin that its weight
// has no gradient, the corners' weights change the products all the same.
bool HasGradient(const DeformPlan& plan, size_t patch) {
  const Vec3d gradient = plan.PatchWeightGradient(patch);
  const std::array<double, 3> weights = plan.CornerWeights(patch);
  const auto& v = plan.patches[patch].vertex;
  const auto is_steady = [&](size_t c) {
    const Vec3d side = plan.vertices[v[c]].world - plan.vertices[v[0]].world;
    return IsByGradient(Dot(gradient, side), weights[c] - weights[0]);
  };
  return is_steady(1) && is_steady(2);
}

}  // namespace

struct GemmKernel::Frame {
  PatchSampler sampler;
  DirectFfd direct;
  VertexWriter writer;
  std::span<uint8_t> vertices;
};

GemmKernel::GemmKernel(std::shared_ptr<const DeformPlan> plan,
                       std::shared_ptr<const SharedPoints> shared, const StageMatrices& stage,
                       Pipeline pipeline, const ViewSpec& spec, std::shared_ptr<CpuContext> context)
    : owned_plan_(std::move(plan)),
      plan_(*owned_plan_),
      shared_(std::move(shared)),
      is_old_(plan_.chunk_count(), true),
      stage_(stage),
      spec_(spec),
      layout_(MakeVertexLayout(plan_, spec)),
      stages_(pipeline, stage, spec.normals != NormalMode::kNone),
      context_(std::move(context)) {}

absl::Status GemmKernel::Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                                  std::span<const uint32_t> chunks, std::span<uint8_t> vertices) {
  LATTICED_RETURN_IF_ERROR(stages_.Begin());
  const std::vector<uint32_t> evaluated = Begin(control_points, chunks);
  const Frame frame{{plan_, stage_, control_points},
                    {plan_, control_points},
                    MakeVertexWriter(plan_, spec_, box),
                    vertices};
  LATTICED_RETURN_IF_ERROR(context_->arena.TryEach(evaluated.size(), [&](size_t i) {
    return EvaluateChunk(frame, evaluated[i], tiles_.local());
  }));
  CopySharedPoints(frame, AttachedSeams(plan_, control_points), evaluated);
  for (const uint32_t chunk : evaluated) is_old_[chunk] = false;
  return absl::OkStatus();
}

std::vector<uint32_t> GemmKernel::Begin(std::span<const Vec3d> control_points,
                                        std::span<const uint32_t> named) {
  const bool is_whole = named.size() == plan_.chunk_count();
  std::vector<uint32_t> moved;
  for (uint32_t i = 0; i < newest_.size() && !is_whole; ++i) {
    if (newest_[i] != control_points[i]) moved.push_back(i);
  }
  newest_.assign(control_points.begin(), control_points.end());
  for (const uint32_t chunk : DirtyByControlPoints(plan_, moved).chunks) is_old_[chunk] = true;
  std::vector<bool> is_needed(plan_.chunk_count());
  for (const uint32_t chunk : named) {
    is_needed[chunk] = true;
    for (const uint32_t owner : shared_->OwnerChunks(chunk)) {
      if (is_old_[owner]) is_needed[owner] = true;
    }
  }
  std::vector<uint32_t> chunks;
  for (uint32_t chunk = 0; chunk < is_needed.size(); ++chunk) {
    if (!is_needed[chunk]) continue;
    is_old_[chunk] = true;
    chunks.push_back(chunk);
  }
  return chunks;
}

void GemmKernel::CopySharedPoints(const Frame& frame, const std::vector<bool>& attached,
                                  std::span<const uint32_t> chunks) const {
  std::vector<bool> is_evaluated(plan_.chunk_count());
  for (const uint32_t chunk : chunks) is_evaluated[chunk] = true;
  const auto is_wanted = [&](uint32_t patch) {
    return is_evaluated[patch / limits::kPatchesPerChunk];
  };
  const auto each = [&](const auto& items, const auto& body) {
    context_->arena.ForEach(
        items.size(), [&](size_t i) { body(items[i]); }, kCopiesPerTask);
  };
  each(shared_->always(), [&](const SharedCopy& copy) {
    if (is_wanted(copy.to_patch)) CopyPoints(frame, copy);
  });
  each(shared_->when_attached(), [&](const SharedPoints::SeamCopy& of) {
    if (attached[of.seam] && is_wanted(of.copy.to_patch)) CopyPoints(frame, of.copy);
  });
  each(shared_->when_detached(), [&](const SharedPoints::SeamCopy& of) {
    if (!attached[of.seam] && is_wanted(of.copy.to_patch)) CopyPoints(frame, of.copy);
  });
  each(shared_->orphans(), [&](const SharedPoints::Orphan& orphan) {
    const bool is_free = orphan.seam == kNoIndex || !attached[orphan.seam];
    if (is_free && is_wanted(orphan.use.patch)) EvaluateOrphan(frame, orphan);
  });
}

void GemmKernel::CopyPoints(const Frame& frame, const SharedCopy& copy) const {
  const TessellationPattern& pattern = TessellationPattern::Get(spec_.segments);
  const auto from = layout_.Place(frame.vertices.data(), copy.from_patch);
  const auto to = layout_.Place(frame.vertices.data(), copy.to_patch);
  if (copy.from_slot < kFirstEdgeSlot) {
    layout_.CopyPosition(from, pattern.edge_points[copy.from_slot][0], to,
                         pattern.edge_points[copy.to_slot][0]);
    return;
  }
  const auto& source = pattern.edge_points[copy.from_slot - size_t{kFirstEdgeSlot}];
  const auto& target = pattern.edge_points[copy.to_slot - size_t{kFirstEdgeSlot}];
  const auto s = static_cast<size_t>(spec_.segments);
  for (size_t k = 1; k < s; ++k) {
    layout_.CopyPosition(from, source[copy.reversed ? s - k : k], to, target[k]);
  }
}

void GemmKernel::EvaluateOrphan(const Frame& frame, const SharedPoints::Orphan& orphan) const {
  const TessellationPattern& pattern = TessellationPattern::Get(spec_.segments);
  const auto to = layout_.Place(frame.vertices.data(), orphan.use.patch);
  // At the place t from one vertex to another.
  const auto write = [&](uint32_t box, std::array<uint32_t, 2> ends, double t, size_t point) {
    frame.writer.WritePosition(to, point, frame.direct.OnEdge(box, ends, t) - plan_.local_origin);
  };
  if (orphan.use.slot < kFirstEdgeSlot) {
    write(plan_.vertices[orphan.entity].box, {orphan.entity, orphan.entity}, 0,
          pattern.edge_points[orphan.use.slot][0]);
    return;
  }
  const PlanEdge& edge = plan_.edges[orphan.entity];
  const auto& target = pattern.edge_points[orphan.use.slot - size_t{kFirstEdgeSlot}];
  const auto s = static_cast<size_t>(spec_.segments);
  for (size_t k = 1; k < s; ++k) {
    const double t = static_cast<double>(k) / static_cast<double>(s);
    write(edge.box, edge.vertex, t, target[orphan.use.reversed ? s - k : k]);
  }
}

absl::Status GemmKernel::EvaluateChunk(const Frame& frame, size_t chunk, Tile& tile) const {
  const auto [first, last] = plan_.ChunkPatches(chunk);
  const size_t count = last - first, columns = 3 * count, m = stage_.m, rows = stages_.rows();
  const bool smooth = spec_.normals == NormalMode::kSmooth;
  tile.samples.resize(m * columns);
  if (smooth) tile.by_normal.resize(m * columns);
  tile.surface.resize(rows * columns);
  tile.centres.resize(count);
  for (size_t t = 0; t < count; ++t) {
    tile.centres[t] = frame.sampler.Sample(
        first + t, tile.samples.data() + t * m, smooth ? tile.by_normal.data() + t * m : nullptr,
        smooth ? frame.direct.RestFacetNormal(first + t) : Vec3d{}, count * m);
  }
  const MatrixView<float> surface{tile.surface.data(), rows, columns, rows};
  LATTICED_RETURN_IF_ERROR(
      stages_.Apply({tile.samples.data(), m, columns, m}, surface, tile.scratch));
  if (smooth) {
    tile.across.resize(stage_.q * columns);
    const MatrixView<float> across{tile.across.data(), stage_.q, columns, stage_.q};
    LATTICED_RETURN_IF_ERROR(
        stages_.Apply({tile.by_normal.data(), m, columns, m}, across, tile.scratch));
  }
  for (size_t t = 0; t < count; ++t) WritePatch(frame, tile, first + t, t, count);
  return absl::OkStatus();
}

void GemmKernel::WritePatch(const Frame& frame, const Tile& tile, size_t patch, size_t column,
                            size_t columns) const {
  const auto place = layout_.Place(frame.vertices.data(), patch);
  const size_t rows = stages_.rows();
  const float* x = tile.surface.data() + column * rows;
  const float* y = x + columns * rows;
  const float* z = y + columns * rows;
  for (size_t i = 0; i < stage_.q; ++i) {
    frame.writer.WritePosition(
        place, i, tile.centres[column] + Vec3d{double{x[i]}, double{y[i]}, double{z[i]}});
  }
  if (spec_.normals == NormalMode::kNone) return;
  if (plan_.is_weighted() && !HasGradient(plan_, patch)) {
    for (size_t i = 0; i < stage_.q; ++i) {
      frame.writer.WriteNormal(place, i, ToFloat(DefinitionNormal(frame, patch, i)));
    }
    return;
  }
  for (size_t i = 0; i < stage_.q; ++i) {
    frame.writer.WriteNormal(place, i, ToFloat(NormalAt(frame, tile, patch, column, columns, i)));
  }
}

std::array<double, 3> GemmKernel::Barycentrics(size_t point) const {
  const auto& t = TessellationPattern::Get(spec_.segments).points[point];
  const double over = 1.0 / spec_.segments;
  return {t[0] * over, t[1] * over, t[2] * over};
}

Vec3d GemmKernel::DefinitionNormal(const Frame& frame, size_t patch, size_t point) const {
  return frame.direct
      .Evaluate(patch, Barycentrics(point),
                spec_.normals == NormalMode::kSmooth ? DirectFfd::Normal::kSmooth
                                                     : DirectFfd::Normal::kFacet)
      .normal;
}

Vec3d GemmKernel::NormalAt(const Frame& frame, const Tile& tile, size_t patch, size_t column,
                           size_t columns, size_t point) const {
  const auto derivative = [&](const std::vector<float>& from, size_t rows, size_t row) {
    const float* x = from.data() + column * rows + row;
    return Vec3d{double{x[0]}, double{x[columns * rows]}, double{x[2 * columns * rows]}};
  };
  const size_t q = stage_.q, rows = stages_.rows();
  const Vec3d pu = derivative(tile.surface, rows, q + point);
  const Vec3d pv = derivative(tile.surface, rows, 2 * q + point);
  const double length_u = Norm(pu), length_v = Norm(pv);
  Vec3d normal = Cross(pu, pv);
  double bound = length_u * length_v;
  if (spec_.normals == NormalMode::kSmooth) {
    const Patch& p = plan_.patches[patch];
    const Vec3d corner = plan_.vertices[p.vertex[0]].world;
    const Vec3d n = frame.direct.RestSmoothNormal(patch, Barycentrics(point));
    const double by_f = Dot(n, frame.direct.RestFacetNormal(patch));
    const double by_1 = Dot(n, plan_.vertices[p.vertex[1]].world - corner);
    const double by_2 = Dot(n, plan_.vertices[p.vertex[2]].world - corner);
    const Vec3d pf = derivative(tile.across, q, point);
    normal = by_f * normal + by_1 * Cross(pv, pf) + by_2 * Cross(pf, pu);
    bound =
        std::abs(by_f) * bound + Norm(pf) * (std::abs(by_1) * length_v + std::abs(by_2) * length_u);
  }
  const double length = Norm(normal);
  if (std::isfinite(length) && length > 0 && bound <= kMostCondition * length)
    return normal / length;
  return DefinitionNormal(frame, patch, point);
}

uint64_t GemmKernel::MostBytes(const DeformPlan& plan, const StageMatrices& stage, size_t threads) {
  // A tile of a chunk: samples, by_normal and control points in double, at most nine products of
  // m x m; surface, rounded and across in float. Vectors grow to twice their size at most.
  constexpr uint64_t kColumns = 3 * limits::kPatchesPerChunk, kGrowth = 2;
  const uint64_t tile =
      kGrowth * kColumns *
      (12 * stage.m * sizeof(double) + 8 * stage.q * sizeof(float) + sizeof(Vec3d));
  return threads * tile + 12 * stage.q * stage.m * sizeof(double) +
         plan.identity_points.size() * sizeof(Vec3d) + plan.chunk_count() / 8;
}

MemoryUse GemmKernel::memory() const {
  uint64_t staging = 0;
  for (const Tile& tile : tiles_) {
    staging +=
        (tile.samples.capacity() + tile.by_normal.capacity() + tile.scratch.control.capacity()) *
            sizeof(double) +
        (tile.surface.capacity() + tile.across.capacity() + tile.scratch.rounded.capacity()) *
            sizeof(float) +
        tile.centres.capacity() * sizeof(Vec3d);
  }
  staging += newest_.capacity() * sizeof(Vec3d) + is_old_.size() / 8;
  return {{"samples", staging}, {"stage_matrices", stages_.MemoryBytes()}};
}

}  // namespace latticed
