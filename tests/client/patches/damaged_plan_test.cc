// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Plans, lattices and arguments that do not fit each other are refused, and nothing is read out of range.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "client/cpp/library/patches/patch_evaluator.h"
#include "client/cpp/library/patches/plan_from_proto.h"
#include "tests/core/patches/damaged_plans.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {
namespace {

using ::latticed::testing::StatusIs;

constexpr auto kRefused = absl::StatusCode::kInvalidArgument;

TEST(DamagedPlan, OfAnotherLatticeIsRefused) {
  const auto plan = testing::HalfTorus();
  const auto read = std::make_shared<PatchPlan>(testing::ReadPlan(testing::Whole()).value());
  ASSERT_OK(PatchEvaluator::Create(read, plan->structure).status());
  const Bounds bounds = plan->mesh_bounds;

  // One has more boxes, the other fewer.
  for (const int extra : {5, 0}) {
    const auto other = testing::MakeStructure(bounds, {.extra = {extra, extra, extra}});
    EXPECT_THAT(PatchEvaluator::Create(read, other).status(), StatusIs(kRefused));
  }
}

TEST(DamagedPlan, WithoutAnOutsideBoxIsRefused) {
  const auto read = std::make_shared<PatchPlan>(testing::ReadPlan(testing::Whole()).value());
  ASSERT_GT(read->header.patches_outside, 0u);
  read->header.outside_upper.x = read->header.outside_lower.x;

  EXPECT_THAT(PatchEvaluator::Create(read, testing::HalfTorus()->structure).status(),
              StatusIs(kRefused));
}

TEST(PatchEvaluator, RefusesArgumentsThatDoNotFit) {
  const testing::PatchScene scene = testing::DrawPatchScene(3, 0.4, RestNormals::kFacet);
  auto evaluator = PatchEvaluator::Create(scene.read, scene.plan->structure);
  PatchSurface surface;
  const auto evaluate = [&](size_t points, size_t bounds, double tolerance) {
    return evaluator->Evaluate(std::span(scene.control_points).first(points),
                               std::span(scene.edge_bounds).first(bounds), tolerance, &surface);
  };
  const size_t points = scene.control_points.size(), bounds = scene.edge_bounds.size();

  EXPECT_OK(evaluate(points, bounds, 1));
  EXPECT_THAT(evaluate(points - 1, bounds, 1), StatusIs(kRefused));
  EXPECT_THAT(evaluate(points, bounds - 1, 1), StatusIs(kRefused));
  EXPECT_THAT(evaluate(points, bounds, 0), StatusIs(kRefused));
  EXPECT_THAT(evaluate(points, bounds, std::nan("")), StatusIs(kRefused));
}

// Whatever the bytes of a plan's arrays are, evaluating it ends with a surface or a refusal.
TEST(DamagedPlan, IsEvaluatedOrRefused) {
  std::mt19937 random(17);
  const auto plan = testing::HalfTorus();
  int refused = 0, evaluated = 0;
  for (int round = 0; round < 1'500; ++round) {
    const auto read = testing::ReadPlan(testing::DamagedArrays(round, random));
    auto evaluator =
        read.ok() ? PatchEvaluator::Create(std::make_shared<PatchPlan>(*read), plan->structure)
                  : read.status();
    if (!evaluator.ok()) {
      EXPECT_THAT(evaluator.status(), StatusIs(kRefused));
      ++refused;
      continue;
    }
    PatchSurface surface;
    const std::vector<uint8_t> bounds(read->header.edge_count, 60);
    EXPECT_OK(evaluator->Evaluate(plan->identity_points, bounds, 0.01, &surface));
    ++evaluated;
  }
  EXPECT_GT(refused, 100);
  EXPECT_GT(evaluated, 100);
}

TEST(PatchPlanMessages, NeedAHeaderFirstAndOnce) {
  v1::PatchPlanPart header, run;
  header.mutable_header()->set_normals(v1::NORMAL_MODE_FACET);
  run.mutable_run()->set_patches(1);

  PatchPlanMessages empty, late, twice;

  EXPECT_THAT(empty.Finish().status(), StatusIs(absl::StatusCode::kDataLoss));
  EXPECT_THAT(late.Add(run), StatusIs(absl::StatusCode::kDataLoss));
  EXPECT_OK(twice.Add(header));
  EXPECT_THAT(twice.Add(header), StatusIs(absl::StatusCode::kDataLoss));
  EXPECT_THAT(twice.Add(run), StatusIs(absl::StatusCode::kDataLoss));
}

}  // namespace
}  // namespace latticed::client
