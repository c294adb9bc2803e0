// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The lattices of a scene at one revision. The displacements of several add up: those of parallel frames to one lattice, which is
// planned (core/ffd/sum/lattice_groups.h).
//
// Threads  plain data and pure functions
#ifndef LATTICED_SERVER_ENGINE_LATTICES_SCENE_LATTICE_H_
#define LATTICED_SERVER_ENGINE_LATTICES_SCENE_LATTICE_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/vec.h"
#include "core/ffd/constraints/constraints.h"
#include "core/ffd/lattice.h"
#include "core/ffd/outside/outside_map.h"

namespace latticed {

struct SceneLattice {
  // By which edits and clients name it. The others keep theirs where it is removed.
  uint32_t number = 0;
  // From its control points to those of the plan, with its strength.
  std::shared_ptr<const OutsideMap> map;
  // As edits and clients see them.
  std::shared_ptr<const std::vector<Vec3d>> points;
  // What it moves the control points of the plan. Null in a scene of one lattice.
  std::shared_ptr<const std::vector<Vec3d>> moves;
  // What edits keep.
  std::shared_ptr<const Constraints> constraints;

  const LatticeStructure& structure() const { return map->structure(); }
};

// Those that the scene has, their numbers ascending.
using SceneLattices = std::vector<SceneLattice>;

// Where the lattice with this number is among them; their count if it is not.
[[nodiscard]] size_t PlaceOf(const SceneLattices& lattices, uint32_t number);

// kInvalidArgument naming `field` for the number of a lattice that there is not.
[[nodiscard]] absl::Status CheckLattice(const SceneLattices& lattices, uint32_t number,
                                        std::string_view field);
struct PlannedLattices {
  SceneLattices lattices;  // with maps of strength 1; the rest is null
  std::vector<LatticeStructure>
      structures;  // to be planned: the first one, then those turned against it
};
// Lattices with these structures, by number. `mesh`: the points at rest. Errors: those of GroupLattices.
[[nodiscard]] absl::StatusOr<PlannedLattices> PlanLattices(
    const std::map<uint32_t, LatticeStructure>& structures, std::span<const Vec3d> mesh);
// Sets the points of the lattice at place `k`, at this strength. Its map may be of another one.
void TakePoints(SceneLattices& lattices, size_t k, double strength,
                const std::vector<Vec3d>& points);
// The control points of the plan, from the points of all lattices. They do not depend on the order of edits.
[[nodiscard]] std::shared_ptr<const std::vector<Vec3d>> PlannedPoints(
    const SceneLattices& lattices);
// The map of the lattice at place `k`, which also adds what the others move. Those must have their moves.
[[nodiscard]] std::shared_ptr<const OutsideMap> MapAmongOthers(const SceneLattices& lattices,
                                                               size_t k);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_LATTICES_SCENE_LATTICE_H_
