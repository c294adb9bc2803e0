// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One point of the B-spline volume and its derivatives.         Cui & Feng 2014, formula (1)
//
//   R(u,v,w) = sum_ijk P_ijk N_i(u) N_j(v) N_k(w)
//
// Layout   control points u fastest, as in lattice.h
// Errors   none: callers pass a validated lattice and a non-empty span per axis
// Threads  pure functions, host and device; a VolumeView owns nothing
#ifndef LATTICED_CORE_FFD_BOX_VOLUME_POINT_H_
#define LATTICED_CORE_FFD_BOX_VOLUME_POINT_H_

#include "core/base/host_device.h"
#include "core/base/limits.h"
#include "core/base/vec.h"
#include "core/ffd/bspline_basis.h"

namespace latticed {

// A lattice by pointers, all of one memory space.
struct VolumeView {
  int degree[3] = {};
  int size[3] = {};
  const double* knots[3] = {};
  const Vec3d* control_points = nullptr;
};

// R and its derivatives by u, v and w.
struct VolumePoint {
  Vec3d position;
  Vec3d derivatives[3];
};

// Evaluates the polynomial of the knot box with the given spans; `parameter` may lie outside the box. The derivatives
// stay zero without kDerivatives.
template <bool kDerivatives>
LATTICED_HD inline VolumePoint EvaluateVolume(const VolumeView& volume, const int* span,
                                              Vec3d parameter) {
  double value[3][limits::kMaxDegree + 1] = {}, slope[3][limits::kMaxDegree + 1] = {};
  for (int axis = 0; axis < 3; ++axis) {
    EvaluateBasis(volume.knots[axis], volume.degree[axis], span[axis], parameter[axis],
                  value[axis]);
    if constexpr (kDerivatives) {
      EvaluateBasisDerivatives(volume.knots[axis], volume.degree[axis], span[axis], parameter[axis],
                               slope[axis]);
    }
  }
  const int first[3] = {span[0] - volume.degree[0], span[1] - volume.degree[1],
                        span[2] - volume.degree[2]};
  const auto row_of = [&](int j, int k) {
    return first[0] + volume.size[0] * (first[1] + j + volume.size[1] * (first[2] + k));
  };
  // Sums relative to one control point, so that the derivatives hold no rounding of its position. This matters far from
  // the origin and for a collapsed lattice.
  const Vec3d origin = volume.control_points[row_of(0, 0)];
  VolumePoint result;
  // Constant bounds and guards, as in bspline_basis.h.
  for (int k = 0; k <= limits::kMaxDegree; ++k) {
    if (k > volume.degree[2]) break;
    for (int j = 0; j <= limits::kMaxDegree; ++j) {
      if (j > volume.degree[1]) break;
      const Vec3d* row = volume.control_points + row_of(j, k);
      Vec3d along, along_u;
      for (int i = 0; i <= limits::kMaxDegree; ++i) {
        if (i > volume.degree[0]) break;
        const Vec3d p = row[i] - origin;
        along += value[0][i] * p;
        if constexpr (kDerivatives) along_u += slope[0][i] * p;
      }
      result.position += (value[1][j] * value[2][k]) * along;
      if constexpr (kDerivatives) {
        result.derivatives[0] += (value[1][j] * value[2][k]) * along_u;
        result.derivatives[1] += (slope[1][j] * value[2][k]) * along;
        result.derivatives[2] += (value[1][j] * slope[2][k]) * along;
      }
    }
  }
  result.position += origin;
  return result;
}

// Derivatives by world axes: columns d R/d(x, y, z), from those by u, v, w and the columns
// d(u, v, w)/d(x, y, z).
LATTICED_HD inline void WorldJacobian(const Vec3d* by_parameter, const Vec3d* parameter_by_world,
                                      Vec3d* jacobian) {
  for (int c = 0; c < 3; ++c) {
    const Vec3d d = parameter_by_world[c];
    jacobian[c] = d.x * by_parameter[0] + d.y * by_parameter[1] + d.z * by_parameter[2];
  }
}

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_BOX_VOLUME_POINT_H_
