// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Pick through the stub: what it finds is what EvaluatePoints says of it, and what it refuses.
#include <cmath>

#include "core/base/vec.h"
#include "tests/server/scene_fixture.h"

namespace latticed {
namespace {

using ::latticed::testing::SceneFixture;
using Stub = v1::SceneService::Stub;
using Code = absl::StatusCode;

v1::PickRequest RayOf(Vec3d origin, Vec3d direction) {
  v1::PickRequest request;
  request.set_scene("scene-one");
  const auto set = [](v1::Vec3* v, Vec3d value) {
    v->set_x(value.x);
    v->set_y(value.y);
    v->set_z(value.z);
  };
  set(request.mutable_ray()->mutable_origin(), origin);
  set(request.mutable_ray()->mutable_direction(), direction);
  return request;
}

class PickTest : public SceneFixture {
 protected:
  absl::Status Pick(const v1::PickRequest& request, v1::SurfacePoint* point) {
    return Call(&Stub::Pick, request, point);
  }
  void ExpectBadRay(const v1::PickRequest& request, const std::string& reason,
                    const std::string& field) {
    v1::SurfacePoint point;
    ExpectRefused(Pick(request, &point), Code::kInvalidArgument, reason, field);
  }
};

TEST_F(PickTest, FindsThePointThatEvaluatePointsHas) {
  ASSERT_OK(Create(SceneRequest()));
  for (uint64_t i = 0; i < 64; i += 3) {
    v1::EditBatch batch = Move("ann", i + 1, static_cast<uint32_t>(i), 0.05);
    batch.mutable_edits(0)->mutable_move_control_points()->mutable_offset()->set_z(
        0.3 * std::sin(static_cast<double>(i)));
    ASSERT_OK(Apply(batch));
  }
  for (const Vec3d target : {Vec3d{0.3, 0.4, 0}, {1.7, 1.1, 0}, {1, 1, 0}, {0.5, 0.5, 0}}) {
    const Vec3d origin{0.5, 2, 9}, direction = target - origin;
    v1::SurfacePoint point;

    ASSERT_OK(Pick(RayOf(origin, direction), &point));

    v1::EvaluatePointsRequest request;
    request.set_scene("scene-one");
    *request.mutable_surface_points()->add_points() = point;
    v1::EvaluatePointsResponse at;
    ASSERT_OK(Call(&Stub::EvaluatePoints, request, &at));
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
  v1::LatticeFrame& frame = *request.add_lattices()->mutable_lattice()->mutable_frame();
  frame.mutable_origin()->set_x(1.25);
  frame.mutable_origin()->set_z(-1);
  frame.mutable_u()->set_x(3);
  frame.mutable_v()->set_y(3);
  frame.mutable_w()->set_z(2);
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
  ASSERT_OK(Create(SceneRequest()));
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
  ASSERT_OK(Create(SceneRequest()));
  v1::SurfacePoint point;
  ExpectRefused(Pick(RayOf({1, 1, 1}, {0, 0, 1}), &point), Code::kNotFound, "NOTHING_HIT");
  ExpectRefused(Pick(RayOf({5, 1, 1}, {0, 0, -1}), &point), Code::kNotFound, "NOTHING_HIT");
  v1::PickRequest elsewhere = RayOf({1, 1, 1}, {0, 0, -1});
  elsewhere.set_scene("scene-zero");
  ExpectRefused(Pick(elsewhere, &point), Code::kNotFound, "NOT_FOUND");
}

TEST_F(PickTest, RefusesRaysThatAreNone) {
  ASSERT_OK(Create(SceneRequest()));
  v1::PickRequest none;
  none.set_scene("scene-one");
  ExpectBadRay(none, "INVALID_FIELD", "ray");
  ExpectBadRay(RayOf({1, 1, 1}, {0, 0, 0}), "INVALID_FIELD", "ray.direction");
  ExpectBadRay(RayOf({1, 1, 1}, {0, std::nan(""), 1}), "NOT_FINITE", "ray.direction");
  ExpectBadRay(RayOf({1, INFINITY, 1}, {0, 0, 1}), "NOT_FINITE", "ray.origin");
  ExpectBadRay(RayOf({1, 1, 2e15}, {0, 0, -1}), "OUT_OF_RANGE", "ray.origin");
  none.clear_scene();
  ExpectBadRay(none, "INVALID_FIELD", "scene");
}

}  // namespace
}  // namespace latticed
