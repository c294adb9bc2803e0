// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The inner loops of patch_sums.h, by Highway: points of one patch, one per lane.
//
//   SetRest     x, and the directions themselves as its derivatives
//   SetVolume   R = sum_ijk P_ijk N_i(u) N_j(v) N_k(w), and its derivatives along the directions
//   AddVolume   adds R - x, and what its derivatives differ from the directions
//   Weigh       x + w (F - x) from F, and its derivatives
//
// Only MulAdd makes fused multiply-adds, so that a point has the same bits in any lane.
//
// Layout   arrays of kBlockPoints doubles per component (core/points/point_kernel.h); beyond `count`, up to PaddedCount, they
//          are read and written
// Threads  pure functions
#ifndef LATTICED_CORE_CPU_GEMM_PATCH_SUM_KERNEL_H_
#define LATTICED_CORE_CPU_GEMM_PATCH_SUM_KERNEL_H_

#include <array>
#include <cstddef>

#include "core/base/limits.h"
#include "core/base/vec.h"
#include "core/points/point_kernel.h"

namespace latticed::patch_sums {

inline constexpr size_t kMostDirections = 3;
using Corners = std::array<Vec3d, 3>;

// Barycentrics of points in a patch.
struct Places {
  points::BlockVec barycentrics;  // finite from `count` to PaddedCount
  size_t count = 0;
};

// Positions, and derivatives along each direction.
struct Values {
  points::BlockVec position;
  points::BlockSlopes along;
};

// The patch at rest.
struct Rest {
  Corners corners;
  std::array<Vec3d, kMostDirections> directions;
  size_t direction_count = 0;
};

// The knot box of a lattice that the patch is in.
struct Volume {
  static constexpr size_t kMostPoints =
      (limits::kMaxDegree + 1) * (limits::kMaxDegree + 1) * (limits::kMaxDegree + 1);

  std::array<int, 3> degree{};
  std::array<const double*, 3> span{};  // the knot at which the span begins, among its neighbours
  Corners parameters;                   // of the patch's corners
  std::array<Vec3d, kMostDirections> directions;  // of Rest, in parameters
  Vec3d origin;                                   // one of the box's control points
  // Its control points less `origin`, by component, then u.
  std::array<double, 3 * kMostPoints> points;
};

// The weights of the patch's corners, and the derivatives of the weight along each direction.
struct Weights {
  std::array<double, 3> corners{};
  std::array<double, kMostDirections> along{};
};

void SetRest(const Places& places, const Rest& rest, Values& values);
void SetVolume(const Places& places, const Volume& volume, const Rest& rest, Values& values);
void AddVolume(const Places& places, const Volume& volume, const Rest& rest, Values& values);
void Weigh(const Places& places, const Weights& weights, const Rest& rest, Values& values);

}  // namespace latticed::patch_sums

#endif  // LATTICED_CORE_CPU_GEMM_PATCH_SUM_KERNEL_H_
