// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Samples of the deformation at the m uniform points of a patch.      Cui & Feng 2014, §3.4
//
//   Rs[i] = R(u_i) - centre,   u_i = sum_c (t_ic / n) u_c,   t_i the index triples of bernstein.h
//   Rf[i] = dR/df (u_i),       f the unit facet normal of the source triangle
//
// Where lattices are turned against the plan's own (core/ffd/turned/), R is x plus what all of them move x. With vertex
// weights (core/ffd/weights/) x + w (R - x) takes its place, which is of one degree more, and f + w (dR/df - f): w does
// not change along f.
//
// The basis is evaluated and summed in double. `centre`, the mean of the three corner samples, is subtracted before
// anything is rounded, so that the digits of float32 hold the patch's shape and not its place.
//
// Layout   column-major, m x 3: x of all samples, then y, then z, with a stride between the columns
// Units    world units relative to plan.local_origin
// Threads  Sample is const; one object may serve many threads
#ifndef LATTICED_CORE_CPU_GEMM_PATCH_SAMPLER_H_
#define LATTICED_CORE_CPU_GEMM_PATCH_SAMPLER_H_

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/ffd/plan/deform_plan.h"
#include "core/ffd/stage_matrices.h"

namespace latticed {

class PatchSampler {
 public:
  // Keeps references to both; control points are taken relative to the local origin. `stage` has the plan's
  // surface_degree().
  PatchSampler(const DeformPlan& plan, const StageMatrices& stage,
               std::span<const Vec3d> control_points);
  PatchSampler(const PatchSampler&) = delete;  // it refers to its own control points
  PatchSampler& operator=(const PatchSampler&) = delete;

  // Writes column a at positions + a * stride, and dR/df likewise when `by_normal` is not null.
  // Returns the centre.
  Vec3d Sample(size_t patch, double* positions, double* by_normal, Vec3d facet_normal,
               size_t stride) const;

 private:
  // A lattice, and its control points relative to the local origin.
  struct Volume {
    const LatticeStructure& structure;
    FrameMap map;
    std::span<const Vec3d> control_points;
  };
  struct Columns {
    double* positions;
    double* by_normal;  // or null
    size_t stride;
  };
  // The patch's corners in one space: the parameters of a lattice, or the world.
  using Corners = std::array<Vec3d, 3>;

  template <typename T>
  T At(size_t sample, const std::array<T, 3>& corners) const;
  // Writes R of one lattice, or adds R - x: `rest`, if not null, has the corners in the world.
  void SampleVolume(const Volume& volume, const std::array<int, 3>& span, const Corners& parameters,
                    const Corners* rest, Vec3d facet_normal, const Columns& out) const;
  void SampleOutside(const Corners& rest, Vec3d facet_normal, const Columns& out) const;
  // Weighs samples of a patch that are there. The plan must be weighted.
  void WeighSamples(size_t patch, const Corners& rest, Vec3d facet_normal,
                    const Columns& out) const;

  const DeformPlan& plan_;
  const StageMatrices& stage_;
  const std::vector<Vec3d> control_points_;  // relative to the local origin
  const Volume own_;
  std::vector<Volume> turned_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_GEMM_PATCH_SAMPLER_H_
