// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Surfaces under lattices that are turned against each other, with and without vertex weights, and the definition of det J on
// them.
#ifndef LATTICED_TESTS_CORE_FOLDS_TURNED_FOLD_FIXTURES_H_
#define LATTICED_TESTS_CORE_FOLDS_TURNED_FOLD_FIXTURES_H_

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/folds/fold_certifier.h"
#include "core/folds/turned_determinant.h"
#include "tests/core/folds/fold_fixtures.h"

namespace latticed::testing {

struct TurnedFolds {
  std::shared_ptr<const DeformPlan> plan;
  std::vector<LatticeStructure> structures;
};

enum class Weights { kNone, kScattered };

// Of the vertices: about a third are 0 and a third are 1.
inline VertexWeights ScatteredWeights(const PolygonMesh& mesh, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 2);
  std::vector<float> weights(mesh.positions.size());
  for (float& w : weights) w = std::clamp(uniform(random), 0.0f, 1.0f);
  return std::make_shared<const std::vector<float>>(std::move(weights));
}

inline TurnedFolds PlanTurned(PolygonMesh mesh, std::span<const LatticeOptions> lattices,
                              VertexWeights weights = nullptr) {
  TurnedFolds result;
  for (const LatticeOptions& options : lattices) {
    result.structures.push_back(MakeStructure(mesh.ComputeBounds(), options));
  }
  auto plan = MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), result.structures[0],
                       {}, NeverStop, std::move(weights), std::span(result.structures).subspan(1));
  EXPECT_TRUE(plan.ok());
  if (plan.ok()) result.plan = *plan;
  return result;
}

// Control points of all lattices, moved by up to `amount` of their distances or so.
inline std::vector<Vec3d> JitterAll(const TurnedFolds& scene, double amount, uint32_t seed) {
  std::vector<Vec3d> points;
  for (const LatticeStructure& s : scene.structures) {
    const auto own = Jitter(s, amount, seed++);
    points.insert(points.end(), own.begin(), own.end());
  }
  return points;
}

// Two or three lattices about a torus, with degrees from `mix` = 0 … 26. Parts of the torus lie outside of each of them.
inline TurnedFolds DrawTurned(uint32_t mix, bool three, Weights weights = Weights::kNone) {
  const std::array<int, 3> degree{1 + static_cast<int>(mix % 3), 1 + static_cast<int>(mix / 3 % 3),
                                  1 + static_cast<int>(mix / 9)};
  std::vector<LatticeOptions> lattices{
      {.degree = degree, .extra = {2, 1, 1}, .shear = 0.2, .mirrored = true, .scale = 0.8},
      {.degree = {degree[2], 2, degree[0]},
       .extra = {1, 2, 1},
       .knots = KnotKind::kNonUniform,
       .scale = 0.9,
       .turn = 0.5,
       .shift = {0.2, 0.1, 0}}};
  if (three) lattices.push_back({.degree = {3, 1, 2}, .scale = 0.5, .turn = -1, .shift = {0.4}});
  const PolygonMesh mesh = TorusMesh(9, 6);
  return PlanTurned(mesh, lattices,
                    weights == Weights::kNone ? nullptr : ScatteredWeights(mesh, mix));
}

inline double SumDeterminantAt(const DirectFfd& definition, size_t patch,
                               const std::array<double, 3>& at) {
  const auto j = definition.EvaluatePosition(patch, at).jacobian;
  return Dot(j[0], Cross(j[1], j[2]));
}

inline FoldReport ReportOfTurned(const std::shared_ptr<const DeformPlan>& plan,
                                 std::span<const Vec3d> points) {
  auto report = FoldCertifier(plan, FoldScope::kSurface).Certify(points);
  EXPECT_TRUE(report.ok());
  return *std::move(report);
}

// The least det J at (steps + 1) (steps + 2) / 2 points of the patch, corners and edges included.
inline double LeastOnPatch(const DirectFfd& definition, size_t patch, int steps) {
  double least = 1e300;
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; i + j <= steps; ++j) {
      const double a = double(i) / steps, b = double(j) / steps;
      least = std::min(least, SumDeterminantAt(definition, patch, {1 - a - b, a, b}));
    }
  }
  return least;
}

// At a random point of every patch, det J of `patches` is the definition's, to within its slack, which is below `most_slack`.
inline void ExpectDeterminantsOfTheDefinition(const DeformPlan& plan, std::span<const Vec3d> points,
                                              TurnedPatches& patches, double most_slack,
                                              std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  const DirectFfd definition(plan, points);
  BernsteinTriangle determinant;
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    const double slack = patches.MakeDeterminant(p, determinant);
    ASSERT_LT(slack, most_slack);
    const double x = uniform(random), y = uniform(random) * (1 - x);
    const std::array<double, 3> at{1 - x - y, x, y};
    ASSERT_NEAR(determinant.Value(at), SumDeterminantAt(definition, p, at), slack + 1e-11)
        << "patch " << p;
  }
}

// LATTICED_TURNED_SCENES and LATTICED_FOLD_SAMPLES set how many there are, and the samples along a patch's edge.
inline uint32_t TurnedSetting(const char* name, uint32_t usual) {
  const char* const text = std::getenv(name);
  return text == nullptr ? usual : static_cast<uint32_t>(std::stoul(text));
}

// No box is certified where a sample of one of its patches is folded. `amount`: of moves.
inline void ExpectReportsThatAgreeWithSamples(Weights weights, double amount = 0.03) {
  const uint32_t count = TurnedSetting("LATTICED_TURNED_SCENES", 54);
  const int steps = static_cast<int>(TurnedSetting("LATTICED_FOLD_SAMPLES", 8));
  uint64_t folded = 0, certified = 0, undecided = 0, outside = 0;
  for (uint32_t seed = 0; seed < count; ++seed) {
    SCOPED_TRACE(seed);
    const TurnedFolds scene = DrawTurned(seed % 27, seed / 27 % 2 == 0, weights);
    const DeformPlan& plan = *scene.plan;
    // From lattices that hardly ever fold to lattices that nearly always do.
    const auto points = JitterAll(scene, amount * (1 + seed % 8), 3 * seed);
    const DirectFfd definition(plan, points);

    const FoldReport report = ReportOfTurned(scene.plan, points);

    folded += report.Count(FoldState::kFolded);
    undecided += report.Count(FoldState::kUndecided);
    certified += report.boxes - report.places.size();
    for (size_t p = 0; p < plan.patches.size(); ++p) {
      if (report.StateOf(plan.patches[p].box) != FoldState::kCertified) continue;
      outside += plan.patches[p].box == plan.outside_box() ? 1u : 0u;
      ASSERT_GT(LeastOnPatch(definition, p, steps), 0) << "patch " << p;
    }
    for (const FoldedBox& place : report.places) {
      if (place.state == FoldState::kFolded) {
        EXPECT_LE(place.determinant, 0);
      }
    }
  }
  std::cout << count << " scenes: " << certified << " boxes certified, " << folded << " folded, "
            << undecided << " undecided; " << outside << " certified patches outside\n";
  EXPECT_GT(folded, 2 * count);
  EXPECT_GT(certified, 2 * count);
  EXPECT_GT(outside, count);
  EXPECT_LE(undecided, (folded + certified) / 1000);
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CORE_FOLDS_TURNED_FOLD_FIXTURES_H_
