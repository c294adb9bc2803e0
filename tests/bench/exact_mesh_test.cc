// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/exact_mesh.h"

#include <gtest/gtest.h>

#include "core/mesh/sample_meshes.h"
#include "tests/bench/work.h"

namespace latticed::bench {
namespace {

TEST(ExactMeshTest, PlansHaveTheNumberAskedForAtEveryDegree) {
  for (const std::array<int, 3> degree : {std::array{2, 2, 2}, std::array{1, 2, 3}}) {
    const auto plan = MakeExactPlan(17'119, degree);

    ASSERT_TRUE(plan.ok()) << plan.status();
    EXPECT_EQ((*plan)->patches.size(), 17'119u);
    EXPECT_EQ((*plan)->structure.size[2], kBoxesPerAxis + degree[2]);
  }
}

TEST(ExactMeshTest, RoughPlansHaveALittleMore) {
  const auto plan = MakeRoughPlan(50'000, {2, 2, 2});

  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_GE((*plan)->patches.size(), 50'000u);
  EXPECT_LE((*plan)->patches.size(), 60'000u);
}

TEST(ExactMeshTest, SubdivisionKeepsTheSurfaceAndSharesMiddles) {
  const auto knot = MakeSampleMesh("knot", 1);
  ASSERT_TRUE(knot.ok());

  const PolygonMesh triangles = Fans(*knot), fine = Subdivide(triangles);

  EXPECT_TRUE(Validate(fine).ok());
  EXPECT_EQ(triangles.face_count(), 2 * knot->face_count());
  EXPECT_EQ(fine.face_count(), 4 * triangles.face_count());
  // Less than one new vertex for each of three edges a face: neighbours share them.
  EXPECT_LT(fine.positions.size(), triangles.positions.size() + 2 * triangles.face_count());
}

TEST(WorkTest, CountsAreThoseOfTheDesign) {
  EXPECT_EQ(CompositionWork({2, 2, 2}), 1080);
  // 63 multiply-adds a point at 2 x 2 x 2, 10 segments, without the normal.
  EXPECT_NEAR(FusedWork({2, 2, 2}, 10) / 66 - kNormalWork, 63, 0.5);
  // And direct evaluation is cheaper below 4 segments.
  EXPECT_EQ(FusedWork({2, 2, 2}, 3), 10 * (DirectWork({2, 2, 2}) + kNormalWork));
  EXPECT_LT(FusedWork({2, 2, 2}, 4), 15 * (DirectWork({2, 2, 2}) + kNormalWork));
  EXPECT_EQ(ProductWork(6, 10), 9 * 28 * 66);
}

TEST(WorkTest, MethodsBreakEvenWhereTheDesignSays) {
  const TwoStageWork scalars = ScalarWork(28, 66, 66), printed = Formula20Work(28, 66, 3 * 66);

  EXPECT_EQ(scalars.method1, scalars.method2);
  EXPECT_EQ(printed.method1, printed.method2);
}

}  // namespace
}  // namespace latticed::bench
