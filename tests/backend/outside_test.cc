// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lattices that go on outside their frame: every backend and pipeline against the definition of each mode, and without gaps.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "fmt/format.h"
#include "tests/backend/lattice_scenes.h"

namespace latticed::testing {
namespace {

constexpr std::array<double, 6> kUneven{0.3, 0.5, 0.2, 0.4, 0.6, 0.25};
constexpr std::array<double, 6> kSomeSides{0.3, 0, 0, 0.4, 0.5, 0};

// Around a part of the torus' tube, whose surface leaves it through all six faces.
LatticeInScene AroundTheTube(int mix, const Outside& outside) {
  return {.options = {.degree = MixOfDegrees(mix),
                      .extra = {1, 0, 1},
                      .shear = 0.1,
                      .scale = 0.2,
                      .shift = {0.357, 0, 0}},
          .outside = outside};
}

// Around the middle of the mesh. Lines go on to its ends.
LatticeInScene AroundTheMiddle(int mix, const Outside& outside) {
  return {.options = {.degree = MixOfDegrees(mix),
                      .extra = {1, 0, 1},
                      .shear = 0.1,
                      .scale = 0.6,
                      .turn = 0.4,
                      .shift = {0.05, 0, 0.02}},
          .outside = outside};
}

// Whether each side moves vertices of the mesh that lie outside.
bool CrossesAllFaces(const LatticeScene& scene) {
  const LatticeStructure& s = scene.lattices[0].structure();
  const FrameMap map(s);
  std::array<bool, 6> crossed{};
  for (const PlanVertex& vertex : scene.plan->vertices) {
    const Vec3d at = map.ToParameter(vertex.world);
    for (int a = 0; a < 3; ++a) {
      const double range = s.domain_end(a) - s.domain_begin(a);
      for (const bool at_end : {false, true}) {
        const size_t side = SideOf(static_cast<size_t>(a), at_end);
        const double y = at_end ? at[a] - s.domain_end(a) : s.domain_begin(a) - at[a];
        const double width = s.outside.widths[side] * range;
        crossed[side] = crossed[side] || (y > 0.05 * width && y < 0.95 * width);
      }
    }
  }
  return std::ranges::count(crossed, true) == 6;
}

TEST(OutsideDefinition, IsThatOfThePlanInDouble) {
  for (int mix = 0; mix < 27; ++mix) {
    SCOPED_TRACE(fmt::format("mix {}", mix));
    for (const LatticeInScene& lattice :
         {AroundTheTube(mix, GoesOn(OutsideMode::kFalloff, true, kUneven)),
          AroundTheTube(mix, GoesOn(OutsideMode::kFalloff, false, kUneven)),
          AroundTheTube(mix, GoesOn(OutsideMode::kLinear, true, kSomeSides)),
          AroundTheMiddle(mix, GoesOn(OutsideMode::kLinear, true, {}))}) {
      ExpectSameInDouble(MakeLatticeScene(TorusMesh(9, 6), std::array{lattice}));
    }
  }
}

class OutsideLattices : public LatticeSceneTest {
 protected:
  // Nothing tears: no seam moves apart, whatever control points moved.
  void ExpectWhole(const LatticeScene& scene) {
    ASSERT_NE(scene.plan, nullptr);
    const std::vector<bool> attached = AttachedSeams(*scene.plan, scene.points);
    ASSERT_EQ(std::ranges::count(attached, false), 0);
  }
};

TEST_P(OutsideLattices, FalloffsOfAllDegreeMixesMatchDefinition) {
  for (int mix = 0; mix < 27; ++mix) {
    for (const bool smooth : {true, false}) {
      SCOPED_TRACE(fmt::format("mix {}, C{}", mix, smooth ? 1 : 0));
      const std::array lattices{AroundTheTube(mix, GoesOn(OutsideMode::kFalloff, smooth, kUneven))};
      const LatticeScene scene = MakeLatticeScene(TorusMesh(6, 6), lattices);
      ASSERT_NO_FATAL_FAILURE(ExpectWhole(scene));
      ASSERT_GT(scene.plan->outside_patches, 0u);  // beyond the ends
      if (mix == 13) {
        ASSERT_TRUE(CrossesAllFaces(scene));
      }
      ASSERT_NO_FATAL_FAILURE(ExpectAsDefined(scene, mix + (smooth ? 0 : 2)));
    }
  }
}

TEST_P(OutsideLattices, LinesOfAllDegreeMixesMatchDefinition) {
  for (int mix = 0; mix < 27; ++mix) {
    SCOPED_TRACE(fmt::format("mix {}", mix));
    const std::array lattices{AroundTheMiddle(mix, GoesOn(OutsideMode::kLinear, true, {}))};
    const LatticeScene scene = MakeLatticeScene(
        mix % 2 == 0 ? TorusMesh(7, 5) : TriangleSoup(30, kLatticesSeed), lattices);
    ASSERT_NO_FATAL_FAILURE(ExpectWhole(scene));
    ASSERT_EQ(scene.plan->outside_patches, 0u);  // as far as the mesh reaches
    if (mix == 13) {
      ASSERT_TRUE(CrossesAllFaces(scene));
    }
    ASSERT_NO_FATAL_FAILURE(ExpectAsDefined(scene, mix));
  }
}

// Where the side has no width, or lines end within the mesh, the surface may tear. Both sides are as defined.
TEST_P(OutsideLattices, SidesThatEndMatchDefinition) {
  for (int mix = 0; mix < 27; mix += 2) {
    SCOPED_TRACE(fmt::format("mix {}", mix));
    const auto mode = mix % 4 == 0 ? OutsideMode::kFalloff : OutsideMode::kLinear;
    const std::array lattices{AroundTheTube(mix, GoesOn(mode, mix % 8 == 0, kSomeSides))};
    const LatticeScene scene = MakeLatticeScene(TorusMesh(9, 6), lattices);
    ASSERT_NE(scene.plan, nullptr);
    const std::vector<bool> attached = AttachedSeams(*scene.plan, scene.points);
    ASSERT_GT(std::ranges::count(attached, false), 0);
    ASSERT_NO_FATAL_FAILURE(ExpectAsDefined(scene, mix / 2));
  }
}

// Far from the origin, left-handed, with knots that are close together and repeated. Lines along the faces of a cube.
TEST_P(OutsideLattices, UnusualFramesAndKnotsMatchDefinition) {
  int variant = 0;
  for (const KnotKind knots : {KnotKind::kNonUniform, KnotKind::kRepeated}) {
    for (const bool smooth : {true, false}) {
      SCOPED_TRACE(fmt::format("knots {}, C{}", static_cast<int>(knots), smooth ? 1 : 0));
      LatticeInScene lattice = AroundTheTube(11, GoesOn(OutsideMode::kFalloff, smooth, kUneven));
      lattice.options.extra = {3, 2, 3};
      lattice.options.knots = knots;
      lattice.options.mirrored = true;
      Check(TorusMesh(9, 6, {1500, -2000, 1200}), std::array{lattice}, ++variant);
      lattice = AroundTheMiddle(16, GoesOn(OutsideMode::kLinear, true, {}));
      lattice.options.knots = knots;
      lattice.options.turn = 0;
      lattice.options.shear = 0;
      Check(CubeMesh(3), std::array{lattice}, ++variant);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, OutsideLattices, ::testing::ValuesIn(Subjects()), SubjectName);

}  // namespace
}  // namespace latticed::testing
