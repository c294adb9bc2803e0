// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Sums of a patch's points under each instruction set of this machine, against the definition one point at a time.
#include "core/cpu/gemm/patch_sums.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "core/ffd/direct_ffd.h"
#include "core/points/point_blocks.h"
#include "fmt/format.h"
#include "tests/backend/turned_scenes.h"
#include "tests/support/instruction_sets.h"

namespace latticed::testing {
namespace {

constexpr std::array kWorldAxes{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
constexpr double kLargestError = 1e-12;  // of a torus of radius 1.4

// Random places in a patch, a corner among them.
patch_sums::Places RandomPlaces(size_t count, std::mt19937& random) {
  patch_sums::Places places{.barycentrics = {}, .count = count};
  std::uniform_real_distribution<double> any(0, 1);
  for (size_t i = 1; i < count; ++i) {
    const double a = any(random), b = any(random) * (1 - a);
    points::Set(places.barycentrics, i, {a, b, 1 - a - b});
  }
  points::Set(places.barycentrics, 0, {1, 0, 0});
  return places;
}

// The largest error of positions and of derivatives in all patches.
double LargestError(const MovedPlan& scene, std::mt19937& random) {
  const PatchSums sums(*scene.plan, scene.points);
  const DirectFfd direct(*scene.plan, scene.points);
  double largest = 0;
  patch_sums::Values values;
  for (size_t p = 0; p < scene.plan->patches.size(); ++p) {
    const patch_sums::Places places = RandomPlaces(1 + p % 19, random);
    sums.Evaluate(p, places, kWorldAxes, values);
    for (size_t i = 0; i < places.count; ++i) {
      const Vec3d b = points::At(places.barycentrics, i);
      const DeformedPoint exact = direct.EvaluatePosition(p, {b.x, b.y, b.z});
      const Vec3d position = points::At(values.position, i) + scene.plan->local_origin;
      largest = std::max(largest, Norm(position - exact.position));
      for (size_t k = 0; k < 3; ++k) {
        largest = std::max(largest, Norm(points::At(values.along[k], i) - exact.jacobian[k]));
      }
    }
  }
  return largest;
}

TEST(PatchSums, EveryInstructionSetMatchesTheDefinition) {
  std::mt19937 random(kTurnedSeed);
  for (const int64_t target : Targets()) {
    const ChosenTarget chosen(target);
    for (const std::array<int, 3> degree : {std::array{1, 1, 1}, {2, 2, 2}, {1, 3, 2}, {3, 3, 3}}) {
      for (const bool weighted : {false, true}) {
        SCOPED_TRACE(fmt::format("target {}, degree {} {} {}, {}", target, degree[0], degree[1],
                                 degree[2], weighted ? "weights" : "no weights"));
        const PolygonMesh mesh = TorusMesh(9, 7);
        const LatticeOptions own{.degree = degree, .scale = 0.9};  // pieces lie outside
        const LatticeOptions turned{.degree = {2, 1, 3}, .shear = 0.1, .turn = 0.7};
        const std::array lattices{MovedLattice{own}, MovedLattice{turned}};
        const MovedPlan scene =
            MakeMovedPlan(mesh, lattices, weighted ? RandomWeights(mesh, kTurnedSeed) : nullptr);
        EXPECT_LE(LargestError(scene, random), kLargestError) << "seed " << kTurnedSeed;
      }
    }
  }
}

}  // namespace
}  // namespace latticed::testing
