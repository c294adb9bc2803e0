// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Jacobians of points under one of several lattices, which add up: a normal is not a sum, but follows from the sum of these.
//
//   AddColumns           J += dF/dx - I             F: the lattice's map
//   AddColumnRates       dJ += d(dF/dx)/dP dP       one direction dP
//   AddColumnGradients   dP* += the transposed of AddColumnRates, for cotangents J* of the columns
//
// Nothing is added at points outside the lattice's frame. Points with weights go a part of the way (block_weights.h).
//
// Layout   columns: d/dx of all points in the order in which they were given, then d/dy, then d/dz
// Memory   AddColumnGradients takes SumBytes for one direction while it runs
// Errors   none
// Threads  the arena's. Sums do not depend on how many there are.
#ifndef LATTICED_CORE_POINTS_POINT_COLUMNS_H_
#define LATTICED_CORE_POINTS_POINT_COLUMNS_H_

#include <cstddef>
#include <span>

#include "core/base/vec.h"
#include "core/points/point_kernel.h"
#include "core/points/sorted_points.h"
#include "core/view/cpu_arena.h"

namespace latticed {

inline constexpr size_t kColumns = 3;

void AddColumns(const SortedPoints& points, std::span<const Vec3d> control_points, CpuArena& arena,
                std::span<Vec3d> columns);
void AddColumnRates(const SortedPoints& points, std::span<const Vec3d> tangents, CpuArena& arena,
                    std::span<Vec3d> rates);
void AddColumnGradients(const SortedPoints& points, std::span<const Vec3d> cotangents,
                        CpuArena& arena, std::span<Vec3d> gradients);

}  // namespace latticed

#endif  // LATTICED_CORE_POINTS_POINT_COLUMNS_H_
