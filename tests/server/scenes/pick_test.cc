// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Pick through the stub: its points are those of EvaluatePoints, and every refusal has its reason.
#include <cmath>

#include "core/base/vec.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

v1::PickRequest RayOf(Vec3d origin, Vec3d direction) {
  auto request = For<v1::PickRequest>();
  *request.mutable_ray()->mutable_origin() = ToVec3(origin);
  *request.mutable_ray()->mutable_direction() = ToVec3(direction);
  return request;
}

class PickTest : public OneSceneTest {
 protected:
  absl::Status Pick(const v1::PickRequest& request, v1::SurfacePoint* point = nullptr) {
    return Call(&Scenes::Pick, request, point);
  }
  void ExpectBadRay(const v1::PickRequest& request, const std::string& reason,
                    const std::string& field) {
    ExpectRefused(Pick(request), Code::kInvalidArgument, reason, field);
  }
};

TEST_F(PickTest, FindsThePointThatEvaluatePointsHas) {
  for (uint64_t i = 0; i < 64; i += 3) {
    ASSERT_OK(Apply(MoveOne("ann", i + 1, static_cast<uint32_t>(i),
                            {0.05, 0, 0.3 * std::sin(static_cast<double>(i))})));
  }
  for (const Vec3d target : {Vec3d{0.3, 0.4, 0}, {1.7, 1.1, 0}, {1, 1, 0}, {0.5, 0.5, 0}}) {
    const Vec3d origin{0.5, 2, 9}, direction = target - origin;
    v1::SurfacePoint point;

    ASSERT_OK(Pick(RayOf(origin, direction), &point));

    auto request = For<v1::EvaluatePointsRequest>();
    *request.mutable_surface_points()->add_points() = point;
    v1::EvaluatePointsResponse at;
    ASSERT_OK(Call(&Scenes::EvaluatePoints, request, &at));
    EXPECT_NEAR(point.position().x(), at.positions(0), 1e-12);
    EXPECT_NEAR(point.position().y(), at.positions(1), 1e-12);
    EXPECT_NEAR(point.position().z(), at.positions(2), 1e-12);
    EXPECT_NEAR(point.normal().x(), at.normals(0), 1e-9);
    EXPECT_NEAR(point.normal().y(), at.normals(1), 1e-9);
    EXPECT_NEAR(point.normal().z(), at.normals(2), 1e-9);
    const Vec3d d = Vec3d{at.positions(0), at.positions(1), at.positions(2)} - origin;
    EXPECT_LE(Norm(Cross(d, direction)), 1e-9 * Norm(d) * Norm(direction)) << "on the ray";
  }
}

TEST_F(PickTest, FindsWhatIsOutsideTheFrame) {
  v1::CreateSceneRequest request = SceneRequest();
  SetFrame(*request.add_lattices()->mutable_lattice()->mutable_frame(), {1.25, 0, -1}, {3, 3, 2});
  ASSERT_OK(DeleteScene());
  ASSERT_OK(Create(request));
  v1::SurfacePoint outside, inside;

  ASSERT_OK(Pick(RayOf({0.25, 0.5, -3}, {0, 0, 2}), &outside));
  ASSERT_OK(Pick(RayOf({1.75, 1.5, 3}, {0, 0, -2}), &inside));

  EXPECT_EQ(outside.face(), 0u);
  EXPECT_NEAR(outside.position().x(), 0.25, 1e-12);
  EXPECT_NEAR(outside.normal().z(), 1, 1e-12) << "of the surface, whichever side is hit";
  EXPECT_EQ(inside.face(), 3u);
  EXPECT_NEAR(inside.position().y(), 1.5, 1e-12);
}

TEST_F(PickTest, ANormalThatIsUndefinedIsLeftOut) {
  v1::EditBatch collapse = Move("ann", 1, 0, 0);
  auto* all = collapse.mutable_edits(0)->mutable_replace_control_points();
  for (int i = 0; i < 64; ++i) {
    for (const double x : {1.0, 2.0, 3.0}) all->add_control_points(x);
  }
  ASSERT_OK(Apply(collapse));
  v1::SurfacePoint point;

  ASSERT_OK(Pick(RayOf({1, 2, 0}, {0, 0, 1}), &point));

  EXPECT_EQ(point.position().z(), 3);
  EXPECT_FALSE(point.has_normal());
}

TEST_F(PickTest, NothingHitIsNotFoundWithAReasonOfItsOwn) {
  ExpectRefused(Pick(RayOf({1, 1, 1}, {0, 0, 1})), Code::kNotFound, "NOTHING_HIT");
  ExpectRefused(Pick(RayOf({5, 1, 1}, {0, 0, -1})), Code::kNotFound, "NOTHING_HIT");
  v1::PickRequest elsewhere = RayOf({1, 1, 1}, {0, 0, -1});
  elsewhere.set_scene("scene-zero");
  ExpectRefused(Pick(elsewhere), Code::kNotFound, "NOT_FOUND");
}

TEST_F(PickTest, RefusesRaysThatAreNone) {
  auto none = For<v1::PickRequest>();
  ExpectBadRay(none, "INVALID_FIELD", "ray");
  ExpectBadRay(RayOf({1, 1, 1}, {0, 0, 0}), "INVALID_FIELD", "ray.direction");
  ExpectBadRay(RayOf({1, 1, 1}, {0, std::nan(""), 1}), "NOT_FINITE", "ray.direction");
  ExpectBadRay(RayOf({1, INFINITY, 1}, {0, 0, 1}), "NOT_FINITE", "ray.origin");
  ExpectBadRay(RayOf({1, 1, 2e15}, {0, 0, -1}), "OUT_OF_RANGE", "ray.origin");
  none.clear_scene();
  ExpectBadRay(none, "INVALID_FIELD", "scene");
}

}  // namespace
}  // namespace latticed::testing
