// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points of patches by the definition (core/ffd/direct_ffd.h): sums of basis functions in double, of all lattices and with
// vertex weights. All points of a patch are evaluated together, so that they share vectors and control points.
//
// The bits of a point depend on the instruction set, and on nothing else.
//
// Layout   patch_sum_kernel.h
// Units    world units; positions and control points relative to plan.local_origin
// Threads  Evaluate is const; one object may serve many threads
#ifndef LATTICED_CORE_CPU_GEMM_PATCH_SUMS_H_
#define LATTICED_CORE_CPU_GEMM_PATCH_SUMS_H_

#include <span>
#include <vector>

#include "core/base/vec.h"
#include "core/cpu/gemm/patch_sum_kernel.h"
#include "core/ffd/lattice.h"
#include "core/ffd/plan/deform_plan.h"

namespace latticed {

class PatchSums {
 public:
  // Keeps a reference to the plan.
  PatchSums(const DeformPlan& plan, std::span<const Vec3d> control_points);
  PatchSums(const PatchSums&) = delete;  // it refers to its own control points
  PatchSums& operator=(const PatchSums&) = delete;

  // Sets positions, and the derivatives along each of up to three directions of the world.
  void Evaluate(size_t patch, const patch_sums::Places& places, std::span<const Vec3d> directions,
                patch_sums::Values& values) const;

 private:
  // A lattice, and its control points.
  struct Lattice {
    const LatticeStructure& structure;
    FrameMap map;
    std::span<const Vec3d> control_points;
  };

  // The knot box of a lattice with these spans, but for the patch's parameters.
  static patch_sums::Volume VolumeOf(const Lattice& lattice, const std::array<int, 3>& spans,
                                     const patch_sums::Rest& rest);

  const DeformPlan& plan_;
  const std::vector<Vec3d> control_points_;
  const Lattice own_;
  std::vector<Lattice> turned_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_GEMM_PATCH_SUMS_H_
