// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Several lattices that deform one mesh at once: their displacements add.
//
//   F(x) = x + sum_k s_k (F_k(x) - x)
//
// Where the frames have parallel edges, F is one lattice again: with the knots of all of them and, per axis, the highest
// degree. It is exact. Plans, kernels, certificates and derivatives see this lattice alone (../outside/outside_map.h).
//
// Continuity  a knot of a lattice of degree n with multiplicity m gets multiplicity N - n + m, with N the sum's degree; an end
//             where a lattice fades out (OutsideMode::kFalloff, n layers at rest) counts as a knot with m = 1
// Frame       the box that ends where the last lattice does. Beyond the mesh, the nearest end of a lattice that does not fade out
//             is the end: points beyond it do not move. A lattice that ends inside the mesh must fade out there; otherwise
//             the surface would tear in the middle
// Knots       within 2^-40 of the range of an axis are one knot, as in knot_split.h. Those of the first lattice stay
// Errors      kInvalidArgument: field "lattices[k].outside"; "lattices" for too many control points
// Threads     pure functions
#ifndef LATTICED_CORE_FFD_SUM_LATTICE_SUM_H_
#define LATTICED_CORE_FFD_SUM_LATTICE_SUM_H_

#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/vec.h"
#include "core/ffd/lattice.h"
#include "core/ffd/sum/knot_refinement.h"

namespace latticed {

struct LatticeSum {
  LatticeStructure structure;      // with the parameters of the first lattice
  std::vector<RefinedAxes> parts;  // one per lattice, of its control points as it is continued
};

// Whether the edges of both frames are parallel, and have the same directions.
[[nodiscard]] bool AreParallel(const LatticeStructure& first, const LatticeStructure& other);

// Sums those `lattices` that `members` names, ascending. They must be valid, parallel, and at least one. `mesh`: the points at
// rest. Where there are others, the mesh counts as a lattice that goes on to its bounds.
[[nodiscard]] absl::StatusOr<LatticeSum> SumLattices(std::span<const LatticeStructure> lattices,
                                                     std::span<const Vec3d> mesh,
                                                     std::span<const size_t> members);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_SUM_LATTICE_SUM_H_
