// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Numbers the points of a tessellation so that patches which share a point give it the same number.
//
//   0 …                     vertices of the plan
//   then, edge by edge      the points inside an edge, in its canonical order
//   then, patch by patch    the points inside a patch, in pattern order
//   then                    the outside's vertices and edges of torn seams (deform_plan.h), which have two places
//
// With Welding::kNone no patches share a point: all points, patch by patch, in pattern order.
//
// While no seam is torn, the numbers depend only on the mesh, the lattice's structure and the patterns.
//
// Threads  immutable once made; keeps references to the plan and the patterns
#ifndef LATTICED_SERVER_ENGINE_EXPORTS_WELDED_POINTS_H_
#define LATTICED_SERVER_ENGINE_EXPORTS_WELDED_POINTS_H_

#include <cstdint>
#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/base/vec.h"
#include "core/ffd/plan/deform_plan.h"
#include "server/engine/exports/surface_patterns.h"

namespace latticed {

enum class Welding { kShared, kNone };

class WeldedPoints {
 public:
  // At most `kNoIndex` points. All patches of an edge split it alike.
  WeldedPoints(const DeformPlan& plan, std::span<const Vec3d> control_points,
               const SurfacePatterns& patterns, Welding welding = Welding::kShared);

  uint32_t count() const { return count_; }
  // The numbers of a patch's points, in pattern order.
  std::vector<uint32_t> OfPatch(size_t patch) const;

  // No tessellation of the plan with these segments has more points.
  static uint64_t Most(const DeformPlan& plan, int segments);

 private:
  void WeldFeatures(std::span<const Vec3d> control_points);
  uint32_t VertexNumber(const Patch& patch, uint32_t vertex) const;
  // Of the edge's first inner point.
  uint32_t EdgeNumber(const Patch& patch, uint32_t edge) const;

  const DeformPlan& plan_;
  const SurfacePatterns& patterns_;
  const Welding welding_;
  std::vector<uint32_t> first_of_edge_, first_of_patch_;  // the number of the first inner point
  uint32_t count_ = 0;
  absl::flat_hash_map<uint32_t, uint32_t> torn_vertices_, torn_edges_;  // the outside's
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_EXPORTS_WELDED_POINTS_H_
