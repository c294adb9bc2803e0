// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A lattice whose frame is turned against that of a plan's own lattice, and whose displacement adds to it:
//
//   F(x) = R(x) + sum_g (R_g(x) - x)        R: the plan's lattice, R_g: the turned ones
//
// Beyond its frame a turned lattice moves nothing. The mesh is cut at the knot planes of all lattices
// (plan/knot_split.h), so on a patch each R_g is one polynomial, or nothing.
//
// Units    world units; parameters of the turned lattice
// Threads  plain data and pure functions
#ifndef LATTICED_CORE_FFD_TURNED_TURNED_LATTICE_H_
#define LATTICED_CORE_FFD_TURNED_TURNED_LATTICE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/vec.h"
#include "core/ffd/box/volume_point.h"
#include "core/ffd/lattice.h"

namespace latticed {

// The knot spans of a box, by axis. kNoSpans: outside the frame.
using KnotSpans = std::array<int, 3>;
inline constexpr KnotSpans kNoSpans{-1, -1, -1};

// Control points by index along each axis, from first to last.
struct PointRange {
  std::array<int, 3> first{}, last{};
};

struct TurnedLattice {
  LatticeStructure structure;
  size_t first_point = 0;  // of its control points, among those of the plan
  std::vector<Vec3d>
      parameters;  // by vertex of the plan; exactly the knot where it is on a knot plane
  std::vector<KnotSpans> spans;  // by patch

  // Those of this lattice.
  std::span<const Vec3d> PointsOf(std::span<const Vec3d> of_plan) const {
    return of_plan.subspan(first_point, static_cast<size_t>(structure.control_point_count()));
  }
  // Those whose basis function's support has the vertex, its faces included. Nothing about a patch without such a vertex
  // depends on them. nullopt outside the frame.
  std::optional<PointRange> Reaching(size_t vertex) const;
};

// The spans of the box whose closed cell holds points that lie in one slab per axis; in a knot plane, the lower one.
[[nodiscard]] KnotSpans LowerSpans(const LatticeStructure& structure,
                                   std::span<const Vec3d> parameters);

// What turned lattices add to a point of the world and to the Jacobian there: the sum of R_g(x) - x, and the columns of its
// derivatives by x.
struct TurnedMove {
  Vec3d move;
  std::array<Vec3d, 3> jacobian;

  // Adds a lattice's: `point` is its R at the point `world`.
  void Add(const VolumePoint& point, const std::array<Vec3d, 3>& parameter_by_world, Vec3d world);
};

// Evaluates turned lattices under the control points of a plan. Keeps references to both.
class TurnedMoves {
 public:
  TurnedMoves(std::span<const TurnedLattice> lattices, std::span<const Vec3d> control_points);

  // At barycentrics of a patch with these vertices. `world`: the point at rest.
  [[nodiscard]] TurnedMove OfPatch(size_t patch, const std::array<uint32_t, 3>& vertices,
                                   const std::array<double, 3>& barycentrics, Vec3d world) const;
  // At the place t from vertex a to vertex b, which are equal or joined by an edge.
  [[nodiscard]] Vec3d OnEdge(uint32_t a, uint32_t b, double t, Vec3d world) const;

 private:
  std::span<const TurnedLattice> lattices_;
  std::span<const Vec3d> control_points_;
  std::vector<std::array<Vec3d, 3>>
      parameter_by_world_;  // by lattice: d(u,v,w) / d(x, y, z), columns
};

// The same at any point of the world, under the control points of the plan.
[[nodiscard]] TurnedMove TurnedMoveAt(std::span<const TurnedLattice> lattices,
                                      std::span<const Vec3d> control_points, Vec3d world);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_TURNED_TURNED_LATTICE_H_
