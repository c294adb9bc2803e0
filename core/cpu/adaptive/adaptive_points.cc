// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The points of AdaptiveEvaluator.
#include <algorithm>
#include <cstring>

#include "core/cpu/adaptive/adaptive_evaluator.h"
#include "core/cpu/flush_denormals.h"
#include "core/ffd/direct_ffd.h"

namespace latticed {

using fused::Fix;
using fused::FusedLayout;
using fused::Group;
using fused::RunArguments;
using fused::RunBuffer;
using fused::RunPatches;

namespace {

RunArguments::Normals NormalsOf(NormalMode mode) {
  switch (mode) {
    case NormalMode::kNone:
      return RunArguments::Normals::kNone;
    case NormalMode::kFacet:
      return RunArguments::Normals::kFacet;
    case NormalMode::kSmooth:
      break;
  }
  return RunArguments::Normals::kSmooth;
}

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

const AdaptivePattern& PatternOf(uint16_t code) {
  return AdaptivePattern::Get(*PatternKey::FromCode(code));
}

}  // namespace

void AdaptiveEvaluator::EvaluatePoints(std::span<const uint32_t> chunks, Frame& frame) {
  for (const uint32_t chunk : chunks) NeedFeatures(chunk, frame);
  frame.boxes.MakeNeeded(arena_);
  frame.features.MakeNeeded(arena_);
  arena_.ForRanges(chunks.size(), 1, [&](size_t begin, size_t end) {
    const FlushDenormals flush;
    static thread_local RunBuffer buffer;
    for (size_t i = begin; i < end; ++i) EvaluateChunk(chunks[i], frame, buffer);
  });
}

void AdaptiveEvaluator::NeedFeatures(uint32_t chunk, Frame& frame) const {
  const auto [first, last] = plan_->plan->ChunkPatches(chunk);
  for (size_t p = first; p < last; ++p) frame.boxes.Need(plan_->plan->patches[p].box);
  ForFixes(plan_->layout, first, last, [&](size_t patch, const Fix& fix) {
    frame.features.Need(fix, PatternKey::FromCode(levels_.codes()[patch])->levels[fix.slot]);
  });
}

void AdaptiveEvaluator::EvaluateChunk(uint32_t chunk, Frame& frame, RunBuffer& buffer) const {
  const auto [first, last] = plan_->plan->ChunkPatches(chunk);
  size_t points = 0;
  for (const uint16_t code : Patterns(chunk)) points += PatternOf(code).points.size();
  Run run{.first = first,
          .last = first,
          .first_point = 0,
          .chunk_points = points,
          .vertices = frame.vertices.Resize(chunk, points)};
  const auto& patches = plan_->plan->patches;
  while (run.last < last) {
    run.first = run.last;
    while (run.last < last && patches[run.last].box == patches[run.first].box) ++run.last;
    EvaluateRun(run, frame, buffer);
    run.first_point += buffer.size();
  }
}

void AdaptiveEvaluator::EvaluateRun(const Run& run, const Frame& frame, RunBuffer& buffer) const {
  std::array<size_t, fused::kRunPatches> first_points;
  buffer.Clear();
  FillPatches(run, buffer.patches);
  for (size_t p = run.first; p < run.last; ++p) {
    first_points[p - run.first] = buffer.Add(p - run.first, PatternPlaces::Get(levels_.codes()[p]));
  }
  buffer.Evaluate(plan_->polynomials.degree(), frame.boxes[plan_->plan->patches[run.first].box],
                  NormalsOf(spec_.normals));
  TakeFeatures(run, frame, first_points, buffer);
  ReplaceWeakNormals(run, frame, first_points, buffer);
  Write(run, frame, buffer);
}

void AdaptiveEvaluator::FillPatches(const Run& run, RunPatches& patches) const {
  const FusedLayout& layout = plan_->layout;
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
    p += lanes;
  }
}

void AdaptiveEvaluator::TakeFeatures(const Run& run, const Frame& frame,
                                     std::span<const size_t> first_points,
                                     RunBuffer& buffer) const {
  ForFixes(plan_->layout, run.first, run.last, [&](size_t patch, const Fix& fix) {
    const std::span<const Vec3f> points = frame.features.At(fix);
    if (points.empty()) return;
    const auto& edge = PatternOf(levels_.codes()[patch]).edge_points[fix.slot];
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

void AdaptiveEvaluator::ReplaceWeakNormals(const Run& run, const Frame& frame,
                                           std::span<const size_t> first_points,
                                           RunBuffer& buffer) const {
  if (buffer.weak().empty()) return;
  const DirectFfd definition(*plan_->plan, frame.control_points);
  const auto kind =
      spec_.normals == NormalMode::kSmooth ? DirectFfd::Normal::kSmooth : DirectFfd::Normal::kFacet;
  for (const fused::WeakNormal& weak : buffer.weak()) {
    const size_t point = RunBuffer::PointOf(weak);
    if (point >= buffer.size()) continue;
    const size_t of_run = buffer.PatchOf(point), patch = run.first + of_run;
    const AdaptivePattern& pattern = PatternOf(levels_.codes()[patch]);
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

void AdaptiveEvaluator::Write(const Run& run, const Frame& frame, RunBuffer& buffer) const {
  const bool has_normals = spec_.normals != NormalMode::kNone;
  const size_t count = buffer.size();
  if (spec_.format == VertexFormat::kFloat32) {
    const size_t components = has_normals ? 6 : 3;
    uint8_t* to = run.vertices.data() + run.first_point * components * sizeof(float);
    for (size_t i = 0; i < count; ++i) {
      for (size_t c = 0; c < components; ++c, to += sizeof(float)) {
        std::memcpy(to, buffer.Row(c) + i, sizeof(float));
      }
    }
    return;
  }
  const double step = frame.box.step(spec_.position_bits);
  const Vec3d offset = (plan_->plan->local_origin - frame.box.origin) / step;
  uint8_t* plane = run.vertices.data();
  for (int axis = 0; axis < 3; ++axis, plane += 2 * run.chunk_points) {
    fused::QuantisePositions({buffer.Row(static_cast<size_t>(axis)), count},
                             static_cast<float>(1 / step), static_cast<float>(offset[axis]),
                             spec_.position_bits, plane + 2 * run.first_point);
  }
  if (!has_normals) return;
  const size_t bytes = spec_.normal_bits <= 8 ? 1 : 2;
  uint8_t* s = plane + bytes * run.first_point;
  fused::QuantiseNormals({buffer.Row(3), buffer.Row(4), buffer.Row(5)}, count, spec_.normal_bits, s,
                         s + bytes * run.chunk_points);
}

}  // namespace latticed
