// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Several lattices of one mesh whose frames are parallel, so that they add up to one (core/ffd/sum): every backend and pipeline
// against the sum of their displacements, each by its own definition. Also beside lattices that are turned against them.
#include <gtest/gtest.h>

#include <array>

#include "fmt/format.h"
#include "tests/backend/lattice_scenes.h"

namespace latticed::testing {
namespace {

constexpr std::array<double, 6> kFades{0.4, 0.6, 0.5, 0.3, 0.6, 0.4};

LatticeInScene AroundAll(std::array<int, 3> degree, double turn = 0) {
  return {.options = {.degree = degree, .extra = {1, 0, 1}, .scale = 1.6, .turn = turn},
          .outside = {},
          .noise = 0.04};
}

// Around a part of the tube. It fades out within the mesh.
LatticeInScene Spot(std::array<int, 3> degree, bool smooth, double turn = 0) {
  return {.options = {.degree = degree,
                      .extra = {0, 1, 0},
                      .scale = 0.3,
                      .turn = turn,
                      .shift = {0.3, 0.1, 0}},
          .outside = GoesOn(OutsideMode::kFalloff, smooth, kFades),
          .strength = 0.75};
}

// To the ends of the mesh, along lines.
LatticeInScene Lines(std::array<int, 3> degree) {
  return {.options = {.degree = degree, .extra = {0, 0, 0}, .scale = 0.8, .shift = {-0.05, 0, 0}},
          .outside = GoesOn(OutsideMode::kLinear, true, {}),
          .strength = 0.5,
          .noise = 0.04};
}

// The mix of degrees and another one.
std::array<LatticeInScene, 2> TwoLattices(int mix) {
  return {AroundAll(MixOfDegrees(mix)), Spot(MixOfDegrees((5 * mix + 7) % 27), mix % 2 == 0)};
}

// One that lies within another, one that ends in the mesh only because it fades out, and one whose lines go on.
std::array<LatticeInScene, 4> FourLattices() {
  LatticeInScene inner = Spot({1, 3, 2}, false);
  inner.options.scale = 0.15;
  inner.strength = 1;
  return {Lines({2, 2, 1}), AroundAll({1, 2, 2}), Spot({2, 2, 2}, true), inner};
}

// Two of one direction and two of another.
std::array<LatticeInScene, 4> TwoGroups(int mix) {
  const std::array<int, 3> degree = MixOfDegrees(mix);
  return {AroundAll(degree), AroundAll({1, 2, 1}, 0.7), Spot({2, 1, 2}, mix % 8 == 0),
          Spot({degree[2], degree[0], degree[1]}, true, 0.7)};
}

TEST(SumDefinition, IsThatOfThePlanInDouble) {
  const PolygonMesh mesh = TorusMesh(6, 4);
  const VertexWeights weights = RandomWeights(mesh, kLatticesSeed);
  for (int mix = 0; mix < 27; ++mix) {
    SCOPED_TRACE(fmt::format("mix {}", mix));
    ExpectSameInDouble(MakeLatticeScene(mesh, TwoLattices(mix), mix % 3 == 0 ? weights : nullptr));
    ExpectSameInDouble(MakeLatticeScene(mesh, TwoGroups(mix), mix % 3 == 1 ? weights : nullptr));
  }
  ExpectSameInDouble(MakeLatticeScene(mesh, FourLattices(), weights));
}

class ParallelSums : public LatticeSceneTest {
 protected:
  void CheckAllMixes(bool weighted) {
    const PolygonMesh mesh = TorusMesh(6, 4);
    const VertexWeights weights = weighted ? RandomWeights(mesh, kLatticesSeed) : nullptr;
    for (int mix = 0; mix < 27; ++mix) {
      SCOPED_TRACE(fmt::format("mix {}", mix));
      const LatticeScene scene = MakeLatticeScene(mesh, TwoLattices(mix), weights);
      ASSERT_NE(scene.plan, nullptr);
      ASSERT_TRUE(scene.plan->turned.empty());
      ASSERT_NO_FATAL_FAILURE(ExpectAsDefined(scene, mix));
    }
  }
};

TEST_P(ParallelSums, AllDegreeMixesMatchDefinition) { CheckAllMixes(false); }

TEST_P(ParallelSums, AllDegreeMixesWithWeightsMatchDefinition) { CheckAllMixes(true); }

TEST_P(ParallelSums, FourLatticesMatchDefinition) {
  const PolygonMesh mesh = TorusMesh(9, 6);
  for (int variant = 0; variant < 4; ++variant) {
    Check(mesh, FourLattices(), variant,
          variant == 1 || variant == 2 ? RandomWeights(mesh, kLatticesSeed) : nullptr);
  }
}

// At strength 0 it rests, but its knots are there.
TEST_P(ParallelSums, LatticesAtRestMatchDefinition) {
  LatticeInScene none = Spot({2, 1, 2}, true);
  none.strength = 0;
  for (int variant = 0; variant < 4; ++variant) {
    Check(TorusMesh(7, 5, {150, -200, 120}), std::array{AroundAll({2, 2, 2}), none}, variant);
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, ParallelSums, ::testing::ValuesIn(Subjects()), SubjectName);

class SumsOfGroups : public LatticeSceneTest {
 protected:
  void SetUp() override {
    LatticeSceneTest::SetUp();
    if (IsSkipped() || HasFatalFailure() || backend_ == nullptr) return;
    if (GetParam().pipeline == Pipeline::kFused) GTEST_SKIP() << "fused does not take them";
  }
};

// With falloffs, strengths and weights.
TEST_P(SumsOfGroups, TurnedSumsMatchDefinition) {
  const PolygonMesh mesh = TorusMesh(6, 4);
  const VertexWeights weights = RandomWeights(mesh, kLatticesSeed);
  for (int mix = 0; mix < 27; mix += 4) {
    SCOPED_TRACE(fmt::format("mix {}", mix));
    const LatticeScene scene =
        MakeLatticeScene(mesh, TwoGroups(mix), mix % 8 == 0 ? weights : nullptr);
    ASSERT_NE(scene.plan, nullptr);
    ASSERT_EQ(scene.plan->turned.size(), 1u);
    ASSERT_NO_FATAL_FAILURE(ExpectAsDefined(scene, mix / 4));
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, SumsOfGroups, ::testing::ValuesIn(Subjects()), SubjectName);

}  // namespace
}  // namespace latticed::testing
