// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Plans from a network: what contradicts itself is refused with a reason, and nothing is read out of range.
#include "core/patches/patch_plan_reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "core/base/error.h"
#include "tests/core/patches/damaged_plans.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using testing::PlanMessages;
using testing::StatusIs;
using testing::Whole;

constexpr auto kRefused = absl::StatusCode::kInvalidArgument;

TEST(PatchPlanReader, RefusesWithTheFieldsName) {
  struct Case {
    std::string field;
    std::function<void(PlanMessages&)> damage;
  };
  const Case cases[] = {
      {"patch_count", [](PlanMessages& m) { m.runs.pop_back(), m.seams.clear(); }},
      {"seams", [](PlanMessages& m) { m.runs.pop_back(); }},
      {"run.patches", [](PlanMessages& m) { m.header.patches_outside -= 1; }},
      {"run.patches", [](PlanMessages& m) { m.runs[0].patches = 5000; }},
      {"header.patch_count", [](PlanMessages& m) { m.header.patch_count = 1; }},
      {"header.patch_count",
       [](PlanMessages& m) {
         m.header = {.patches_outside = 1, .outside_upper = {1, 1, 1}, .curvature_unit = 1};
         m.runs.clear(), m.seams.clear();
       }},
      {"header.origin", [](PlanMessages& m) { m.header.origin.y = std::nan(""); }},
      {"header.curvature_unit", [](PlanMessages& m) { m.header.curvature_unit = 0; }},
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

// Sanitizers see what is read out of range.
TEST(PatchPlanReader, TakesAnyArrays) {
  std::mt19937 random(17);
  int refused = 0, read = 0;
  for (int round = 0; round < 1'500; ++round) {
    const absl::Status status = testing::ReadPlan(testing::DamagedArrays(round, random)).status();

    EXPECT_TRUE(status.ok() || status.code() == kRefused) << status;
    ++(status.ok() ? read : refused);
  }
  EXPECT_GT(refused, 100);
  EXPECT_GT(read, 100);
}

}  // namespace
}  // namespace latticed
