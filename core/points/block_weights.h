// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Weights of the points of a block (core/ffd/weights/vertex_weights.h), with g = grad(w), between the kernels of point_kernel.h
// and normal_kernel.h. x is the point at rest, F the lattice's map, e_l = dx/dl the box's edges; the same for m and n.
//
//   values       P = x + w (F - x),   P_l = w F_l + (1 - w) e_l + (g . e_l) (F - x)
//   velocities   dP = w dF,           dP_l = w dF_l + (g . e_l) dF
//   transposed   F* = w P* + sum over l, m, n of (g . e_l) P_l*,   F_l* = w P_l*
//
// The normal kernel makes the weighted J of the weighted P_l, so it knows nothing of weights.
//
// Layout   as in point_kernel.h; nothing is read or written beyond the count
// Threads  pure functions
#ifndef LATTICED_CORE_POINTS_BLOCK_WEIGHTS_H_
#define LATTICED_CORE_POINTS_BLOCK_WEIGHTS_H_

#include <array>
#include <span>

#include "core/base/vec.h"
#include "core/points/local_map.h"
#include "core/points/point_kernel.h"
#include "core/points/sorted_points.h"

namespace latticed::points {

class BlockWeights {
 public:
  // `weights` has one per point of the block. It is kept.
  BlockWeights(const LocalMap& map, std::span<const PointWeight> weights);

  // F and its derivatives become P and its derivatives; `slopes` may be null. `world`: x in three arrays.
  void WeighValues(const std::array<const double*, 3>& world, BlockVec& values,
                   BlockSlopes* slopes) const;
  // `slopes` may be null.
  void WeighVelocities(BlockVec& values, BlockSlopes* slopes) const;
  // Cotangents of P and of its derivatives become those of F; `slopes` may be null.
  void WeighCotangents(BlockVec& values, BlockSlopes* slopes) const;

 private:
  Vec3d Rise(size_t i) const;

  const std::span<const PointWeight> weights_;
  std::array<Vec3d, 3> edges_;
};

}  // namespace latticed::points

#endif  // LATTICED_CORE_POINTS_BLOCK_WEIGHTS_H_
