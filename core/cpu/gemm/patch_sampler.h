// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Samples of the deformation at the m uniform points of a patch.      Cui & Feng 2014, §3.4
//
//   Rs[i] = R(u_i) - centre,   u_i = sum_c (t_ic / n) u_c,   t_i the index triples of bernstein.h
//   Rf[i] = dR/df (u_i),       f the unit facet normal of the source triangle
//
// Where lattices are turned against the plan's own (core/ffd/turned/), R is x plus what all of them move x. With vertex
// weights (core/ffd/weights/) x + w (R - x) takes its place, which is of one degree more.
//
// Samples are summed in double (patch_sums.h). `centre`, the mean of the three corner samples, is subtracted before anything
// is rounded, so that the digits of float32 hold the patch's shape and not its place.
//
// Layout   column-major, m x 3: x of all samples, then y, then z, with a stride between the columns
// Units    world units relative to plan.local_origin
// Threads  Sample is const; one object may serve many threads
#ifndef LATTICED_CORE_CPU_GEMM_PATCH_SAMPLER_H_
#define LATTICED_CORE_CPU_GEMM_PATCH_SAMPLER_H_

#include <array>
#include <cstddef>
#include <span>

#include "core/cpu/gemm/patch_sums.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/ffd/stage_matrices.h"

namespace latticed {

class PatchSampler {
 public:
  // Keeps a reference to the plan. `stage` has the plan's surface_degree().
  PatchSampler(const DeformPlan& plan, const StageMatrices& stage,
               std::span<const Vec3d> control_points);

  // Writes column a at positions + a * stride, and dR/df likewise when `by_normal` is not null.
  // Returns the centre.
  Vec3d Sample(size_t patch, double* positions, double* by_normal, Vec3d facet_normal,
               size_t stride) const;

  const PatchSums& sums() const { return sums_; }

 private:
  PatchSums sums_;
  patch_sums::Places samples_{};
  std::array<size_t, 3> corners_;  // among the samples
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_GEMM_PATCH_SAMPLER_H_
