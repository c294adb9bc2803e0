// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The lattices of a mesh in groups. The frames of a group have parallel edges, so its lattices add up to one
// (lattice_sum.h); groups are turned against each other (../turned/turned_lattice.h). The first lattice is in the first group.
//
// Errors   those of SumLattices. Where there are several groups, each lattice must contain the mesh or fade out in it
// Threads  pure function
#ifndef LATTICED_CORE_FFD_SUM_LATTICE_GROUPS_H_
#define LATTICED_CORE_FFD_SUM_LATTICE_GROUPS_H_

#include <cstddef>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/ffd/sum/lattice_sum.h"

namespace latticed {

struct LatticeGroup {
  std::vector<size_t> members;  // ascending
  LatticeSum sum;               // of the members
};

// `lattices` must be valid, and at least one. `mesh`: the points at rest.
[[nodiscard]] absl::StatusOr<std::vector<LatticeGroup>> GroupLattices(
    std::span<const LatticeStructure> lattices, std::span<const Vec3d> mesh);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_SUM_LATTICE_GROUPS_H_
