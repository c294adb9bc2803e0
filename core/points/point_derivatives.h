// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The deformation x of points of the world as a function of the control points P, and its derivatives, in double.
//
//   Deform                   x_k = sum_ijk P_ijk N_i(u_k) N_j(v_k) N_k(w_k)     inside; x_k itself outside. formula (1)
//   ApplyJacobian            dx = (dx/dP) dP               forward mode: one direction dP at a time, or several at once
//   ApplyJacobianTranspose   (dx/dP)^T g                   reverse mode: the derivative by P of sum_k g_k . x_k
//
// With normals, n_k = cof(J) N_k / |…| is a part of x, and so are its derivatives (normal_kernel.h). Points with weights go a
// part of the way (block_weights.h).
//
// The transpose sums l^p m^q n^r g over the points of each run, adds the runs of a box in order, and multiplies each box's
// sums by the transposed basis (box_map.h), box after box. No sum depends on the number of threads.
//
// Layout   per direction: the positions in the order in which the points were given, then the normals if they are asked
//          for. Directions follow each other. Tangents and gradients: one per control point, per direction.
// Memory   ApplyJacobianTranspose takes SumBytes while it runs; the others take none
// Errors   what `stop` says, asked once per kDirectionsTogether directions; then the output is not complete
// Threads  the arena's. Other implementations, on a device for instance, take the same arguments.
#ifndef LATTICED_CORE_POINTS_POINT_DERIVATIVES_H_
#define LATTICED_CORE_POINTS_POINT_DERIVATIVES_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "absl/status/status.h"
#include "core/base/stop_check.h"
#include "core/base/vec.h"
#include "core/points/box_map.h"
#include "core/points/sorted_points.h"
#include "core/view/cpu_arena.h"

namespace latticed {

// Directions that share what does not depend on them.
inline constexpr size_t kDirectionsTogether = 8;

enum class PointNormals { kNone, kWanted };

// Vectors of an answer, or of cotangents, for one direction. kWanted needs points that have normals.
[[nodiscard]] inline size_t VectorsPerDirection(const SortedPoints& points, PointNormals normals) {
  return points.size() * (normals == PointNormals::kWanted ? 2 : 1);
}

// What ApplyJacobianTranspose takes: 1.5 KiB per run and direction, of up to kDirectionsTogether directions.
[[nodiscard]] inline uint64_t SumBytes(const SortedPoints& points, size_t directions) {
  return points.runs().size() * std::min(directions, kDirectionsTogether) * sizeof(BoxNumbers);
}

[[nodiscard]] absl::Status Deform(const SortedPoints& points, std::span<const Vec3d> control_points,
                                  PointNormals normals, CpuArena& arena, StopCheck stop,
                                  std::span<Vec3d> out);
[[nodiscard]] absl::Status ApplyJacobian(const SortedPoints& points,
                                         std::span<const Vec3d> control_points,
                                         std::span<const Vec3d> tangents, PointNormals normals,
                                         CpuArena& arena, StopCheck stop, std::span<Vec3d> out);
// Overwrites `gradients`.
[[nodiscard]] absl::Status ApplyJacobianTranspose(const SortedPoints& points,
                                                  std::span<const Vec3d> control_points,
                                                  std::span<const Vec3d> cotangents,
                                                  PointNormals normals, CpuArena& arena,
                                                  StopCheck stop, std::span<Vec3d> gradients);

}  // namespace latticed

#endif  // LATTICED_CORE_POINTS_POINT_DERIVATIVES_H_
