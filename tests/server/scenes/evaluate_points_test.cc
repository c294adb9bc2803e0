// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// EvaluatePoints through the stub.
#include <cmath>

#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

using EvaluatePointsTest = OneSceneTest;

TEST_F(EvaluatePointsTest, EvaluatesSurfacePoints) {
  v1::EditBatch lift = Move("ann", 1, 0, 0);
  auto* all = lift.mutable_edits(0)->mutable_move_control_points();
  all->clear_indices();
  for (uint32_t i = 0; i < 64; ++i) all->add_indices(i);
  all->mutable_offset()->set_z(3);
  ASSERT_OK(Apply(lift));

  auto request = For<v1::EvaluatePointsRequest>();
  auto* point = request.mutable_surface_points()->add_points();
  point->set_face(1);
  for (const uint32_t corner : {4u, 5u, 6u}) point->add_corners(corner);
  for (const double b : {0.5, 0.25, 0.25}) point->add_barycentrics(b);
  v1::EvaluatePointsResponse response;
  ASSERT_OK(Call(&Scenes::EvaluatePoints, request, &response));

  // Corners (1,0,0), (2,0,0), (2,1,0).
  EXPECT_EQ(response.revision(), 1u);
  ASSERT_EQ(response.positions_size(), 3);
  EXPECT_NEAR(response.positions(0), 1.5, 1e-12);
  EXPECT_NEAR(response.positions(1), 0.25, 1e-12);
  EXPECT_NEAR(response.positions(2), 3, 1e-12);
  ASSERT_EQ(response.normals_size(), 3);
  EXPECT_NEAR(response.normals(2), 1, 1e-12);
  ASSERT_EQ(response.jacobians_size(), 9);
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(response.jacobians(i), i % 4 == 0 ? 1 : 0, 1e-12);
}

TEST_F(EvaluatePointsTest, EvaluatesWorldPointsInsideAndOutside) {
  ASSERT_OK(Apply(Move("ann", 1, 21, 0.25)));
  auto request = For<v1::EvaluatePointsRequest>();
  for (const double x : {0.9, 0.9, 0.0, 50., 0., 0.}) {
    request.mutable_world_points()->add_positions(x);
  }
  v1::EvaluatePointsResponse response;
  ASSERT_OK(Call(&Scenes::EvaluatePoints, request, &response));

  EXPECT_GT(response.positions(0), 0.9);
  EXPECT_NEAR(response.positions(1), 0.9, 1e-12);
  EXPECT_EQ(response.positions(3), 50);
  EXPECT_EQ(response.normals_size(), 0);
  EXPECT_EQ(response.jacobians_size(), 18);
}

TEST_F(EvaluatePointsTest, RefusesBadPoints) {
  auto request = For<v1::EvaluatePointsRequest>();
  const auto expect = [&](const std::string& reason, const std::string& field) {
    ExpectRefused(Call(&Scenes::EvaluatePoints, request), Code::kInvalidArgument, reason, field);
  };
  expect("INVALID_FIELD", "points");
  request.mutable_world_points();
  expect("OUT_OF_RANGE", "world_points.positions");
  for (const double x : {std::nan(""), 0.0, 0.0}) request.mutable_world_points()->add_positions(x);
  expect("NOT_FINITE", "world_points.positions");
  request.mutable_surface_points();
  expect("OUT_OF_RANGE", "surface_points.points");

  auto* point = request.mutable_surface_points()->add_points();
  point->set_face(4);
  expect("OUT_OF_RANGE", "surface_points.points[0].face");
  point->set_face(0);
  expect("INVALID_FIELD", "surface_points.points[0].corners");
  for (const uint32_t corner : {0u, 1u, 4u}) point->add_corners(corner);
  expect("OUT_OF_RANGE", "surface_points.points[0].corners[2]");
  point->set_corners(2, 1);
  expect("INVALID_FIELD", "surface_points.points[0].corners[1]");
  point->set_corners(2, 2);
  expect("INVALID_FIELD", "surface_points.points[0].barycentrics");
  for (const double b : {0.5, 0.5, 0.5}) point->add_barycentrics(b);
  expect("INVALID_FIELD", "surface_points.points[0].barycentrics");
  point->set_barycentrics(0, -0.5);
  expect("OUT_OF_RANGE", "surface_points.points[0].barycentrics[0]");
  point->set_barycentrics(0, std::nan(""));
  expect("NOT_FINITE", "surface_points.points[0].barycentrics[0]");

  for (int i = 0; i < 4096; ++i) request.mutable_surface_points()->add_points();
  expect("OUT_OF_RANGE", "surface_points.points");
}

}  // namespace
}  // namespace latticed::testing
