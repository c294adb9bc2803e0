// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One point of a knot box on the device: its local coordinates, the box's polynomial there, and its Jacobian. Twin of the
// loops in core/points/point_kernel.cc.
//
// Units    world units
// Threads  device functions; polynomials are in shared memory, where all threads of a warp read the same number
#ifndef LATTICED_CUDA_POINTS_BOX_POINT_CUH_
#define LATTICED_CUDA_POINTS_BOX_POINT_CUH_

#include <array>

#include "core/base/vec.h"
#include "core/ffd/box/box_polynomial.h"
#include "core/points/local_map.h"
#include "cuda/points/point_kernels.h"
#include "cuda/points/point_normal.cuh"

namespace latticed::kernels {

__device__ inline Vec3d WorldAt(const double* const* axes, size_t place) {
  return {axes[0][place], axes[1][place], axes[2][place]};
}

// A point is in its box, but for rounding and for the snapping of core/ffd/plan/knot_split.h.
__device__ inline Vec3d ToLocal(const LocalMap& map, Vec3d world) {
  const Vec3d x = world - map.frame_origin;
  const Vec3d half{0.5, 0.5, 0.5};
  const Vec3d local{Dot(map.scale[0], x), Dot(map.scale[1], x), Dot(map.scale[2], x)};
  return Max(-half, Min(half, local + map.offset));
}

struct PointJet {
  Vec3d value;
  std::array<Vec3d, 3> slopes;  // by l, m, n; only with kSlopes
};

// By Horner's rule.
template <bool kSlopes>
__device__ inline PointJet EvaluateBox(const BoxPolynomial& polynomial, const int (&degree)[3],
                                       Vec3d local) {
  PointJet jet{};
  for (int p = degree[0]; p >= 0; --p) {
    Vec3d row, row_m, row_n;
    for (int q = degree[1]; q >= 0; --q) {
      Vec3d cell, cell_n;
      for (int r = degree[2]; r >= 0; --r) {
        const double* const c = polynomial.coefficients.at[p][q][r];
        if constexpr (kSlopes) cell_n = local.z * cell_n + cell;
        cell = local.z * cell + Vec3d{c[0], c[1], c[2]};
      }
      if constexpr (kSlopes) {
        row_m = local.y * row_m + row;
        row_n = local.y * row_n + cell_n;
      }
      row = local.y * row + cell;
    }
    if constexpr (kSlopes) {
      jet.slopes[0] = local.x * jet.slopes[0] + jet.value;
      jet.slopes[1] = local.x * jet.slopes[1] + row_m;
      jet.slopes[2] = local.x * jet.slopes[2] + row_n;
    }
    jet.value = local.x * jet.value + row;
  }
  jet.value += polynomial.origin;
  return jet;
}

// d/d(x, y, z) from d/d(l, m, n).
__device__ inline std::array<Vec3d, 3> ToWorldColumns(const LocalMap& map,
                                                      const std::array<Vec3d, 3>& slopes) {
  const auto column = [&](int c) {
    return map.scale[0][c] * slopes[0] + map.scale[1][c] * slopes[1] + map.scale[2][c] * slopes[2];
  };
  return {column(0), column(1), column(2)};
}

// The transpose: cotangents of d/d(l, m, n).
__device__ inline std::array<Vec3d, 3> FromWorldColumns(const LocalMap& map,
                                                        const std::array<Vec3d, 3>& columns) {
  const auto slope = [&](const Vec3d& scale) {
    return scale.x * columns[0] + scale.y * columns[1] + scale.z * columns[2];
  };
  return {slope(map.scale[0]), slope(map.scale[1]), slope(map.scale[2])};
}

// Copies what the threads of a block share. Callers wait for all threads afterwards.
template <class T>
__device__ inline void CopyToShared(const T& from, T& to) {
  static_assert(sizeof(T) % sizeof(double) == 0);
  const auto* const source = reinterpret_cast<const double*>(&from);
  auto* const target = reinterpret_cast<double*>(&to);
  for (unsigned i = threadIdx.x; i < sizeof(T) / sizeof(double); i += kPointThreads) {
    target[i] = source[i];
  }
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_POINTS_BOX_POINT_CUH_
