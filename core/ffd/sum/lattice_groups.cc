// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/sum/lattice_groups.h"

#include <algorithm>

#include "core/base/status_macros.h"

namespace latticed {

absl::StatusOr<std::vector<LatticeGroup>> GroupLattices(std::span<const LatticeStructure> lattices,
                                                        std::span<const Vec3d> mesh) {
  std::vector<LatticeGroup> groups;
  for (size_t k = 0; k < lattices.size(); ++k) {
    const auto own = std::ranges::find_if(groups, [&](const LatticeGroup& group) {
      return AreParallel(lattices[group.members.front()], lattices[k]);
    });
    (own == groups.end() ? groups.emplace_back() : *own).members.push_back(k);
  }
  for (LatticeGroup& group : groups) {
    LATTICED_ASSIGN_OR_RETURN(group.sum, SumLattices(lattices, mesh, group.members));
  }
  return groups;
}

}  // namespace latticed
