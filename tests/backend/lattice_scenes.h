// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lattices that go on outside, take a part of the deformation, or add up to one: the plan of them, as the server makes it, and
// what each does by its own definition (tests/support/lattice_definition.h).
#ifndef LATTICED_TESTS_BACKEND_LATTICE_SCENES_H_
#define LATTICED_TESTS_BACKEND_LATTICE_SCENES_H_

#include <array>
#include <span>
#include <vector>

#include "tests/backend/conformance.h"
#include "tests/support/lattice_definition.h"

namespace latticed::testing {

inline constexpr uint32_t kLatticesSeed = 20261130;
// Two ways to one number in double. Positions by the deformed mesh's diagonal: core/ffd/outside/README.md promises this inside,
// and the functions that go on outside are no larger than a few. A derivative has a position's error over the shortest knot
// span, which is above a hundredth of the meshes here.
inline constexpr double kDoublePosition = 1e-14;
inline constexpr double kDoubleJacobian = 100 * kDoublePosition;

struct LatticeInScene {
  LatticeOptions options;
  Outside outside;  // without steps
  double strength = 1;
  double noise = 0.08;  // by which control points move, in lengths of the shortest edge
};
// A falloff or straight lines, with these widths.
[[nodiscard]] Outside GoesOn(OutsideMode mode, bool smooth, const std::array<double, 6>& widths);
// The nth of the 27 mixes of degrees.
[[nodiscard]] std::array<int, 3> MixOfDegrees(int n);

struct LatticeScene {
  Plan plan;
  std::vector<Vec3d> points;  // control points of the plan
  std::vector<LatticeDefinition> lattices;

  // x + w sum (F_k(x) - x). w: the weight, 1 without weights.
  [[nodiscard]] DeformedPoint At(size_t patch, const std::array<double, 3>& barycentrics) const;
};
// The plan is null, and the test fails, if there is none.
[[nodiscard]] LatticeScene MakeLatticeScene(PolygonMesh mesh,
                                            std::span<const LatticeInScene> lattices,
                                            VertexWeights weights = nullptr);

// Whether the plan's own definition, core/ffd/direct_ffd.h, says the same as the lattices', to the rounding of doubles.
void ExpectSameInDouble(const LatticeScene& scene);

class LatticeSceneTest : public BackendTest {
 protected:
  // Positions and normals of all points are those of the definition, and neighbours have the same bits on shared edges. In
  // floats, by 3 or 7 segments, with facet or smooth normals: `variant` 0 to 3.
  void ExpectAsDefined(const LatticeScene& scene, int variant);
  void Check(PolygonMesh mesh, std::span<const LatticeInScene> lattices, int variant,
             VertexWeights weights = nullptr) {
    ExpectAsDefined(MakeLatticeScene(std::move(mesh), lattices, std::move(weights)), variant);
  }
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_BACKEND_LATTICE_SCENES_H_
