// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The definition of det J, lattices to look for folds in, and their plans.
#ifndef LATTICED_TESTS_CORE_FOLDS_FOLD_FIXTURES_H_
#define LATTICED_TESTS_CORE_FOLDS_FOLD_FIXTURES_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "core/ffd/lattice.h"
#include "core/ffd/plan/deform_plan.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {

// det J by the definition (core/ffd/direct_ffd.h), in a box with these spans.
inline double DefinedDeterminant(const LatticeStructure& structure,
                                 std::span<const Vec3d> control_points,
                                 const std::array<int, 3>& span, Vec3d parameter) {
  const VolumePoint point = EvaluateVolume(structure, control_points, span, parameter);
  const FrameMap map(structure);
  std::array<Vec3d, 3> by_world = {map.DirectionToParameter({1, 0, 0}),
                                   map.DirectionToParameter({0, 1, 0}),
                                   map.DirectionToParameter({0, 0, 1})};
  std::array<Vec3d, 3> j;
  WorldJacobian(point.derivatives, by_world.data(), j.data());
  return Dot(j[0], Cross(j[1], j[2]));
}

struct FoldCase {
  LatticeStructure structure;
  std::vector<Vec3d> control_points;
};

// A lattice around a unit cube: degrees from `mix` = 0 … 26, random knots, shear, handedness, and control points that move
// by up to `amount` of the distance to their neighbours.
inline FoldCase DrawLattice(uint32_t seed, uint32_t mix, double amount) {
  std::mt19937 random(seed);
  const auto below = [&](uint32_t n) { return static_cast<int>(random() % n); };
  LatticeOptions options;
  for (const size_t axis : {0u, 1u, 2u}) {
    options.degree[axis] = 1 + static_cast<int>(mix % 3);
    mix /= 3;
    options.extra[axis] = below(4);
  }
  options.knots = static_cast<KnotKind>(below(4));
  options.shear = 0.3 * below(3);
  options.mirrored = below(2) == 1;
  Bounds bounds;
  bounds.Extend(Vec3d{0, 0, 0});
  bounds.Extend(Vec3d{1, 1, 1});
  FoldCase result{.structure = MakeStructure(bounds, options)};
  const LatticeStructure& s = result.structure;
  result.control_points = IdentityControlPoints(s);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::array<Vec3d, 3> spacing;
  for (const size_t axis : {0u, 1u, 2u}) {
    spacing[axis] = (amount / (s.size[axis] - 1)) * s.frame.edges[axis];
  }
  for (Vec3d& point : result.control_points) {
    for (const Vec3d step : spacing) point += uniform(random) * step;
  }
  return result;
}

inline std::shared_ptr<const DeformPlan> PlanOf(const LatticeStructure& structure,
                                                PolygonMesh mesh) {
  auto plan = MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), structure);
  return plan.ok() ? *plan : nullptr;
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CORE_FOLDS_FOLD_FIXTURES_H_
