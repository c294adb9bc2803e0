// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The normal that a deformation carries, as a function of its Jacobian J = [a b c], and its derivatives, by Highway: a block
// of points of one knot box at a time. Twin of cuda/points/point_normal.cuh.
//
//   s   = cof(J) N = N_x (b x c) + N_y (c x a) + N_z (a x b)          n = s / |s|
//   dn  = (ds - n (n . ds)) / |s|,   ds = N_x (db x c + b x dc) + …
//   transposed:  h = (g - n (n . g)) / |s|,   a* = N_y (h x c) + N_z (b x h),   b* = N_x (c x h) + N_z (h x a),
//                c* = N_x (h x b) + N_y (a x h)
//
// Where the normal is undefined (carried_normal.h: kappa above kMaxNormalCondition), it and its derivatives are zero.
//
// Layout   as in point_kernel.h; beyond `count`, up to PaddedCount, rest normals are taken as zero, and so is all else
// Threads  pure functions
#ifndef LATTICED_CORE_POINTS_NORMAL_KERNEL_H_
#define LATTICED_CORE_POINTS_NORMAL_KERNEL_H_

#include <array>
#include <cstddef>

#include "core/points/local_map.h"
#include "core/points/point_kernel.h"

namespace latticed::points {

// The normals of a block, with what their derivatives need.
struct BlockNormals {
  BlockSlopes jacobian;  // columns d(deformed)/d(x, y, z)
  BlockVec rest, value;
  BlockArray inverse_length;  // of cof(J) N; zero where the normal is undefined
};

// From the derivatives by l, m, n, and `count` rest normals, each of unit length or zero.
void MakeNormals(const LocalMap& map, const BlockSlopes& slopes,
                 const std::array<const double*, 3>& rest, size_t count, BlockNormals& normals);
// How the normals move when the derivatives by l, m, n move by `rates`.
void NormalVelocities(const LocalMap& map, const BlockNormals& normals, const BlockSlopes& rates,
                      size_t count, BlockVec& velocities);
// The cotangents of the derivatives by l, m, n, for those of the normals.
void NormalCotangents(const LocalMap& map, const BlockNormals& normals, const BlockVec& cotangents,
                      size_t count, BlockSlopes& slopes);

}  // namespace latticed::points

#endif  // LATTICED_CORE_POINTS_NORMAL_KERNEL_H_
