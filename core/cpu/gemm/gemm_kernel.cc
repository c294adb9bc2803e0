// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/gemm/gemm_kernel.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/status_macros.h"
#include "core/ffd/tessellation_pattern.h"
#include "core/ffd/weights/weight_change.h"
#include "core/view/view_layout.h"

namespace latticed {
namespace {

constexpr size_t kCopiesPerTask = 2'048;  // about 100 us

// Copies every shared position from its owner, by the tables of core/ffd/plan/shared_points.h.
void CopySharedPoints(const SharedPoints& shared, const DeformPlan& plan,
                      std::span<const Vec3d> control_points, const DirectFfd& direct,
                      const VertexLayout& layout, const VertexWriter& writer, int segments,
                      std::span<uint8_t> vertices, CpuArena& arena) {
  const std::vector<bool> attached = AttachedSeams(plan, control_points);
  const TessellationPattern& pattern = TessellationPattern::Get(segments);
  const auto s = static_cast<size_t>(segments);
  const auto copy_one = [&](const SharedCopy& copy) {
    const auto from = layout.Place(vertices.data(), copy.from_patch);
    const auto to = layout.Place(vertices.data(), copy.to_patch);
    if (copy.from_slot < kFirstEdgeSlot) {
      layout.CopyPosition(from, pattern.edge_points[copy.from_slot][0], to,
                          pattern.edge_points[copy.to_slot][0]);
      return;
    }
    const auto& source = pattern.edge_points[copy.from_slot - size_t{kFirstEdgeSlot}];
    const auto& target = pattern.edge_points[copy.to_slot - size_t{kFirstEdgeSlot}];
    for (size_t k = 1; k < s; ++k) {
      layout.CopyPosition(from, source[copy.reversed ? s - k : k], to, target[k]);
    }
  };
  const auto evaluate_one = [&](const SharedPoints::Orphan& orphan) {
    const auto to = layout.Place(vertices.data(), orphan.use.patch);
    // At the place t from one vertex to another.
    const auto write = [&](uint32_t box, std::array<uint32_t, 2> ends, double t, size_t point) {
      writer.WritePosition(to, point, direct.OnEdge(box, ends, t) - plan.local_origin);
    };
    if (orphan.use.slot < kFirstEdgeSlot) {
      write(plan.vertices[orphan.entity].box, {orphan.entity, orphan.entity}, 0,
            pattern.edge_points[orphan.use.slot][0]);
      return;
    }
    const PlanEdge& edge = plan.edges[orphan.entity];
    const auto& target = pattern.edge_points[orphan.use.slot - size_t{kFirstEdgeSlot}];
    for (size_t k = 1; k < s; ++k) {
      const double t = static_cast<double>(k) / static_cast<double>(s);
      write(edge.box, edge.vertex, t, target[orphan.use.reversed ? s - k : k]);
    }
  };
  const auto copy_all = [&](size_t count, const auto& body) {
    arena.ForEach(count, body, kCopiesPerTask);
  };
  copy_all(shared.always().size(), [&](size_t i) { copy_one(shared.always()[i]); });
  copy_all(shared.when_attached().size(), [&](size_t i) {
    if (attached[shared.when_attached()[i].seam]) copy_one(shared.when_attached()[i].copy);
  });
  copy_all(shared.when_detached().size(), [&](size_t i) {
    if (!attached[shared.when_detached()[i].seam]) copy_one(shared.when_detached()[i].copy);
  });
  copy_all(shared.orphans().size(), [&](size_t i) {
    if (shared.orphans()[i].seam == kNoIndex || !attached[shared.orphans()[i].seam])
      evaluate_one(shared.orphans()[i]);
  });
}

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
      stage_(stage),
      spec_(spec),
      layout_(MakeVertexLayout(plan_, spec)),
      stages_(pipeline, stage, spec.normals != NormalMode::kNone),
      context_(std::move(context)) {}

absl::Status GemmKernel::Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                                  std::span<const uint32_t> /*named: always all*/,
                                  std::span<uint8_t> vertices) {
  LATTICED_RETURN_IF_ERROR(stages_.Begin());
  const Frame frame{{plan_, stage_, control_points},
                    {plan_, control_points},
                    MakeVertexWriter(plan_, spec_, box),
                    vertices};
  LATTICED_RETURN_IF_ERROR(context_->arena.TryEach(plan_.chunk_count(), [&](size_t chunk) {
    return EvaluateChunk(frame, chunk, tiles_.local());
  }));
  CopySharedPoints(*shared_, plan_, control_points, frame.direct, layout_, frame.writer,
                   spec_.segments, vertices, context_->arena);
  return absl::OkStatus();
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

uint64_t GemmKernel::MostBytes(const StageMatrices& stage, size_t threads) {
  // A tile of a chunk: samples, by_normal and control points in double, at most nine products of
  // m x m; surface, rounded and across in float. Vectors grow to twice their size at most.
  constexpr uint64_t kColumns = 3 * limits::kPatchesPerChunk, kGrowth = 2;
  const uint64_t tile =
      kGrowth * kColumns *
      (12 * stage.m * sizeof(double) + 8 * stage.q * sizeof(float) + sizeof(Vec3d));
  return threads * tile + 12 * stage.q * stage.m * sizeof(double);
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
  return {{"samples", staging}, {"stage_matrices", stages_.MemoryBytes()}};
}

}  // namespace latticed
