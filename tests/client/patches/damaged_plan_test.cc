// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Plans from a network: what contradicts itself is refused with a reason, and nothing is read out of range.
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <random>

#include "client/cpp/library/patches/patch_evaluator.h"
#include "client/cpp/library/patches/plan_from_proto.h"
#include "core/base/error.h"
#include "core/patches/zlib_stream.h"
#include "tests/client/patches/patch_scene.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {
namespace {

using ::latticed::testing::PlanMessages;
using ::latticed::testing::StatusIs;

constexpr auto kRefused = absl::StatusCode::kInvalidArgument;

// Half of a torus in a lattice: patches inside and outside, and seams.
std::shared_ptr<const DeformPlan> HalfTorus() {
  const PolygonMesh mesh = testing::TorusMesh(12, 8);
  return MakePlan(std::make_shared<PolygonMesh>(mesh),
                  testing::MakeStructure(mesh.ComputeBounds(), {.shift = {0.5, 0, 0}}))
      .value();
}

PlanMessages Whole(RestNormals normals = RestNormals::kFacet) {
  return testing::WritePlan(HalfTorus(), normals);
}

std::string Arrays(const PlanMessages& messages, size_t run) {
  const PatchRun& r = messages.runs[run];
  return Inflate("data", r.data,
                 size_t{16} * r.patches + size_t{12} * r.new_vertices + size_t{4} * r.new_normals)
      .value();
}

TEST(DamagedPlan, IsRefusedWithTheFieldsName) {
  struct Case {
    std::string field;
    std::function<void(PlanMessages&)> damage;
  };
  const Case cases[] = {
      {"patch_count", [](PlanMessages& m) { m.runs.pop_back(), m.seams.clear(); }},
      {"seams", [](PlanMessages& m) { m.runs.pop_back(); }},
      {"run.patches", [](PlanMessages& m) { m.header.patches_outside -= 1; }},
      {"run.patches", [](PlanMessages& m) { m.runs[0].patches = 5000; }},
      {"run.first_patch", [](PlanMessages& m) { m.runs[1].first_patch += 1; }},
      {"run.new_vertices", [](PlanMessages& m) { m.runs[0].new_vertices = 4'000'000'000; }},
      {"run.new_normals", [](PlanMessages& m) { m.runs[0].new_normals = m.runs[0].patches + 1; }},
      {"run.data", [](PlanMessages& m) { m.runs[0].data.pop_back(); }},
      {"run.data", [](PlanMessages& m) { m.runs[0].data.push_back('x'); }},
      {"run.data", [](PlanMessages& m) { m.runs[0].data[9] ^= 1; }},
      {"run.data", [](PlanMessages& m) { m.runs[0].data.clear(); }},
      {"vertex_count", [](PlanMessages& m) { m.header.vertex_count += 1; }},
      {"edge_count", [](PlanMessages& m) { m.header.edge_count -= 1; }},
      {"normal_count", [](PlanMessages& m) { m.header.normal_count = 0; }},
      {"seams.ranges", [](PlanMessages& m) { m.seams[0].ranges.pop_back(); }},
      {"seams.vertices", [](PlanMessages& m) { m.seams[0].vertices[1] = 0; }},
      {"seams.vertices", [](PlanMessages& m) { m.seams[0].vertices.back() = 1'000'000; }},
      {"seams.vertices", [](PlanMessages& m) { m.seams[0].vertex_seams[0] = 1'000; }},
      {"seams.vertices", [](PlanMessages& m) { m.seams[0].vertex_seams.pop_back(); }},
      {"seams.edges", [](PlanMessages& m) { m.seams[0].edge_seams[0] = 1'000; }},
      {"seams.outside_places", [](PlanMessages& m) { m.seams[0].outside_places.pop_back(); }},
      {"seams.outside_places", [](PlanMessages& m) { m.seams[0].outside_places[0] = 70'000; }},
      {"seams.identity_points", [](PlanMessages& m) { m.seams.back().identity_points.clear(); }},
  };
  ASSERT_OK(testing::ReadPlan(Whole()).status());
  for (const Case& damaged : cases) {
    SCOPED_TRACE(damaged.field);
    PlanMessages messages = Whole();
    damaged.damage(messages);

    const absl::Status status = testing::ReadPlan(messages).status();

    EXPECT_THAT(status, StatusIs(kRefused));
    EXPECT_EQ(error::DetailsOf(status).field, damaged.field) << status;
  }
}

TEST(DamagedPlan, OfAnotherLatticeIsRefused) {
  const auto plan = HalfTorus();
  const auto read = std::make_shared<PatchPlan>(testing::ReadPlan(Whole()).value());
  ASSERT_OK(PatchEvaluator::Create(read, plan->structure).status());
  const Bounds bounds = plan->mesh_bounds;

  // One has more boxes, the other fewer.
  for (const int extra : {5, 0}) {
    const auto other = testing::MakeStructure(bounds, {.extra = {extra, extra, extra}});
    EXPECT_THAT(PatchEvaluator::Create(read, other).status(), StatusIs(kRefused));
  }
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

// Whatever the bytes of the arrays are, reading and evaluating them ends with a surface or a refusal. Sanitizers see
// what is read out of range.
TEST(DamagedPlan, NeverReadsOutOfRange) {
  std::mt19937 random(17);
  const auto plan = HalfTorus();
  int refused = 0, evaluated = 0;
  for (int round = 0; round < 1'500; ++round) {
    PlanMessages messages = Whole();
    const size_t run = random() % messages.runs.size();
    std::string arrays = Arrays(messages, run);
    // Damage to corners seldom comes past the number of edges, so half of the rounds spare them.
    const size_t first = round % 2 == 0 ? 0 : size_t{12} * messages.runs[run].patches;
    for (size_t i = 0; i < 1 + random() % 3; ++i) {
      arrays[first + random() % (arrays.size() - first)] = static_cast<char>(random());
    }
    messages.runs[run].data = Deflate(arrays).value();
    const auto read = testing::ReadPlan(messages);
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
