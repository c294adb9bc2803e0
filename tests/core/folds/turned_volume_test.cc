// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Folds of the volume under lattices that are turned against each other, against dense samples of the definition.
// LATTICED_TURNED_VOLUMES and LATTICED_FOLD_SAMPLES set the number of scenes, and of samples per box and axis.
#include "core/folds/turned_volume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <random>

#include "core/folds/fold_certifier.h"
#include "tests/core/folds/turned_fold_fixtures.h"

namespace latticed {
namespace {

constexpr uint32_t kVolumeSeed = 71;

using testing::DrawTurned;
using testing::JitterAll;
using testing::LatticeOptions;
using testing::PlanTurned;
using testing::TorusMesh;
using testing::TurnedFolds;
using testing::TurnedSetting;

FoldReport VolumeReport(const std::shared_ptr<const DeformPlan>& plan,
                        std::span<const Vec3d> points) {
  auto report = FoldCertifier(plan, FoldScope::kVolume).Certify(points);
  EXPECT_TRUE(report.ok());
  return *std::move(report);
}

double WorldDeterminant(const DeformPlan& plan, std::span<const Vec3d> points, Vec3d world) {
  const auto j = EvaluateWorld(plan, points, world).jacobian;
  return Dot(j[0], Cross(j[1], j[2]));
}

// The least det J at about n^3 points of a knot box, and of those outside the plan's own frame where it is of a turned lattice.
double LeastInBox(const TurnedFolds& scene, std::span<const Vec3d> points, size_t lattice,
                  Vec3d lower, Vec3d upper, uint32_t n) {
  const FrameMap map(scene.structures[lattice]);
  double least = 1e300;
  for (uint32_t i = 0; i < n * n * n; ++i) {
    constexpr double kInside = 1e-6;  // of the box, where its neighbours are not
    const auto at = [&](uint32_t place, int axis) {
      const double l = kInside + (1 - 2 * kInside) * place / (n - 1);
      return lower[axis] + l * (upper[axis] - lower[axis]);
    };
    const Vec3d world = map.ToWorld({at(i % n, 0), at(i / n % n, 1), at(i / n / n, 2)});
    if (lattice > 0 && FindVolumePlace(scene.plan->structure, world).has_value()) continue;
    least = std::min(least, WorldDeterminant(*scene.plan, points, world));
  }
  return least;
}

// The same of all that turned lattices reach outside.
double LeastOutside(const TurnedFolds& scene, std::span<const Vec3d> points, uint32_t n) {
  double least = 1e300;
  for (size_t g = 1; g < scene.structures.size(); ++g) {
    const LatticeStructure& s = scene.structures[g];
    const Vec3d lower{s.domain_begin(0), s.domain_begin(1), s.domain_begin(2)};
    const Vec3d upper{s.domain_end(0), s.domain_end(1), s.domain_end(2)};
    least = std::min(least, LeastInBox(scene, points, g, lower, upper, n));
  }
  return least;
}

TEST(TurnedVolume, NoCertificateIsWrongAndNearlyAllBoxesAreDecided) {
  const uint32_t count = TurnedSetting("LATTICED_TURNED_VOLUMES", 54);
  const uint32_t samples = TurnedSetting("LATTICED_FOLD_SAMPLES", 8);
  uint64_t certified = 0, folded = 0, undecided = 0, outside_certified = 0, outside_folded = 0;
  uint64_t missed = 0, cells = 0, searched = 0;
  int most_cells = 0;
  for (uint32_t seed = 0; seed < count; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    const TurnedFolds scene = DrawTurned(seed % 27, seed / 27 % 2 == 0);
    const DeformPlan& plan = *scene.plan;
    // From lattices that hardly ever fold to lattices that nearly always do.
    const auto points = JitterAll(scene, 0.03 * (1 + seed % 8), 3 * seed);

    const FoldReport report = VolumeReport(scene.plan, points);

    ASSERT_EQ(report.boxes, plan.boxes.size());
    certified += report.boxes - report.places.size();
    folded += report.Count(FoldState::kFolded);
    undecided += report.Count(FoldState::kUndecided);
    TurnedVolume volume(plan, points);
    for (uint32_t box = 0; box < plan.boxes.size(); ++box) {
      const bool is_outside = box == plan.outside_box();
      const double least = is_outside ? LeastOutside(scene, points, 4 * samples)
                                      : LeastInBox(scene, points, 0, plan.boxes[box].lower,
                                                   plan.boxes[box].upper, samples);
      const FoldState state = report.StateOf(box);
      if (!is_outside) {
        const int looked_at = volume.DecideBox(box).cells;
        searched += looked_at > 0 ? 1u : 0u;
        cells += static_cast<uint64_t>(looked_at);
        most_cells = std::max(most_cells, looked_at);
      } else {
        (state == FoldState::kCertified ? outside_certified : outside_folded) += 1;
      }
      if (state == FoldState::kCertified) {
        EXPECT_GT(least, 0) << "box " << box;
      }
      missed += state == FoldState::kFolded && least > 0 ? 1u : 0u;
    }
    for (const FoldedBox& place : report.places) {
      EXPECT_EQ(WorldDeterminant(plan, points, place.rest_point), place.determinant);
      EXPECT_EQ(place.state == FoldState::kFolded, place.determinant <= 0);
    }
  }
  std::cout << count << " scenes: " << certified << " boxes certified, " << folded << " folded, "
            << undecided << " undecided; outside " << outside_certified << " certified, "
            << outside_folded << " folded; " << missed << " folded where all samples are above 0; "
            << searched << " were not near rest, with " << double(cells) / double(searched)
            << " cells, at most " << most_cells << "\n";
  EXPECT_LE(static_cast<double>(undecided), 1e-3 * static_cast<double>(certified + folded));
}

// Both contain all of the mesh.
TurnedFolds TwoAroundAll(double turn = 0.7) {
  return PlanTurned(TorusMesh(9, 6),
                    std::vector<LatticeOptions>{{.scale = 1.2}, {.scale = 2.5, .turn = turn}});
}

// Their displacements are those of linear maps: d0 and d1 times x, along x.
std::vector<Vec3d> Stretched(const TurnedFolds& scene, double d0, double d1) {
  std::vector<Vec3d> points = scene.plan->identity_points;
  const auto own = static_cast<size_t>(scene.structures[0].control_point_count());
  for (size_t i = 0; i < points.size(); ++i) points[i].x += (i < own ? d0 : d1) * points[i].x;
  return points;
}

TEST(TurnedVolume, TheIdentityIsCertified) {
  for (uint32_t mix = 0; mix < 27; ++mix) {
    const TurnedFolds scene = DrawTurned(mix, mix % 2 == 0);
    EXPECT_EQ(VolumeReport(scene.plan, scene.plan->identity_points),
              FoldReport{.boxes = scene.plan->boxes.size()});
  }
}

TEST(TurnedVolume, LinearMapsAddUp) {
  const TurnedFolds scene = TwoAroundAll();
  const FoldReport none{.boxes = scene.plan->boxes.size()};
  for (const auto& [d0, d1] : {std::pair{-0.6, -0.3}, {-0.9, 0.8}, {3.0, -0.9}}) {
    EXPECT_EQ(VolumeReport(scene.plan, Stretched(scene, d0, d1)), none) << d0 << " " << d1;
  }
  // Inside both it folds, and outside the first one it does not.
  const FoldReport report = VolumeReport(scene.plan, Stretched(scene, -0.6, -0.6));
  EXPECT_EQ(report.Count(FoldState::kFolded), scene.plan->outside_box());
  EXPECT_EQ(report.StateOf(scene.plan->outside_box()), FoldState::kCertified);
  for (const FoldedBox& place : report.places) EXPECT_NEAR(place.determinant, -0.2, 1e-11);
}

// The turned one turns its inside by half a turn: det J is 1 there and outside. The mean of both would be flat.
TEST(TurnedVolume, AStepOfTheJacobianIsNoFold) {
  const TurnedFolds scene = PlanTurned(
      TorusMesh(9, 6),
      std::vector<LatticeOptions>{{.scale = 1.2}, {.scale = 0.5, .turn = 0.7, .shift = {0.1}}});
  std::vector<Vec3d> points = scene.plan->identity_points;
  const size_t own = scene.plan->turned[0].first_point;
  for (size_t i = own; i < points.size(); ++i) {
    points[i].x *= -1;
    points[i].y *= -1;
  }
  EXPECT_EQ(VolumeReport(scene.plan, points), FoldReport{.boxes = scene.plan->boxes.size() - 1});
}

TEST(TurnedVolume, AFlattenedSumIsNotCertified) {
  const TurnedFolds scene = TwoAroundAll();
  const FoldReport report = VolumeReport(scene.plan, Stretched(scene, -0.25, -0.75));
  EXPECT_EQ(report.places.size(), scene.plan->outside_box());
}

TEST(TurnedVolume, NumbersThatOverflowProveNothing) {
  const TurnedFolds scene = TwoAroundAll();
  std::vector<Vec3d> points = scene.plan->identity_points;
  for (Vec3d& p : points) p.x *= 1e308;
  const FoldReport report = VolumeReport(scene.plan, points);
  EXPECT_EQ(report.places.size(), report.boxes);
}

// The boxes are those of a plan without the turned lattice, and so is the report where it is at rest.
TEST(TurnedVolume, ALatticeAtRestChangesNothing) {
  const TurnedFolds scene = DrawTurned(13, true);
  const auto alone = testing::PlanOf(scene.structures[0], TorusMesh(9, 6));
  std::vector<Vec3d> points = scene.plan->identity_points;
  const auto own = static_cast<size_t>(scene.structures[0].control_point_count());
  const auto moved = testing::Jitter(scene.structures[0], 0.3, kVolumeSeed);
  std::ranges::copy(moved, points.begin());
  FoldReport expected = VolumeReport(alone, std::span(points).first(own));
  EXPECT_FALSE(expected.certified());
  expected.boxes += 1;  // outside
  EXPECT_EQ(VolumeReport(scene.plan, points), expected);
}

// Beyond the plan's own lattice there are no boxes but those of the turned one, which is moved in a corner far from it.
TEST(TurnedVolume, FoldsOutsideAreFoundWhereOneControlPointMoves) {
  const TurnedFolds scene = PlanTurned(
      TorusMesh(9, 6),
      std::vector<LatticeOptions>{{.scale = 0.5}, {.extra = {5, 4, 5}, .scale = 3, .turn = 0.7}});
  const DeformPlan& plan = *scene.plan;
  const LatticeStructure& s = plan.turned[0].structure;
  std::vector<Vec3d> points = plan.identity_points;
  const size_t corner = plan.turned[0].first_point;
  const Vec3d to_middle = s.frame.edges[0] + s.frame.edges[1] + s.frame.edges[2];
  points[corner] += 0.02 * to_middle;
  EXPECT_TRUE(VolumeReport(scene.plan, points).certified());
  points[corner] += 0.3 * to_middle;

  const FoldReport report = VolumeReport(scene.plan, points);

  ASSERT_EQ(report.places.size(), 1u);
  EXPECT_EQ(report.places[0].place, kOutsidePlace);
  EXPECT_EQ(report.places[0].state, FoldState::kFolded);
  EXPECT_LE(WorldDeterminant(plan, points, report.places[0].rest_point), 0);
}

// Knot planes of a frame whose axes are in another order are those of the first one.
TEST(TurnedVolume, PlanesMayCoincide) {
  LatticeStructure first = testing::MakeStructure(TorusMesh(9, 6).ComputeBounds(), {.scale = 1.2});
  LatticeStructure second = first;
  std::rotate(second.frame.edges.begin(), second.frame.edges.begin() + 1, second.frame.edges.end());
  std::rotate(second.knots.begin(), second.knots.begin() + 1, second.knots.end());
  std::rotate(second.size.begin(), second.size.begin() + 1, second.size.end());
  std::rotate(second.degree.begin(), second.degree.begin() + 1, second.degree.end());
  TurnedFolds scene{.structures = {first, second}};
  scene.plan = *MakePlan(std::make_shared<const PolygonMesh>(TorusMesh(9, 6)), first, {}, NeverStop,
                         nullptr, std::span(scene.structures).subspan(1));
  EXPECT_FALSE(TurnedVolume::ReachesOutside(*scene.plan));
  for (uint32_t seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE(seed);
    // Twice the displacement of one lattice, whose report it must then have, up to rounding.
    const auto points = JitterAll(scene, 0.06 + 0.02 * seed, kVolumeSeed + 2 * seed);
    const auto own = static_cast<size_t>(first.control_point_count());
    std::vector<Vec3d> sum(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(own));
    for (int k = 0, at = static_cast<int>(own); k < second.size[2]; ++k) {
      for (int j = 0; j < second.size[1]; ++j) {
        for (int i = 0; i < second.size[0]; ++i, ++at) {
          const auto index = static_cast<size_t>(at);
          sum[static_cast<size_t>(first.Index(k, i, j))] +=
              points[index] - scene.plan->identity_points[index];
        }
      }
    }
    const FoldReport report = VolumeReport(scene.plan, points);
    const FoldReport expected = VolumeReport(testing::PlanOf(first, TorusMesh(9, 6)), sum);
    EXPECT_EQ(report.boxes, expected.boxes);
    for (uint32_t box = 0; box < scene.plan->boxes.size(); ++box) {
      EXPECT_EQ(report.StateOf(box), expected.StateOf(box));
    }
  }
}

// The plan's own lattice turns the mesh by a right angle and bends it, the other one bends it more; it has knots side by side.
TEST(TurnedVolume, NarrowBoxesAreDecided) {
  const auto mesh = std::make_shared<const PolygonMesh>(TorusMesh(9, 6));
  for (const int degree : {1, 2, 3}) {
    SCOPED_TRACE(degree);
    std::vector<LatticeStructure> structures;
    for (const double turn : {0.0, 0.5}) {
      structures.push_back(testing::MakeStructure(
          mesh->ComputeBounds(),
          {.degree = {degree, degree, degree}, .extra = {3, 3, 3}, .turn = turn}));
    }
    for (auto& knots : structures[1].knots) {
      const auto first = static_cast<size_t>(degree) + 1;
      knots[first + 1] = knots[first] + 1e-9 * (knots[first + 1] - knots[first]);
    }
    const auto plan =
        *MakePlan(mesh, structures[0], {}, NeverStop, nullptr, std::span(structures).subspan(1));
    std::vector<Vec3d> points = plan->identity_points;
    for (size_t i = 0; i < points.size(); ++i) {
      const Vec3d p = points[i];
      if (i < plan->turned[0].first_point) {
        points[i] = {-p.y + 0.2 * std::sin(2 * p.z), p.x + 0.1 * std::sin(3 * p.y), p.z};
      } else {
        points[i] += 0.15 * Vec3d{std::sin(2 * p.y), std::sin(3 * p.z), std::sin(2 * p.x)};
      }
    }
    EXPECT_EQ(VolumeReport(plan, points), FoldReport{.boxes = plan->boxes.size()});
  }
}

TEST(TurnedVolume, RecertifyLeadsToTheSameReport) {
  for (const uint32_t mix : {5u, 13u, 21u}) {
    const TurnedFolds scene = DrawTurned(mix, mix == 13);
    const FoldCertifier certifier(scene.plan, FoldScope::kVolume);
    std::vector<Vec3d> points = scene.plan->identity_points;
    const auto own = static_cast<uint32_t>(scene.structures[0].control_point_count());
    FoldReport report = *certifier.Certify(points);
    std::mt19937 random(kVolumeSeed + mix);
    std::uniform_real_distribution<double> uniform(-0.3, 0.3);
    for (int edit = 0; edit < 24; ++edit) {
      SCOPED_TRACE(::testing::Message() << "mix " << mix << ", edit " << edit);
      std::vector<uint32_t> changed;
      for (size_t n = random() % 3 + 1; n-- > 0;) {
        // One third of the edits is of the own lattice, one third of the others, one third of all of them.
        const uint32_t first = edit % 3 == 1 ? own : 0;
        const auto end = edit % 3 == 0 ? own : static_cast<uint32_t>(points.size());
        changed.push_back(first + static_cast<uint32_t>(random()) % (end - first));
        points[changed.back()] += Vec3d{uniform(random), uniform(random), uniform(random)};
      }
      report = certifier.Recertify(report, changed, points);
      ASSERT_EQ(report, *certifier.Certify(points));
    }
    EXPECT_FALSE(report.certified());
  }
}

// An edit of a turned lattice leaves boxes alone that it cannot reach.
TEST(TurnedVolume, AnEditInfluencesTheBoxesItReaches) {
  const TurnedFolds scene =
      PlanTurned(TorusMesh(9, 6),
                 std::vector<LatticeOptions>{{.extra = {5, 5, 5}, .scale = 1.2},
                                             {.extra = {4, 4, 4}, .scale = 0.6, .turn = 0.7}});
  const auto first = static_cast<uint32_t>(scene.plan->turned[0].first_point);
  const auto boxes = TurnedVolume::InfluencedBoxes(*scene.plan, std::vector{first});
  const auto count = std::ranges::count(boxes, true);
  EXPECT_GT(count, 0);
  EXPECT_LT(count, 40);  // of 217, at a corner of the turned frame
}

TEST(TurnedVolume, StopsOutsideWhenTold) {
  const TurnedFolds scene = DrawTurned(13, true);
  const auto points = JitterAll(scene, 0.1, kVolumeSeed);
  TurnedVolume volume(*scene.plan, points);
  EXPECT_TRUE(
      absl::IsCancelled(volume.DecideOutside([] { return absl::CancelledError(); }).status()));
}

}  // namespace
}  // namespace latticed
