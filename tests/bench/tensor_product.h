// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The paper's first comparator: each piece of the mesh as a trimmed tensor-product Bézier surface.
//                                              Cui & Feng 2013, doi:10.1016/j.cag.2012.12.001
//
//   X(s, t) = R(corner + s along + t across),  degree n x n over (s, t) in [0, 1]²
//   control points  C = inv(S) R inv(T)',  R the samples at (i/n, j/n), S = T Bernstein, uniform
//   trimmed to s + t <= 1: the uniform grid of the same points as everybody's pattern
//
// along and across are the patch's edges from corner 0, so that its parameter parallelogram is the
// square; R goes on as its box's polynomial beyond the triangle. n = 6 alone, as in the tables. The
// paper has a surface a sub-polygon, over a rectangle; here it is one a triangle of our patches, so
// that all algorithms make the same points: the same work a surface, and more surfaces.
//
// Work is in steps of a group of patches, one call an index of the step, so that a test on the host
// runs what a block runs:
//
//   control points  ControlSample | ControlRelative | ControlHalf | ControlWhole
//   tessellation    LoadControl | CollapseRow | TessellationPoint      ( | : all calls are done)
//
// Layout   control: patch, component, row of s, column of t. Samples are relative to corner 0, in
//          double before they are rounded, as our own pipelines' are
// Threads  distinct indices of a step may run at once
#ifndef LATTICED_TESTS_BENCH_TENSOR_PRODUCT_H_
#define LATTICED_TESTS_BENCH_TENSOR_PRODUCT_H_

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"
#include "core/base/vec.h"
#include "core/ffd/tessellation_pattern.h"
#include "core/ffd/volume_point.h"
#include "core/view/vertex_layout.h"

namespace latticed::bench {

inline constexpr int kTensorDegree = 6;
inline constexpr int kTensorOrder = kTensorDegree + 1;
inline constexpr int kTensorNet = kTensorOrder * kTensorOrder;
inline constexpr int kTensorGroup = 4;  // patches a block
inline constexpr int kTensorRows = limits::kMaxSegments + 1;

struct TensorPatch {
  int span[3];
  int outside;  // 1: under the identity map, corner and edges in the world
  Vec3d corner, along, across;
};

struct TensorTables {
  float inverse[kTensorOrder][kTensorOrder];  // inv(S)
  // Bernstein polynomials and their derivatives at k / segments.
  float value[kTensorRows][kTensorOrder], slope[kTensorRows][kTensorOrder];
  // s and t of a point of the pattern, times segments.
  uint8_t column[PointsPerPatch(limits::kMaxSegments)], row[PointsPerPatch(limits::kMaxSegments)];
};

struct TensorJob {
  const TensorPatch* patches;
  size_t count;
  VolumeView volume;
  const TensorTables* tables;
  int segments;
  Vec3d* centres;  // X(0, 0), a patch
  float* control;  // 3 * kTensorNet a patch
  VertexLayout layout;
  VertexWriter writer;
  uint8_t* vertices;
};

struct TensorControlGroup {
  Vec3d position[kTensorGroup][kTensorNet];
  float sample[kTensorGroup][3][kTensorNet];
  float half[kTensorGroup][3][kTensorNet];
};
inline constexpr int kTensorControlSteps = kTensorGroup * kTensorNet;

struct TensorRow {
  float value[3][kTensorOrder], slope[3][kTensorOrder];  // over s: X and dX/dt at this t
};
struct TensorTessellationGroup {
  float control[kTensorGroup][3][kTensorNet];
  TensorRow rows[kTensorGroup * kTensorRows];  // the first kTensorGroup * (segments + 1) of them
};
inline constexpr int kTensorLoadSteps = kTensorGroup * 3 * kTensorNet;
LATTICED_HD constexpr int TensorRowSteps(int segments) {
  return kTensorGroup * (segments + 1) * 3 * kTensorOrder;
}

LATTICED_HD inline void ControlSample(const TensorJob& job, size_t first, int step,
                                      TensorControlGroup& group) {
  const int in_group = step / kTensorNet, k = step % kTensorNet;
  const size_t patch = first + static_cast<size_t>(in_group);
  if (patch >= job.count) return;
  const TensorPatch& p = job.patches[patch];
  const int i = k / kTensorOrder, j = k % kTensorOrder;
  constexpr double kOver = 1.0 / kTensorDegree;
  const Vec3d at = p.corner + (i * kOver) * p.along + (j * kOver) * p.across;
  group.position[in_group][k] =
      p.outside != 0 ? at : EvaluateVolume<false>(job.volume, p.span, at).position;
}

LATTICED_HD inline void ControlRelative(const TensorJob& job, size_t first, int step,
                                        TensorControlGroup& group) {
  const int in_group = step / kTensorNet, k = step % kTensorNet;
  const size_t patch = first + static_cast<size_t>(in_group);
  if (patch >= job.count) return;
  const Vec3d centre = group.position[in_group][0];
  const Vec3f sample = ToFloat(group.position[in_group][k] - centre);
  group.sample[in_group][0][k] = sample.x;
  group.sample[in_group][1][k] = sample.y;
  group.sample[in_group][2][k] = sample.z;
  if (k == 0) job.centres[patch] = centre;
}

LATTICED_HD inline void ControlHalf(const TensorJob& job, size_t first, int step,
                                    TensorControlGroup& group) {
  const int in_group = step / kTensorNet, k = step % kTensorNet;
  if (first + static_cast<size_t>(in_group) >= job.count) return;
  const float* inverse = job.tables->inverse[k / kTensorOrder];
  for (int c = 0; c < 3; ++c) {
    float sum = 0;
    for (int i = 0; i < kTensorOrder; ++i) {
      sum += inverse[i] * group.sample[in_group][c][i * kTensorOrder + k % kTensorOrder];
    }
    group.half[in_group][c][k] = sum;
  }
}

LATTICED_HD inline void ControlWhole(const TensorJob& job, size_t first, int step,
                                     const TensorControlGroup& group) {
  const int in_group = step / kTensorNet, k = step % kTensorNet;
  const size_t patch = first + static_cast<size_t>(in_group);
  if (patch >= job.count) return;
  const float* inverse = job.tables->inverse[k % kTensorOrder];
  float* control = job.control + patch * 3 * kTensorNet + k;
  for (int c = 0; c < 3; ++c) {
    const float* row = group.half[in_group][c] + k / kTensorOrder * kTensorOrder;
    float sum = 0;
    for (int j = 0; j < kTensorOrder; ++j) sum += row[j] * inverse[j];
    control[c * kTensorNet] = sum;
  }
}

LATTICED_HD inline void LoadControl(const TensorJob& job, size_t first, int step,
                                    TensorTessellationGroup& group) {
  const int in_group = step / (3 * kTensorNet), k = step % (3 * kTensorNet);
  const size_t patch = first + static_cast<size_t>(in_group);
  if (patch >= job.count) return;
  group.control[in_group][k / kTensorNet][k % kTensorNet] =
      job.control[patch * 3 * kTensorNet + static_cast<size_t>(k)];
}

// One component and one power of s of one row of t.
LATTICED_HD inline void CollapseRow(const TensorJob& job, int step,
                                    TensorTessellationGroup& group) {
  const int a = step % kTensorOrder, c = step / kTensorOrder % 3;
  const int row = step / (3 * kTensorOrder);  // of all rows of the group
  const int in_group = row / (job.segments + 1), t = row % (job.segments + 1);
  const float* control = group.control[in_group][c] + a * kTensorOrder;
  float value = 0, slope = 0;
  for (int b = 0; b < kTensorOrder; ++b) {
    value += control[b] * job.tables->value[t][b];
    slope += control[b] * job.tables->slope[t][b];
  }
  group.rows[row].value[c][a] = value;
  group.rows[row].slope[c][a] = slope;
}

LATTICED_HD inline void TessellationPoint(const TensorJob& job, size_t first, int step,
                                          const TensorTessellationGroup& group) {
  const int q = PointsPerPatch(job.segments), in_group = step / q, point = step % q;
  const size_t patch = first + static_cast<size_t>(in_group);
  if (patch >= job.count) return;
  const int s = job.tables->column[point];
  const TensorRow& row = group.rows[in_group * (job.segments + 1) + job.tables->row[point]];
  float x[3] = {}, by_s[3] = {}, by_t[3] = {};
  for (int a = 0; a < kTensorOrder; ++a) {
    const float value = job.tables->value[s][a], slope = job.tables->slope[s][a];
    for (int c = 0; c < 3; ++c) {
      x[c] += value * row.value[c][a];
      by_s[c] += slope * row.value[c][a];
      by_t[c] += value * row.slope[c][a];
    }
  }
  const float nx = by_s[1] * by_t[2] - by_s[2] * by_t[1];
  const float ny = by_s[2] * by_t[0] - by_s[0] * by_t[2];
  const float nz = by_s[0] * by_t[1] - by_s[1] * by_t[0];
  const float length = std::sqrt(nx * nx + ny * ny + nz * nz);
  const float over = length > 0 ? 1 / length : 0;
  const auto at = static_cast<size_t>(point);
  const PatchPlace place = job.layout.Place(job.vertices, patch);
  job.writer.WritePosition(place, at,
                           job.centres[patch] + Vec3d{double{x[0]}, double{x[1]}, double{x[2]}});
  job.writer.WriteNormal(place, at, {nx * over, ny * over, nz * over});
}

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_TENSOR_PRODUCT_H_
