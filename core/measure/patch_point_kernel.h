// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The inner loops of patch_points.h, by Highway, compiled once per instruction set. Sets differ in the last bits.
//
//   AddMoves        D += F - x, with its derivatives by s and t        F: a lattice
//   Weigh           P = x + w D, with its derivatives
//   VolumeForces    force = w h P_s x P_t, across = P . h P_s x P_t
//   AreaLengths     |P_s x P_t|
//   AreaForces      derivatives of h |P_s x P_t| by D, D_s and D_t; none where it is 0
//   SlopeForces     derivatives by l, m, n of F, from those by D_s and D_t
//
// Layout   arrays of point_kernel.h; beyond `count`, up to PaddedCount, they are read and written
// Threads  pure functions
#ifndef LATTICED_CORE_MEASURE_PATCH_POINT_KERNEL_H_
#define LATTICED_CORE_MEASURE_PATCH_POINT_KERNEL_H_

#include <array>
#include <cstddef>

#include "core/points/local_map.h"
#include "core/points/point_kernel.h"

namespace latticed::patch_points {

using points::BlockArray;
using points::BlockSlopes;
using points::BlockVec;
using Jet = std::array<BlockVec, 3>;  // a vector, then its derivatives by s and t
using ScalarJet = std::array<BlockArray, 3>;

void AddMoves(const LocalMap& map, const Jet& rest, const BlockVec& values,
              const BlockSlopes& slopes, size_t count, Jet& moves);
void Weigh(const Jet& rest, const ScalarJet& weight, const Jet& moves, size_t count, Jet& points);
void VolumeForces(const Jet& points, const BlockArray& weight, const BlockArray& h, size_t count,
                  BlockVec& force, BlockArray& across);
void AreaLengths(const Jet& points, size_t count, BlockArray& length);
void AreaForces(const Jet& points, const ScalarJet& weight, const BlockArray& h, size_t count,
                Jet& forces);
void SlopeForces(const LocalMap& map, const Jet& rest, const Jet& forces, size_t count,
                 BlockSlopes& by_local);

}  // namespace latticed::patch_points

#endif  // LATTICED_CORE_MEASURE_PATCH_POINT_KERNEL_H_
