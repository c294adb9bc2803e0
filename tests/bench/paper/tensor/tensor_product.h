// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The paper's first comparator: sub-polygons as trimmed tensor-product Bézier surfaces.
//                                              Cui & Feng 2013, doi:10.1016/j.cag.2012.12.001
//
//   X(s, t) = R(corner + s along + t across), degree n x n over (s, t) in [0, 1]², n = nu + nv + nw
//   control points  C = inv(S) R inv(T)',  R the (n+1)² samples at (i/n, j/n), S = T Bernstein
//   trimmed to the polygon; tessellated over the part of a uniform grid in it (trimmed_grid.h)
//
// There is one surface per polygon that a knot box leaves of a source triangle (sub_polygons.h). It
// spans the smallest rectangle in the polygon's plane (parameter_rectangle.h), with kTensorSegments
// cells along each side. Samples may lie outside the box. There R continues as the box's
// polynomial, so X is exact on the polygon. Only n = 6 is implemented, as in the paper's tables.
//
// Only the abstract of the paper of 2013, and what later papers say of it, were available. They do
// not say how it turns the rectangle, the grid's resolution, how it cuts boundary cells, or what it
// computes again for each edit. Here everything that does not depend on control points is made once
// on the host, like our plans: rectangles, and the (s, t) of trimmed points. Normals are per point,
// as in all our pipelines; the abstract speaks of normals of triangles. Neighbours compute the
// points of their common side separately, so the algorithm is not watertight.
//
// Work is in steps for a group of surfaces. Each function runs one index of its step, so that a
// test on the host runs the same code as a block on the device:
//
//   control points  ControlSample | ControlRelative | ControlHalf | ControlWhole
//   tessellation    LoadControl | CollapseLine | TessellationPoint      ( | : all indices are done)
//
// A line is a value of t, either of a grid row or of a point between two rows. On each line a
// surface collapses to a curve in s, which passes through the line's points.
//
// Layout   control: surface, component, row of s, column of t. Samples are relative to the middle
//          sample, in double before rounding, as in our own pipelines
// Threads  distinct indices of a step may run at once
#ifndef LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_PRODUCT_H_
#define LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_PRODUCT_H_

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"
#include "core/base/vec.h"
#include "core/ffd/box/volume_point.h"

namespace latticed::bench {

inline constexpr int kTensorDegree = 6;
inline constexpr int kTensorOrder = kTensorDegree + 1;
inline constexpr int kTensorNet = kTensorOrder * kTensorOrder;
// Cells along each side of a rectangle: the number of segments of a patch's edge. The points of a
// triangle that no plane cuts then lie as close together as those of its patch.
inline constexpr int kTensorSegments = 10;
inline constexpr int kTensorGroup = 4;  // surfaces per block

struct TensorSurface {
  int span[3];
  uint32_t first_line, first_point;  // of all; the next surface's follow
  Vec3d corner, along, across;       // in parameters of the lattice
};

struct TensorLine {
  float t;
  uint32_t surface;
};

struct TensorPoint {
  float s;
  uint32_t line;
};

struct alignas(8) TensorVertex {
  Vec3f position;  // relative to the plan's local origin
  Vec3f normal;
};

struct TensorInverse {
  float entry[kTensorOrder][kTensorOrder];  // inv(S)
};

struct TensorJob {
  const TensorSurface* surfaces;  // count + 1: the last entry holds where lines and points end
  size_t count;
  const TensorLine* lines;
  const TensorPoint* points;
  const TensorInverse* inverse;
  VolumeView volume;
  Vec3d* centres;  // X(1/2, 1/2), one per surface
  float* control;  // 3 * kTensorNet per surface
  TensorVertex* vertices;
};

// The first surface after the group of `first`.
LATTICED_HD inline size_t GroupEnd(const TensorJob& job, size_t first) {
  return first + kTensorGroup < job.count ? first + kTensorGroup : job.count;
}
LATTICED_HD inline int GroupLines(const TensorJob& job, size_t first) {
  return static_cast<int>(job.surfaces[GroupEnd(job, first)].first_line -
                          job.surfaces[first].first_line);
}
LATTICED_HD inline int GroupPoints(const TensorJob& job, size_t first) {
  return static_cast<int>(job.surfaces[GroupEnd(job, first)].first_point -
                          job.surfaces[first].first_point);
}

// The Bernstein polynomials at x, and a sixth of their derivatives: only the direction of tangents
// is used.
struct TensorBasis {
  float value[kTensorOrder], slope[kTensorOrder];
};
LATTICED_HD inline TensorBasis TensorBasisAt(float x) {
  const float y = 1 - x;
  float lower[kTensorOrder] = {1};  // the polynomials of degree d
  for (int d = 1; d < kTensorDegree; ++d) {
    for (int k = d; k > 0; --k) lower[k] = y * lower[k] + x * lower[k - 1];
    lower[0] *= y;
  }
  TensorBasis basis;
  basis.value[0] = y * lower[0];
  basis.slope[0] = -lower[0];
  for (int k = 1; k < kTensorOrder; ++k) {
    basis.value[k] = y * lower[k] + x * lower[k - 1];
    basis.slope[k] = lower[k - 1] - lower[k];
  }
  return basis;
}

struct TensorControlGroup {
  Vec3d position[kTensorGroup][kTensorNet];
  float sample[kTensorGroup][3][kTensorNet];
  float half[kTensorGroup][3][kTensorNet];
};
inline constexpr int kTensorControlSteps = kTensorGroup * kTensorNet;

// X on a line, and a sixth of dX/dt, as curves in s. The struct has an odd number of 4-byte words,
// so that curves begin in different banks of shared memory.
struct TensorCurve {
  float value[3][kTensorOrder], slope[3][kTensorOrder];
  uint32_t surface;
};

struct TensorTessellationGroup {
  float (*control)[3][kTensorNet];  // kTensorGroup
  TensorCurve* curves;              // GroupLines
};
inline constexpr int kTensorLoadSteps = kTensorGroup * 3 * kTensorNet;

LATTICED_HD inline void ControlSample(const TensorJob& job, size_t first, int step,
                                      TensorControlGroup& group) {
  const int in_group = step / kTensorNet, k = step % kTensorNet;
  const size_t surface = first + static_cast<size_t>(in_group);
  if (surface >= job.count) return;
  const TensorSurface& x = job.surfaces[surface];
  const int i = k / kTensorOrder, j = k % kTensorOrder;
  constexpr double kOver = 1.0 / kTensorDegree;
  const Vec3d at = x.corner + (i * kOver) * x.along + (j * kOver) * x.across;
  group.position[in_group][k] = EvaluateVolume<false>(job.volume, x.span, at).position;
}

LATTICED_HD inline void ControlRelative(const TensorJob& job, size_t first, int step,
                                        TensorControlGroup& group) {
  const int in_group = step / kTensorNet, k = step % kTensorNet;
  const size_t surface = first + static_cast<size_t>(in_group);
  if (surface >= job.count) return;
  static_assert(kTensorNet % 2 == 1, "one sample is in the middle");
  const Vec3d centre = group.position[in_group][kTensorNet / 2];
  const Vec3f sample = ToFloat(group.position[in_group][k] - centre);
  group.sample[in_group][0][k] = sample.x;
  group.sample[in_group][1][k] = sample.y;
  group.sample[in_group][2][k] = sample.z;
  if (k == 0) job.centres[surface] = centre;
}

LATTICED_HD inline void ControlHalf(const TensorJob& job, size_t first, int step,
                                    TensorControlGroup& group) {
  const int in_group = step / kTensorNet, k = step % kTensorNet;
  if (first + static_cast<size_t>(in_group) >= job.count) return;
  const float* inverse = job.inverse->entry[k / kTensorOrder];
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
  const size_t surface = first + static_cast<size_t>(in_group);
  if (surface >= job.count) return;
  const float* inverse = job.inverse->entry[k % kTensorOrder];
  float* control = job.control + surface * 3 * kTensorNet + k;
  for (int c = 0; c < 3; ++c) {
    const float* row = group.half[in_group][c] + k / kTensorOrder * kTensorOrder;
    float sum = 0;
    for (int j = 0; j < kTensorOrder; ++j) sum += row[j] * inverse[j];
    control[c * kTensorNet] = sum;
  }
}

LATTICED_HD inline void LoadControl(const TensorJob& job, size_t first, int step,
                                    const TensorTessellationGroup& group) {
  const int in_group = step / (3 * kTensorNet), k = step % (3 * kTensorNet);
  const size_t surface = first + static_cast<size_t>(in_group);
  if (surface >= job.count) return;
  group.control[in_group][k / kTensorNet][k % kTensorNet] =
      job.control[surface * 3 * kTensorNet + static_cast<size_t>(k)];
}

// Collapses one component of one line. There are 3 * GroupLines steps.
LATTICED_HD inline void CollapseLine(const TensorJob& job, size_t first, int step,
                                     const TensorTessellationGroup& group) {
  const int lines = GroupLines(job, first), c = step / lines, l = step % lines;
  const TensorLine line = job.lines[job.surfaces[first].first_line + static_cast<uint32_t>(l)];
  const TensorBasis basis = TensorBasisAt(line.t);
  const float* control = group.control[line.surface - first][c];
  TensorCurve& curve = group.curves[l];
  for (int a = 0; a < kTensorOrder; ++a) {
    float value = 0, slope = 0;
    for (int b = 0; b < kTensorOrder; ++b) {
      value += control[a * kTensorOrder + b] * basis.value[b];
      slope += control[a * kTensorOrder + b] * basis.slope[b];
    }
    curve.value[c][a] = value;
    curve.slope[c][a] = slope;
  }
  if (c == 0) curve.surface = line.surface;
}

// There are GroupPoints steps.
LATTICED_HD inline void TessellationPoint(const TensorJob& job, size_t first, int step,
                                          const TensorTessellationGroup& group) {
  const size_t index = job.surfaces[first].first_point + static_cast<size_t>(step);
  const TensorPoint point = job.points[index];
  const TensorCurve& curve = group.curves[point.line - job.surfaces[first].first_line];
  const TensorBasis basis = TensorBasisAt(point.s);
  float x[3] = {}, by_s[3] = {}, by_t[3] = {};
  for (int a = 0; a < kTensorOrder; ++a) {
    for (int c = 0; c < 3; ++c) {
      x[c] += basis.value[a] * curve.value[c][a];
      by_s[c] += basis.slope[a] * curve.value[c][a];
      by_t[c] += basis.value[a] * curve.slope[c][a];
    }
  }
  const float nx = by_s[1] * by_t[2] - by_s[2] * by_t[1];
  const float ny = by_s[2] * by_t[0] - by_s[0] * by_t[2];
  const float nz = by_s[0] * by_t[1] - by_s[1] * by_t[0];
  const float length = std::sqrt(nx * nx + ny * ny + nz * nz);
  const float over = length > 0 ? 1 / length : 0;
  const Vec3d position =
      job.centres[curve.surface] + Vec3d{double{x[0]}, double{x[1]}, double{x[2]}};
  job.vertices[index] = {ToFloat(position), {nx * over, ny * over, nz * over}};
}

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_PRODUCT_H_
