// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Folds of surfaces with vertex weights, against the definition of J on them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/folds/fold_certifier.h"
#include "core/folds/weighted_determinant.h"
#include "tests/core/folds/fold_fixtures.h"

namespace latticed {
namespace {

constexpr uint32_t kWeightedFoldSeed = 65;

using testing::FlatGrid;
using testing::TorusMesh;
using WeightedPlan = std::shared_ptr<const DeformPlan>;

WeightedPlan PlanWith(const PolygonMesh& mesh, const testing::LatticeOptions& options,
                      std::vector<float> weights) {
  return *MakePlan(std::make_shared<const PolygonMesh>(mesh),
                   testing::MakeStructure(mesh.ComputeBounds(), options), {}, NeverStop,
                   std::make_shared<const std::vector<float>>(std::move(weights)));
}

// About a third are 0 and a third are 1.
WeightedPlan ScatteredTorus(const std::array<int, 3>& degree) {
  const PolygonMesh mesh = TorusMesh(9, 6);
  std::mt19937 random(kWeightedFoldSeed);
  std::uniform_real_distribution<float> uniform(-1, 2);
  std::vector<float> weights(mesh.positions.size());
  for (float& w : weights) w = std::clamp(uniform(random), 0.0f, 1.0f);
  return PlanWith(mesh, {.degree = degree, .extra = {2, 1, 1}, .shear = 0.2, .mirrored = true},
                  std::move(weights));
}

// A flat grid on which the weight rises from 0 to 1 along x.
WeightedPlan RampPlan() {
  const PolygonMesh mesh = FlatGrid(4, 0);
  const Bounds bounds = mesh.ComputeBounds();
  std::vector<float> weights;
  for (const Vec3d p : mesh.positions) {
    weights.push_back(static_cast<float>((p.x - bounds.min.x) / bounds.extent().x));
  }
  return PlanWith(mesh, {}, std::move(weights));
}

std::vector<Vec3d> Moved(std::vector<Vec3d> points, Vec3d by) {
  for (Vec3d& p : points) p += by;
  return points;
}
std::vector<Vec3d> Shifted(const DeformPlan& plan, Vec3d by) {
  return Moved(plan.identity_points, by);
}

// Of multiples of 2^-20, so that moves by multiples of that are exact.
std::vector<Vec3d> JitterOnGrid(const DeformPlan& plan, double amount, uint32_t seed) {
  std::vector<Vec3d> points = testing::Jitter(plan.structure, amount, seed);
  for (Vec3d& p : points) {
    for (int a = 0; a < 3; ++a) p[a] = std::round(p[a] * 0x1p20) * 0x1p-20;
  }
  return points;
}

std::vector<Vec3d> OffsetsOf(const DeformPlan& plan, std::span<const Vec3d> points) {
  std::vector<Vec3d> offsets(points.begin(), points.end());
  for (size_t i = 0; i < points.size(); ++i) offsets[i] -= plan.identity_points[i];
  return offsets;
}

double DeterminantAt(const DirectFfd& definition, size_t patch, const std::array<double, 3>& at) {
  const auto j = definition.EvaluatePosition(patch, at).jacobian;
  return Dot(j[0], Cross(j[1], j[2]));
}

FoldReport ReportOf(const WeightedPlan& plan, std::span<const Vec3d> points) {
  auto report = FoldCertifier(plan, FoldScope::kSurface).Certify(points);
  EXPECT_TRUE(report.ok());
  return *std::move(report);
}

TEST(WeightedDeterminant, IsTheDefinitionsOnEveryPatch) {
  std::mt19937 random(kWeightedFoldSeed);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int mix = 0; mix < 27; ++mix) {
    SCOPED_TRACE(::testing::Message() << "mix " << mix << ", seed " << kWeightedFoldSeed);
    const auto plan = ScatteredTorus({1 + mix % 3, 1 + mix / 3 % 3, 1 + mix / 9});
    const auto points = testing::Jitter(plan->structure, 0.4, kWeightedFoldSeed);
    const std::vector<Vec3d> offsets = OffsetsOf(*plan, points);
    const DirectFfd definition(*plan, points);
    BernsteinTriangle determinant;
    for (uint32_t box = 0; box < plan->outside_box(); ++box) {
      WeightedBox weighted(*plan, box, points, offsets);
      for (uint32_t p = plan->box_patches[box]; p < plan->box_patches[box + 1]; ++p) {
        const double slack = weighted.MakeDeterminant(p, determinant);
        ASSERT_LT(slack, 1e-8);
        const double x = uniform(random), y = uniform(random) * (1 - x);
        const std::array<double, 3> at{1 - x - y, x, y};
        ASSERT_NEAR(determinant.Value(at), DeterminantAt(definition, p, at), 10 * slack + 1e-11)
            << "patch " << p;
      }
    }
  }
}

// With the same weight everywhere, det J depends on differences of control points alone.
TEST(WeightedDeterminant, StaysWithinItsSlackWhereTheLatticeIsMovedFar) {
  const PolygonMesh mesh = TorusMesh(9, 6);
  BernsteinTriangle here, there;
  for (int mix = 0; mix < 27; ++mix) {
    const std::array<int, 3> degree{1 + mix % 3, 1 + mix / 3 % 3, 1 + mix / 9};
    const auto plan = PlanWith(mesh, {.degree = degree, .extra = {2, 1, 1}, .shear = 0.2},
                               std::vector<float>(mesh.positions.size(), mix % 2 == 0 ? 1 : 0.5f));
    const auto points = JitterOnGrid(*plan, 0.4, kWeightedFoldSeed);
    for (const double shift : {0x1p14, 0x1p17, 0x1p24}) {
      SCOPED_TRACE(::testing::Message()
                   << "mix " << mix << ", shift " << shift << ", seed " << kWeightedFoldSeed);
      const auto moved = Moved(points, {shift, -shift, 0.75 * shift});
      const auto offsets = OffsetsOf(*plan, points), moved_offsets = OffsetsOf(*plan, moved);
      for (uint32_t box = 0; box < plan->outside_box(); ++box) {
        WeightedBox near(*plan, box, points, offsets), far(*plan, box, moved, moved_offsets);
        for (uint32_t p = plan->box_patches[box]; p < plan->box_patches[box + 1]; ++p) {
          const double slack = near.MakeDeterminant(p, here) + far.MakeDeterminant(p, there);
          ASSERT_LT(slack, 1e-8);
          for (size_t i = 0; i <= here.degree; ++i) {
            for (size_t j = 0; i + j <= here.degree; ++j) {
              ASSERT_NEAR(there.at(i, j), here.at(i, j), slack) << "patch " << p;
            }
          }
        }
      }
    }
  }
}

TEST(WeightedFolds, ALatticeThatIsMovedFarHasTheSameFolds) {
  const PolygonMesh mesh = TorusMesh(9, 6);
  const auto plan = PlanWith(mesh, {.degree = {2, 1, 3}, .extra = {2, 1, 1}},
                             std::vector<float>(mesh.positions.size(), 1));
  uint64_t folded = 0, certified = 0;
  for (uint32_t seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(seed);
    const auto points = JitterOnGrid(*plan, 0.15 * seed, seed);

    const FoldReport here = ReportOf(plan, points);
    const FoldReport there = ReportOf(plan, Moved(points, {0x1p24, -0x1p24, 0x1p23}));

    for (uint32_t box = 0; box < plan->outside_box(); ++box) {
      EXPECT_EQ(there.StateOf(box), here.StateOf(box)) << "box " << box;
    }
    folded += here.Count(FoldState::kFolded);
    certified += here.boxes - here.places.size();
  }
  EXPECT_GT(folded, 5u);
  EXPECT_GT(certified, 5u);
}

// Layers that are nearly flat and in the reverse order, so far away that offsets from rest do not tell them apart.
TEST(WeightedFolds, AFoldFarAwayIsSeen) {
  constexpr double kStep = 0x1p-30;
  const PolygonMesh mesh = TorusMesh(9, 6);
  for (int mix = 0; mix < 27; ++mix) {
    const std::array<int, 3> degree{1 + mix % 3, 1 + mix / 3 % 3, 1 + mix / 9};
    const auto plan = PlanWith(mesh, {.degree = degree, .extra = {2, 1, 1}},
                               std::vector<float>(mesh.positions.size(), 1));
    std::vector<Vec3d> points = plan->identity_points;
    const size_t layer = static_cast<size_t>(plan->structure.Index(0, 0, 1));
    for (size_t i = 0; i < points.size(); ++i) {
      points[i].z = 0x1p23 - static_cast<double>(1 + i / layer) * kStep;
    }

    const FoldReport report = ReportOf(plan, points);

    EXPECT_EQ(report.Count(FoldState::kFolded), report.boxes) << "mix " << mix;
  }
}

TEST(WeightedFolds, ARampFoldsWhereItsSlopeIsMinusOne) {
  const auto plan = RampPlan();
  const double width = plan->mesh_bounds.extent().x;

  EXPECT_TRUE(ReportOf(plan, plan->identity_points).certified());
  EXPECT_TRUE(ReportOf(plan, Shifted(*plan, {-0.999 * width, 0.3, 0.7})).certified());
  const FoldReport folded = ReportOf(plan, Shifted(*plan, {-1.25 * width, 0, 0}));

  EXPECT_EQ(folded.Count(FoldState::kFolded), folded.boxes);
  for (const FoldedBox& box : folded.places) EXPECT_NEAR(box.determinant, -0.25, 1e-6);
}

TEST(WeightedFolds, WhatRestsDoesNotFold) {
  const PolygonMesh mesh = TorusMesh(9, 6);
  const auto plan = PlanWith(mesh, {}, std::vector<float>(mesh.positions.size(), 0));
  std::vector<Vec3d> points = plan->identity_points;
  for (Vec3d& p : points) p.z = -p.z;

  EXPECT_TRUE(ReportOf(plan, points).certified());
}

// Reports of lattices that fold, do not fold, and nearly do, against samples.
TEST(WeightedFolds, ReportsAgreeWithSamplesOfTheDefinition) {
  constexpr int kSteps = 8;
  uint64_t folded = 0, certified = 0, undecided = 0;
  for (uint32_t seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE(seed);
    const auto plan =
        ScatteredTorus({1 + static_cast<int>(seed % 3), 2, 1 + static_cast<int>(seed / 3 % 3)});
    const auto points = testing::Jitter(plan->structure, 0.08 * (1 + seed % 8), seed);
    const DirectFfd definition(*plan, points);

    const FoldReport report = ReportOf(plan, points);

    folded += report.Count(FoldState::kFolded);
    undecided += report.Count(FoldState::kUndecided);
    certified += report.boxes - report.places.size();
    for (uint32_t box = 0; box < plan->outside_box(); ++box) {
      if (report.StateOf(box) != FoldState::kCertified) continue;
      for (uint32_t p = plan->box_patches[box]; p < plan->box_patches[box + 1]; ++p) {
        for (int i = 0; i <= kSteps; ++i) {
          for (int j = 0; i + j <= kSteps; ++j) {
            const double a = double(i) / kSteps, b = double(j) / kSteps;
            ASSERT_GT(DeterminantAt(definition, p, {1 - a - b, a, b}), 0) << "patch " << p;
          }
        }
      }
    }
    for (const FoldedBox& place : report.places) {
      if (place.state == FoldState::kFolded) {
        EXPECT_LE(place.determinant, 0);
      }
    }
  }
  EXPECT_GT(folded, 20u);
  EXPECT_GT(certified, 20u);
  EXPECT_LE(undecided, (folded + certified) / 1000);
}

// The witness of a fold is on a patch of its box, and folded by the definition.
TEST(WeightedFolds, AWitnessIsFolded) {
  const auto plan = ScatteredTorus({2, 2, 2});
  const auto points = testing::Jitter(plan->structure, 0.7, kWeightedFoldSeed);
  const DirectFfd definition(*plan, points);
  const FoldReport report = ReportOf(plan, points);
  ASSERT_GT(report.Count(FoldState::kFolded), 0u);
  for (const FoldedBox& place : report.places) {
    double nearest = 1;
    for (uint32_t p = plan->box_patches[place.box]; p < plan->box_patches[place.box + 1]; ++p) {
      const auto corner = [&](size_t c) {
        return plan->vertices[plan->patches[p].vertex[c]].world;
      };
      const Vec3d s = corner(1) - corner(0), t = corner(2) - corner(0);
      const Vec3d normal = Cross(s, t), to = place.rest_point - corner(0);
      const double area2 = Dot(normal, normal);
      if (!(area2 > 0)) continue;
      const double b1 = Dot(Cross(to, t), normal) / area2, b2 = Dot(Cross(s, to), normal) / area2;
      const double off = std::abs(Dot(to, normal)) / area2;
      if (b1 < -1e-9 || b2 < -1e-9 || b1 + b2 > 1 + 1e-9 || off > 1e-9) continue;
      const double value = DeterminantAt(definition, p, {1 - b1 - b2, b1, b2});
      nearest = std::min(nearest, std::abs(value - place.determinant));
    }
    EXPECT_LE(nearest, 1e-7) << "box " << place.box;
  }
}

TEST(WeightedFolds, RecertifyLeadsToTheSameReport) {
  const auto plan = ScatteredTorus({2, 1, 3});
  const FoldCertifier certifier(plan, FoldScope::kSurface);
  std::vector<Vec3d> points = plan->identity_points;
  FoldReport report = *certifier.Certify(points);
  std::mt19937 random(kWeightedFoldSeed);
  std::uniform_real_distribution<double> uniform(-1.5, 1.5);
  for (int edit = 0; edit < 20; ++edit) {
    const auto index = static_cast<uint32_t>(random() % points.size());
    points[index] += Vec3d{uniform(random), uniform(random), uniform(random)};
    report = certifier.Recertify(report, {{index}}, points);
    ASSERT_EQ(report, *certifier.Certify(points));
  }
  EXPECT_FALSE(report.certified());
}

}  // namespace
}  // namespace latticed
