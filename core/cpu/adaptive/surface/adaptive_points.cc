// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/adaptive/surface/adaptive_points.h"

#include <algorithm>
#include <cstring>

#include "core/adaptive/adaptive_pattern.h"
#include "core/cpu/adaptive/kernel/pattern_places.h"
#include "core/cpu/flush_denormals.h"
#include "core/ffd/direct_ffd.h"

namespace latticed {

using fused::Fix;
using fused::FusedLayout;
using fused::Group;
using fused::PatchWeights;
using fused::RunBuffer;
using fused::RunPatches;
using fused::RunWeights;

namespace {

// Calls f(group, fix) for the fixes of patches [first, last).
template <class F>
void ForFixes(const FusedLayout& layout, size_t first, size_t last, const F& f) {
  for (uint32_t g = layout.group_of_patch[first]; g <= layout.group_of_patch[last - 1]; ++g) {
    const Group& group = layout.groups[g];
    for (uint32_t i = group.first_fix; i < group.last_fix; ++i) {
      const Fix& fix = layout.fixes[i];
      const size_t patch = group.first_patch + fix.lane;
      if (patch >= first && patch < last) f(patch, fix);
    }
  }
}

// copy(from, row) copies the lanes that a run wants.
template <class Copy>
void CopyWeights(const PatchWeights& from, const Copy& copy, RunWeights& to) {
  for (size_t c = 0; c < 3; ++c) {
    copy(from.corners[c], to.weight[c]);
    copy(from.by_local.point[c], to.by_local[c]);
  }
  copy(from.steepness, to.steepness);
}

const AdaptivePattern& PatternOf(uint16_t code) {
  return AdaptivePattern::Get(*PatternKey::FromCode(code));
}

}  // namespace

void AdaptivePoints::Evaluate(std::span<const uint32_t> chunks, CpuArena& arena,
                              ChunkVertices& vertices) {
  for (const uint32_t chunk : chunks) NeedFeatures(chunk);
  boxes_.MakeNeeded(arena);
  features_.MakeNeeded(arena);
  arena.ForRanges(chunks.size(), 1, [&](size_t begin, size_t end) {
    const FlushDenormals flush;
    static thread_local RunBuffer buffer;
    for (size_t i = begin; i < end; ++i) EvaluateChunk(chunks[i], vertices, buffer);
  });
}

void AdaptivePoints::NeedFeatures(uint32_t chunk) {
  const auto [first, last] = plan_.plan->ChunkPatches(chunk);
  for (size_t p = first; p < last; ++p) boxes_.Need(plan_.plan->patches[p].box);
  ForFixes(plan_.layout, first, last, [&](size_t patch, const Fix& fix) {
    features_.Need(fix, PatternKey::FromCode(input_.codes[patch])->levels[fix.slot]);
  });
}

void AdaptivePoints::EvaluateChunk(uint32_t chunk, ChunkVertices& vertices,
                                   RunBuffer& buffer) const {
  const auto [first, last] = plan_.plan->ChunkPatches(chunk);
  const size_t points = PatternPoints(input_.codes.subspan(first, last - first));
  Run run{.first = first,
          .last = first,
          .first_point = 0,
          .chunk_points = points,
          .vertices = vertices.Resize(chunk, points)};
  const auto& patches = plan_.plan->patches;
  while (run.last < last) {
    run.first = run.last;
    while (run.last < last && patches[run.last].box == patches[run.first].box) ++run.last;
    EvaluateRun(run, buffer);
    run.first_point += buffer.size();
  }
}

void AdaptivePoints::EvaluateRun(const Run& run, RunBuffer& buffer) const {
  std::array<size_t, fused::kRunPatches> first_points;
  buffer.Clear();
  FillPatches(run, buffer);
  for (size_t p = run.first; p < run.last; ++p) {
    first_points[p - run.first] = buffer.Add(p - run.first, PatternPlaces::Get(input_.codes[p]));
  }
  buffer.Evaluate(plan_.polynomials.degree(), boxes_[plan_.plan->patches[run.first].box],
                  spec_.normals, plan_.plan->is_weighted());
  TakeFeatures(run, first_points, buffer);
  ReplaceWeakNormals(run, first_points, buffer);
  Write(run, buffer);
}

void AdaptivePoints::FillPatches(const Run& run, RunBuffer& buffer) const {
  const FusedLayout& layout = plan_.layout;
  RunPatches& patches = buffer.patches;
  for (size_t p = run.first; p < run.last;) {
    const uint32_t g = layout.group_of_patch[p];
    const size_t lane = p - layout.groups[g].first_patch, to = p - run.first;
    const size_t lanes = std::min<size_t>(layout.groups[g].lanes - lane, run.last - p);
    const auto copy = [&](const fused::Lanes& from, RunPatches::Row& row) {
      std::copy_n(from.begin() + static_cast<ptrdiff_t>(lane), lanes,
                  row.begin() + static_cast<ptrdiff_t>(to));
    };
    for (size_t axis = 0; axis < 3; ++axis) {
      for (size_t c = 0; c < 3; ++c) {
        copy(layout.patches[g].corners[c].point[axis], patches.corners[axis][c]);
        if (spec_.normals == NormalMode::kSmooth) {
          copy(layout.smooth[g].conormal[axis][c], patches.conormals[axis][c]);
        }
      }
      if (spec_.normals == NormalMode::kFacet) {
        copy(layout.patches[g].conormal[axis], patches.conormals[axis][0]);
      }
    }
    if (plan_.plan->is_weighted()) {
      CopyWeights(layout.weights.patches[g].weights, copy, buffer.weights);
    }
    p += lanes;
  }
}

void AdaptivePoints::TakeFeatures(const Run& run, std::span<const size_t> first_points,
                                  RunBuffer& buffer) const {
  ForFixes(plan_.layout, run.first, run.last, [&](size_t patch, const Fix& fix) {
    const std::span<const Vec3f> points = features_.At(fix);
    if (points.empty()) return;
    const auto& edge = PatternOf(input_.codes[patch]).edge_points[fix.slot];
    const size_t first_point = first_points[patch - run.first];
    const auto take = [&](size_t point, Vec3f position) {
      buffer.Row(0)[first_point + point] = position.x;
      buffer.Row(1)[first_point + point] = position.y;
      buffer.Row(2)[first_point + point] = position.z;
    };
    if (!fix.is_edge) return take(edge[0], points[0]);
    const size_t segments = edge.size() - 1;
    for (size_t k = 1; k < segments; ++k) {
      take(edge[fix.reversed ? segments - k : k], points[k - 1]);
    }
  });
}

void AdaptivePoints::ReplaceWeakNormals(const Run& run, std::span<const size_t> first_points,
                                        RunBuffer& buffer) const {
  if (buffer.weak().empty()) return;
  const DirectFfd definition(*plan_.plan, input_.control_points);
  const auto kind =
      spec_.normals == NormalMode::kSmooth ? DirectFfd::Normal::kSmooth : DirectFfd::Normal::kFacet;
  for (const fused::WeakNormal& weak : buffer.weak()) {
    const size_t point = RunBuffer::PointOf(weak);
    if (point >= buffer.size()) continue;
    const size_t of_run = buffer.PatchOf(point), patch = run.first + of_run;
    const AdaptivePattern& pattern = PatternOf(input_.codes[patch]);
    const auto& steps = pattern.points[point - first_points[of_run]];
    std::array<double, 3> barycentrics;
    for (size_t c = 0; c < 3; ++c) {
      barycentrics[c] = static_cast<double>(steps[c]) / pattern.denominator;
    }
    const Vec3f normal = ToFloat(definition.Evaluate(patch, barycentrics, kind).normal);
    buffer.Row(3)[point] = normal.x;
    buffer.Row(4)[point] = normal.y;
    buffer.Row(5)[point] = normal.z;
  }
}

void AdaptivePoints::Write(const Run& run, RunBuffer& buffer) const {
  if (spec_.format == VertexFormat::kQuantised) return WriteQuantised(run, buffer);
  const size_t components = spec_.normals == NormalMode::kNone ? 3 : 6;
  uint8_t* to = run.vertices.data() + run.first_point * components * sizeof(float);
  for (size_t i = 0; i < buffer.size(); ++i) {
    for (size_t c = 0; c < components; ++c, to += sizeof(float)) {
      std::memcpy(to, buffer.Row(c) + i, sizeof(float));
    }
  }
}

void AdaptivePoints::WriteQuantised(const Run& run, RunBuffer& buffer) const {
  const size_t count = buffer.size();
  const double step = input_.box.step(spec_.position_bits);
  const Vec3d offset = (plan_.plan->local_origin - input_.box.origin) / step;
  uint8_t* plane = run.vertices.data();
  for (int axis = 0; axis < 3; ++axis, plane += 2 * run.chunk_points) {
    fused::QuantisePositions({buffer.Row(static_cast<size_t>(axis)), count},
                             static_cast<float>(1 / step), static_cast<float>(offset[axis]),
                             spec_.position_bits, plane + 2 * run.first_point);
  }
  if (spec_.normals == NormalMode::kNone) return;
  const size_t bytes = spec_.normal_bits <= 8 ? 1 : 2;
  uint8_t* s = plane + bytes * run.first_point;
  fused::QuantiseNormals({buffer.Row(3), buffer.Row(4), buffer.Row(5)}, count, spec_.normal_bits, s,
                         s + bytes * run.chunk_points);
}

}  // namespace latticed
