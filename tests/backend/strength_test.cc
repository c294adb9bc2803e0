// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes that take a part of the deformation, with and without weights of vertices: x goes to x + w s (F(x) - x) on every
// backend and pipeline.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "fmt/format.h"
#include "tests/backend/lattice_scenes.h"

namespace latticed::testing {
namespace {

// Fixed, with a falloff, and along lines, in turn.
LatticeInScene WeakLattice(int mix, double strength) {
  constexpr std::array kModes{OutsideMode::kFixed, OutsideMode::kFalloff, OutsideMode::kLinear};
  const OutsideMode mode = kModes[static_cast<size_t>((mix + mix / 3 + mix / 9) % 3)];
  Outside outside;
  if (mode == OutsideMode::kFalloff) {
    outside = GoesOn(mode, mix % 2 == 0, {0.1, 0.3, 0.2, 0.4, 0.3, 0.3});
  } else if (mode == OutsideMode::kLinear) {
    outside = GoesOn(mode, true, {});
  }
  const double scale = mode == OutsideMode::kFixed ? 1.1 : 0.6;
  return {.options = {.degree = MixOfDegrees(mix), .extra = {1, 0, 1}, .scale = scale, .turn = 0.4},
          .outside = outside,
          .strength = strength};
}

class Strengths : public LatticeSceneTest {
 protected:
  void CheckAllMixes(bool weighted) {
    constexpr std::array kParts{0.375, 0.0, 0.8125, 0.01, 1.0};
    for (int mix = 0; mix < 27; ++mix) {
      const double strength = kParts[static_cast<size_t>(mix) % kParts.size()];
      SCOPED_TRACE(fmt::format("mix {}, strength {}", mix, strength));
      const PolygonMesh mesh = TorusMesh(8, 5);
      const VertexWeights weights = weighted ? RandomWeights(mesh, kLatticesSeed) : nullptr;
      Check(mesh, std::array{WeakLattice(mix, strength)}, mix, weights);
      if (HasFatalFailure()) return;
    }
  }
};

TEST_P(Strengths, AllDegreeMixesMatchDefinition) { CheckAllMixes(false); }

TEST_P(Strengths, AllDegreeMixesWithWeightsMatchDefinition) { CheckAllMixes(true); }

// Also on a face of the frame, where the surface of a greater strength tears.
TEST_P(Strengths, AtNoneEverythingRests) {
  LatticeInScene lattice = WeakLattice(13, 0);
  lattice.options.scale = 0.6;
  lattice.outside = {};
  const PolygonMesh mesh = TorusMesh(8, 5, {150, -200, 120});
  for (const VertexWeights& weights : {VertexWeights(), RandomWeights(mesh, kLatticesSeed)}) {
    const LatticeScene scene = MakeLatticeScene(mesh, std::array{lattice}, weights);
    ASSERT_NE(scene.plan, nullptr);
    ASSERT_GT(scene.plan->seams.size(), 0u);
    const std::vector<bool> attached = AttachedSeams(*scene.plan, scene.points);
    EXPECT_EQ(std::ranges::count(attached, false), 0);
    EXPECT_EQ(scene.points, scene.plan->identity_points);
    ExpectAsDefined(scene, 2);
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, Strengths, ::testing::ValuesIn(Subjects()), SubjectName);

}  // namespace
}  // namespace latticed::testing
