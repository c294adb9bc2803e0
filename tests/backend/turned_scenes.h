// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Plans with lattices that are turned against each other.
#ifndef LATTICED_TESTS_BACKEND_TURNED_SCENES_H_
#define LATTICED_TESTS_BACKEND_TURNED_SCENES_H_

#include <span>
#include <vector>

#include "tests/backend/conformance.h"

namespace latticed::testing {

inline constexpr uint32_t kTurnedSeed = 20261201;

// A plan and its control points, which are moved. Those of a lattice with `rests` at its faces are moved inside alone, so that
// the surface is whole where the lattice ends.
struct MovedPlan {
  Plan plan;
  std::vector<Vec3d> points;
};

struct MovedLattice {
  LatticeOptions options;
  bool rests = false;
};

[[nodiscard]] MovedPlan MakeMovedPlan(PolygonMesh mesh, std::span<const MovedLattice> lattices,
                                      VertexWeights weights = nullptr);

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_BACKEND_TURNED_SCENES_H_
