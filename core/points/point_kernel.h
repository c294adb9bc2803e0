// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The inner loops of point_derivatives.h, by Highway: a block of points of one knot box at a time.
//
//   MapBlock          (l, m, n) of points of the world
//   EvaluateBlock     sum_pqr C_pqr l^p m^q n^r, and its derivatives by l, m, n, by Horner's rule
//   SumBlock          S_pqr += sum over points of l^p m^q n^r g
//   SumSlopeBlock     the same for cotangents of the derivatives: S_pqr += sum of d(l^p m^q n^r)/dl G_l + …
//
// Layout   arrays of kBlockPoints doubles per component; beyond `count`, up to PaddedCount, they are read and written
// Sums     each lane of a vector has a sum of its own, and the lanes are added in order at the end of a block. The bits
//          therefore depend on the instruction set, and on nothing else.
// Threads  pure functions
#ifndef LATTICED_CORE_POINTS_POINT_KERNEL_H_
#define LATTICED_CORE_POINTS_POINT_KERNEL_H_

#include <array>
#include <cstddef>

#include "core/points/box_map.h"

namespace latticed::points {

inline constexpr size_t kBlockPoints = 256;

using BlockArray = std::array<double, kBlockPoints>;
using BlockVec = std::array<BlockArray, 3>;   // by component
using BlockSlopes = std::array<BlockVec, 3>;  // by l, m, n; then by component

// The least multiple of the vectors' length that holds `count` points.
[[nodiscard]] size_t PaddedCount(size_t count);

// `world` has three arrays of `count` points. The rest of the block, up to PaddedCount, becomes zero.
void MapBlock(const LocalMap& map, const std::array<const double*, 3>& world, size_t count,
              BlockVec& local);
// `slopes` may be null.
void EvaluateBlock(const std::array<int, 3>& degree, const BoxPolynomial& polynomial,
                   const BlockVec& local, size_t count, BlockVec& values, BlockSlopes* slopes);
// The cotangents are zero from `count` on, up to PaddedCount.
void SumBlock(const std::array<int, 3>& degree, const BlockVec& local, const BlockVec& cotangents,
              size_t count, BoxNumbers& sums);
void SumSlopeBlock(const std::array<int, 3>& degree, const BlockVec& local,
                   const BlockSlopes& cotangents, size_t count, BoxNumbers& sums);

}  // namespace latticed::points

#endif  // LATTICED_CORE_POINTS_POINT_KERNEL_H_
