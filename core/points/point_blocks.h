// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Blocks of the points of a run, between vectors by number of point and the kernels of point_kernel.h.
//
// Threads  pure functions
#ifndef LATTICED_CORE_POINTS_POINT_BLOCKS_H_
#define LATTICED_CORE_POINTS_POINT_BLOCKS_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "core/base/vec.h"
#include "core/points/block_weights.h"
#include "core/points/local_map.h"
#include "core/points/point_kernel.h"
#include "core/points/sorted_points.h"

namespace latticed::points {

// Up to kBlockPoints points at neighbouring places.
struct Block {
  const SortedPoints& points;
  const LocalMap& map;
  size_t first = 0;
  size_t count = 0;
  BlockVec local;

  size_t number(size_t i) const { return points.order()[first + i]; }
  std::array<const double*, 3> world() const {
    return {points.world(0) + first, points.world(1) + first, points.world(2) + first};
  }
  // Only if the points have normals.
  std::array<const double*, 3> normals() const {
    return {points.normal(0) + first, points.normal(1) + first, points.normal(2) + first};
  }
  // Only if the points have weights.
  BlockWeights weights() const { return {map, points.weights().subspan(first, count)}; }
};

// Calls body(block) for the blocks of a run, in order.
template <class Body>
void ForBlocks(const SortedPoints& points, const SortedPoints::Run& run, const Body& body) {
  const LocalMap map = points.boxes().MapOf(run.box);
  Block block{.points = points, .map = map};
  for (size_t done = 0; done < run.count; done += kBlockPoints) {
    block.first = run.first + done;
    block.count = std::min<size_t>(kBlockPoints, run.count - done);
    MapBlock(map, block.world(), block.count, block.local);
    body(block);
  }
}

inline Vec3d At(const BlockVec& block, size_t i) { return {block[0][i], block[1][i], block[2][i]}; }

inline void Set(BlockVec& block, size_t i, Vec3d v) {
  for (size_t c = 0; c < 3; ++c) block[c][i] = v[static_cast<int>(c)];
}

// Of the points of a block, in the order of `numbered`.
inline void Gather(const Block& block, std::span<const Vec3d> numbered, BlockVec& out) {
  for (size_t i = 0; i < block.count; ++i) Set(out, i, numbered[block.number(i)]);
  for (size_t i = block.count; i < PaddedCount(block.count); ++i) Set(out, i, {});
}
inline void Scatter(const Block& block, const BlockVec& values, std::span<Vec3d> numbered) {
  for (size_t i = 0; i < block.count; ++i) numbered[block.number(i)] = At(values, i);
}

// Deformed points, and their derivatives by l, m, n unless `slopes` is null.
inline void SetValues(const Block& block, const BoxPolynomial& polynomial, BlockVec& values,
                      BlockSlopes* slopes) {
  EvaluateBlock(block.points.boxes().structure().degree, polynomial, block.local, block.count,
                values, slopes);
  if (block.points.has_weights()) block.weights().WeighValues(block.world(), values, slopes);
}
// How both move; `velocity` is that of the polynomial.
inline void SetVelocities(const Block& block, const BoxPolynomial& velocity, BlockVec& values,
                          BlockSlopes* slopes) {
  EvaluateBlock(block.points.boxes().structure().degree, velocity, block.local, block.count, values,
                slopes);
  if (block.points.has_weights()) block.weights().WeighVelocities(values, slopes);
}

}  // namespace latticed::points

#endif  // LATTICED_CORE_POINTS_POINT_BLOCKS_H_
