// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What one lattice moves a point of the world, in double, also outside its frame. It is written from what the modes of
// core/ffd/outside promise, and knows neither the continued lattice nor sums of lattices.
//
//   F(x) - x = s sum_ijk A_i(u) B_j(v) C_k(w) d_ijk        s: the strength, d: displacements of the control points
//
// Inside, A_i is the B-spline N_i of formula (1). At the distance y from a face of a side with the width W and the step S,
// where a B-spline of degree n has the value f and the slope f', outwards:
//
//   fixed        0
//   linear       f + y f'                             up to W
//   falloff      c (W - y)^n + b max(0, S - y)^n      up to W: n - 1 derivatives go on at S and vanish at W
//     C1         c and b are such that the value is f and the slope is f' at the face
//     C0         value f; the polar form at (S, 0, ..., 0) is f (1 - smoothstep(S / (n W))); also where n = 1
//   further out  0
//
// Units    world units
// Errors   none: structures must be valid, with steps
// Threads  immutable
#ifndef LATTICED_TESTS_SUPPORT_LATTICE_DEFINITION_H_
#define LATTICED_TESTS_SUPPORT_LATTICE_DEFINITION_H_

#include <array>
#include <span>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "core/ffd/lattice.h"

namespace latticed::testing {

class LatticeDefinition {
 public:
  LatticeDefinition(LatticeStructure structure, std::vector<Vec3d> control_points,
                    double strength = 1);

  // Adds F(x) - x and its derivatives to the point that x goes to. `within` says which polynomial counts on a face or a
  // knot plane: that of the piece where it is itself, in a plane that of the lower one.
  void AddTo(DeformedPoint& point, Vec3d x, Vec3d within) const;

  const LatticeStructure& structure() const { return structure_; }

 private:
  // The functions of an axis that are not 0 at a place: `count` from `first` on.
  struct AxisBasis {
    int first = 0, count = 0;
    std::array<double, 4> value{}, slope{};
  };
  AxisBasis BasisAt(size_t axis, double parameter, double within) const;
  AxisBasis BasisBeyond(size_t axis, bool at_end, double distance, double within) const;

  LatticeStructure structure_;
  std::vector<Vec3d> displacements_;  // times the strength
  FrameMap map_;
  std::array<Vec3d, 3> parameter_by_world_;
};

// x + sum (F_k(x) - x), and its derivatives.
[[nodiscard]] DeformedPoint SumAt(std::span<const LatticeDefinition> lattices, Vec3d x,
                                  Vec3d within);

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SUPPORT_LATTICE_DEFINITION_H_
