// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points that patches share have the same bits in all of them, and a point has the same bits alone as among others.
#include "tests/client/patches/shared_bits.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <iostream>
#include <random>

#include "client/cpp/library/patches/point_block.h"
#include "tests/support/instruction_sets.h"

namespace latticed::client {
namespace {

using testing::PatchScene;
using testing::SharedCount;

SharedCount CountShared(const PatchScene& scene) {
  const PatchSurface surface =
      testing::EvaluateScene(scene, testing::kSceneTolerance * scene.size());
  const SharedCount count = testing::SharedPointsCheck(scene, surface).Count();
  EXPECT_EQ(count.different, 0u) << "of " << count.points;
  return count;
}

// Every third scene is torn everywhere, every third in a few places, every third nowhere.
TEST(PatchEvaluator, PointsThatPatchesShareHaveTheSameBits) {
  SharedCount all;
  for (uint32_t seed = 0; seed < testing::kRandomPatchScenes; ++seed) {
    SCOPED_TRACE(seed);
    PatchScene scene = testing::DrawPatchScene(seed, 0.4, RestNormals::kNone);
    const std::vector<Vec3d>& rest = scene.plan->identity_points;
    for (size_t i = 0; i < rest.size(); ++i) {
      if (seed % 3 == 1 && i % 8 != 0) scene.control_points[i] = rest[i];
      if (seed % 3 == 2) scene.control_points[i] = rest[i];
    }

    const SharedCount here = CountShared(scene);
    all.points += here.points;
    all.across_boxes += here.across_boxes;
    all.across_seams += here.across_seams;
  }
  EXPECT_GT(all.points, 100'000u);
  EXPECT_GT(all.across_boxes, 10'000u);
  EXPECT_GT(all.across_seams, 1'000u);
  std::cout << all.points << " shared, " << all.across_boxes << " across boxes, "
            << all.across_seams << " across attached seams\n";
}

// Seams of vertices of weight 0 are attached, though their control points have moved.
TEST(PatchEvaluator, SeamsThatRestHaveTheSameBits) {
  SharedCount all;
  for (uint32_t seed = 0; seed < testing::kRandomPatchScenes; ++seed) {
    SCOPED_TRACE(seed);
    const testing::RandomCase drawn = testing::DrawCase(seed);
    const LatticeStructure structure =
        testing::MakeStructure(drawn.mesh.ComputeBounds(), drawn.options);
    std::mt19937 random(seed);
    std::vector<float> weights(drawn.mesh.positions.size());
    for (float& w : weights) w = random() % 4 == 0 ? 0.5f : 0;
    const PatchScene scene = testing::MakePatchScene(
        drawn.mesh, structure, testing::Jitter(structure, 0.4, seed), RestNormals::kNone,
        std::make_shared<const std::vector<float>>(std::move(weights)));

    const SharedCount here = CountShared(scene);
    all.across_seams += here.across_seams;
  }
  EXPECT_GT(all.across_seams, 300u);
}

void ExpectSameAloneAsInBlocks(bool weighted) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (int degree = 0; degree < 27; ++degree) {
    const std::array<int, 3> degrees{1 + degree % 3, 1 + degree / 3 % 3, 1 + degree / 9};
    std::vector<float> coefficients(3 * 64), conormals(9);
    for (float& c : coefficients) c = uniform(random);
    for (float& c : conormals) c = uniform(random);
    std::vector<float> at_rest(12);
    for (float& c : at_rest) c = uniform(random);
    const BoxPolynomial box{degrees, coefficients.data(), conormals.data(),
                            weighted ? at_rest.data() : nullptr};
    PointBlock<kBlockPoints> block{};
    for (size_t i = 0; i < kBlockPoints; ++i) {
      for (size_t a = 0; a < 3; ++a) {
        block.local[a][i] = uniform(random) / 2;
        block.rest[a][i] = i == 3 ? 0 : uniform(random);
        block.slope[a][i] = uniform(random);
      }
      block.weight[i] = std::abs(uniform(random));
    }

    EvaluateBlock(box, true, &block);

    for (size_t i = 0; i < kBlockPoints; ++i) {
      PointBlock<1> with{}, without{};
      for (size_t a = 0; a < 3; ++a) {
        with.local[a][0] = without.local[a][0] = block.local[a][i];
        with.rest[a][0] = block.rest[a][i];
        with.slope[a][0] = block.slope[a][i];
      }
      with.weight[0] = without.weight[0] = block.weight[i];
      EvaluateBlock(box, true, &with);
      EvaluateBlock(box, false, &without);
      for (size_t a = 0; a < 3; ++a) {
        const auto bits = [](float x) { return std::bit_cast<uint32_t>(x); };
        EXPECT_EQ(bits(with.position[a][0]), bits(block.position[a][i]));
        EXPECT_EQ(bits(without.position[a][0]), bits(block.position[a][i]));
        EXPECT_EQ(bits(with.normal[a][0]), bits(block.normal[a][i]));
      }
    }
  }
}

// Under each instruction set of this machine.
TEST(PatchEvaluator, EvaluatesPointsAloneAsInBlocks) {
  for (const int64_t target : testing::Targets()) {
    const testing::ChosenTarget chosen(target);
    SCOPED_TRACE(hwy::TargetName(target));
    for (const bool weighted : {false, true}) ExpectSameAloneAsInBlocks(weighted);
  }
}

}  // namespace
}  // namespace latticed::client
