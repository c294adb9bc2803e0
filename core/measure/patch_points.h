// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A block of points of the patches of a run (patch_runs.h): where all lattices take them, and what control points do there.
//
//   P = x + w D,   D = sum_g (F_g - x)        x and w are linear in the barycentrics s and t of a triangle
//
// Units    world units, relative to the origin of the runs
// Threads  a block belongs to one thread
#ifndef LATTICED_CORE_MEASURE_PATCH_POINTS_H_
#define LATTICED_CORE_MEASURE_PATCH_POINTS_H_

#include <cstddef>
#include <span>
#include <vector>

#include "core/base/vec.h"
#include "core/measure/patch_point_kernel.h"
#include "core/measure/patch_runs.h"
#include "core/measure/triangle_rule.h"
#include "core/points/point_blocks.h"

namespace latticed {

class PatchPoints {
 public:
  static constexpr size_t kMost = points::kBlockPoints;

  // `lattices`: those of a run. They are kept.
  explicit PatchPoints(std::span<const RunLattice> lattices)
      : lattices_(lattices), local_(lattices.size()) {}

  void Clear() { count_ = 0; }
  size_t count() const { return count_; }
  // Adds points of a triangle, at most kMost together.
  void Add(const RestTriangle& triangle, std::span<const TriangleRulePoint> rule);
  // P and D with their derivatives, at all points.
  void Evaluate();

  Vec3d position(size_t i) const { return points::At(at_[0], i); }
  Vec3d move(size_t i) const { return points::At(moves_[0], i); }

  // Adds the integral of P . n dA, and that of P_j P . n dA.
  void AddVolume(bool with_moment, double& across, Vec3d& moment);
  // sums[g][f]: by lattice, those of l^p m^q n^r f with f = w n dA; with a moment then P_j w n dA. AddVolume comes before.
  void SumVolumeForces(std::span<BoxNumbers> sums, bool with_moment);

  // For AreaOf.
  void SetLengths() { patch_points::AreaLengths(at_, count_, scalar_); }
  // The integral over the points [begin, end).
  double AreaOf(size_t begin, size_t end) const;
  // These have no part in SumAreaForces.
  void LeaveOut(size_t begin, size_t end);
  // sums[g]: by lattice, those for the derivatives of the area at the first `count` points.
  void SumAreaForces(size_t count, bool is_weighted, std::span<BoxNumbers> sums);

 private:
  void ClearFrom(size_t count, points::BlockVec& forces) const;

  const std::span<const RunLattice> lattices_;
  std::vector<points::BlockVec> local_;  // by lattice
  size_t count_ = 0;
  patch_points::Jet rest_, moves_, at_, forces_;
  patch_points::ScalarJet weight_;
  points::BlockArray h_;  // half of a point's weight in the rule
  points::BlockArray scalar_;
  points::BlockVec values_;
  points::BlockSlopes slopes_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_MEASURE_PATCH_POINTS_H_
