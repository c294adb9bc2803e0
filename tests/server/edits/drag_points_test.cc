// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// drag_points through the stub: where surface points go, gestures, undo, knots, and every refusal.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/base/limits.h"
#include "core/base/vec.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

constexpr char kDrag[] = "edits[0].drag_points";

// A point of face 0 of the grid, in the triangle (0,0,0), (1,0,0), (1,1,0).
v1::SurfacePoint SurfacePointAt(double b0, double b1) {
  v1::SurfacePoint point;
  for (const uint32_t corner : {0u, 1u, 2u}) point.add_corners(corner);
  for (const double b : {b0, b1, 1 - b0 - b1}) point.add_barycentrics(b);
  return point;
}

class DragPointsTest : public OneSceneTest {
 protected:
  static void Add(v1::DragPoints& drag, const v1::SurfacePoint& point, Vec3d target) {
    *drag.add_points() = point;
    for (int axis = 0; axis < 3; ++axis) drag.add_targets(target[axis]);
  }
  v1::EditBatch Drag(const v1::SurfacePoint& point, Vec3d target) {
    v1::EditBatch batch = Move("ann", ++sequence_, 0, 0);
    Add(*batch.mutable_edits(0)->mutable_drag_points(), point, target);
    return batch;
  }
  v1::EditBatch InGesture(v1::EditBatch batch, v1::GesturePhase phase) {
    batch.set_gesture_id("drag");
    batch.set_gesture_phase(phase);
    return batch;
  }
  Vec3d PositionOf(const v1::SurfacePoint& point) {
    auto request = For<v1::EvaluatePointsRequest>();
    *request.mutable_surface_points()->add_points() = point;
    v1::EvaluatePointsResponse response;
    EXPECT_OK(Call(&Scenes::EvaluatePoints, request, &response));
    if (response.positions_size() != 3) return {};
    return {response.positions(0), response.positions(1), response.positions(2)};
  }
  void ExpectAt(const v1::SurfacePoint& point, Vec3d expected) {
    EXPECT_LE(Norm(PositionOf(point) - expected), 1e-12);
  }

  uint64_t sequence_ = 0;
};

TEST_F(DragPointsTest, PointsReachTheirTargets) {
  const auto first = SurfacePointAt(0.2, 0.3), second = SurfacePointAt(0.1, 0.6);
  v1::EditBatch batch = Drag(first, {0.7, 0.4, 1.5});
  Add(*batch.mutable_edits(0)->mutable_drag_points(), second, {1, 0.5, -0.5});
  const auto before = Lattice();
  v1::EditResult result;

  ASSERT_OK(Apply(batch, &result));

  ExpectAt(first, {0.7, 0.4, 1.5});
  ExpectAt(second, {1, 0.5, -0.5});
  EXPECT_LE(result.drag_residual(), 1e-12);
  EXPECT_GT(result.largest_move(), 1.0);
  EXPECT_GT(result.patches_touched(), 0u);
  const auto after = Lattice();
  EXPECT_EQ(after.revision(), 1u);
  double largest = 0;
  for (int i = 0; i < before.lattice().control_points_size(); i += 3) {
    Vec3d move;
    for (int c = 0; c < 3; ++c) {
      move[c] = after.lattice().control_points(i + c) - before.lattice().control_points(i + c);
    }
    largest = std::max(largest, Norm(move));
  }
  EXPECT_NEAR(result.largest_move(), largest, 1e-12);
}

TEST_F(DragPointsTest, AnUpdateDragsFromTheBeginOfItsGesture) {
  const auto point = SurfacePointAt(0.2, 0.3);
  const auto before = Lattice();
  const Vec3d rest = PositionOf(point);
  v1::EditResult result;
  ASSERT_OK(Apply(Drag(point, {0.7, 0.4, 1.0})));
  const auto begin = Lattice();
  for (int step = 1; step <= 20; ++step) {
    const double x = 0.05 * step;
    ASSERT_OK(Apply(InGesture(Drag(point, {0.7 + x, 0.4, 1 - x}), v1::GESTURE_PHASE_UPDATE)));
  }
  // The drag returns to its first target. Every control point must be back as well, up to rounding.
  ASSERT_OK(Apply(InGesture(Drag(point, {0.7, 0.4, 1}), v1::GESTURE_PHASE_UPDATE), &result));
  const auto after = Lattice();
  for (int i = 0; i < begin.lattice().control_points_size(); ++i) {
    EXPECT_NEAR(after.lattice().control_points(i), begin.lattice().control_points(i), 1e-14);
  }
  ASSERT_OK(Apply(InGesture(Drag(point, {2, 2, 2}), v1::GESTURE_PHASE_COMMIT)));
  ExpectAt(point, {2, 2, 2});

  v1::EditBatch undo = Move("ann", ++sequence_, 0, 0);
  undo.mutable_edits(0)->mutable_undo();
  ASSERT_OK(Apply(undo));
  ExpectAt(point, {0.7, 0.4, 1.0});
  undo.set_sequence(++sequence_);
  ASSERT_OK(Apply(undo));
  ExpectAt(point, rest);
  EXPECT_EQ(Lattice().lattice().SerializeAsString(), before.lattice().SerializeAsString());
  undo.set_sequence(++sequence_);
  undo.mutable_edits(0)->mutable_redo();
  ASSERT_OK(Apply(undo));
  ExpectAt(point, {0.7, 0.4, 1.0});
}

TEST_F(DragPointsTest, ContradictionsAreMetInTheMiddleAndReported) {
  const auto point = SurfacePointAt(0.2, 0.3);
  v1::EditBatch batch = Drag(point, {0, 0, 4});
  Add(*batch.mutable_edits(0)->mutable_drag_points(), point, {0, 0, 2});
  v1::EditResult result, again;

  ASSERT_OK(Apply(batch, &result));
  ASSERT_OK(Apply(batch, &again));

  ExpectAt(point, {0, 0, 3});
  EXPECT_NEAR(result.drag_residual(), 1, 1e-12);
  EXPECT_EQ(again.drag_residual(), result.drag_residual()) << "the stored result";
}

TEST_F(DragPointsTest, PointsOutsideTheFrameStayAndAreReported) {
  v1::CreateSceneRequest request = SceneRequest("scene-two");
  v1::Lattice& lattice = *request.add_lattices()->mutable_lattice();
  // The frame begins at x = 0.9. The rest of the mesh is outside.
  SetFrame(*lattice.mutable_frame(), {0.9, 0, -1}, {3, 3, 2});
  ASSERT_OK(Create(request));
  v1::EditBatch batch = Drag(SurfacePointAt(1, 0), {0, 0, 2});  // at (0,0,0)
  batch.set_scene("scene-two");
  v1::EditResult result;

  ASSERT_OK(Apply(batch, &result));

  EXPECT_EQ(result.drag_residual(), 2);
  EXPECT_EQ(result.largest_move(), 0);
  EXPECT_EQ(result.patches_touched(), 0u);
}

TEST_F(DragPointsTest, RefusesWhatItCannotRead) {
  const auto point = SurfacePointAt(0.2, 0.3);
  const auto expect = [&](v1::EditBatch batch, const std::string& reason, const std::string& field,
                          const std::function<void(v1::DragPoints&)>& spoil) {
    spoil(*batch.mutable_edits(0)->mutable_drag_points());
    ExpectRefused(Apply(batch), Code::kInvalidArgument, reason, kDrag + field);
  };
  const auto drag = [&] { return Drag(point, {0, 0, 1}); };
  expect(drag(), "OUT_OF_RANGE", ".points", [](auto& d) { d.Clear(); });
  expect(drag(), "OUT_OF_RANGE", ".points", [&](auto& d) {
    for (size_t i = 0; i < limits::kMaxDragPoints; ++i) DragPointsTest::Add(d, point, {0, 0, 1});
  });
  expect(drag(), "INVALID_FIELD", ".targets", [&](auto& d) { *d.add_points() = point; });
  expect(drag(), "INVALID_FIELD", ".targets", [](auto& d) { d.add_targets(1); });
  expect(drag(), "NOT_FINITE", ".targets", [](auto& d) { d.set_targets(1, std::nan("")); });
  expect(drag(), "OUT_OF_RANGE", ".targets[2]", [](auto& d) { d.set_targets(2, 1e19); });
  expect(drag(), "OUT_OF_RANGE", ".points[0].face",
         [](auto& d) { d.mutable_points(0)->set_face(4); });
  expect(drag(), "OUT_OF_RANGE", ".points[0].corners[2]",
         [](auto& d) { d.mutable_points(0)->set_corners(2, 4); });
  expect(drag(), "INVALID_FIELD", ".points[0].corners",
         [](auto& d) { d.mutable_points(0)->clear_corners(); });
  expect(drag(), "INVALID_FIELD", ".points[0].barycentrics",
         [](auto& d) { d.mutable_points(0)->set_barycentrics(0, 0.5); });
  expect(drag(), "NOT_FINITE", ".points[0].barycentrics[0]", [](auto& d) {
    d.mutable_points(0)->set_barycentrics(0, std::numeric_limits<double>::infinity());
  });
  EXPECT_EQ(Lattice().revision(), 0u);

  v1::EditBatch stale = drag();
  stale.set_structure_id(7);
  ExpectRefused(Apply(stale), Code::kAborted, "STRUCTURE_CHANGED");
}

TEST_F(DragPointsTest, DragsGoOnAfterAKnotWasInserted) {
  const auto point = SurfacePointAt(0.2, 0.3);
  ASSERT_OK(Apply(Drag(point, {0.5, 0.5, 1})));
  ASSERT_OK(Apply(Knot("ann", ++sequence_)));
  ExpectAt(point, {0.5, 0.5, 1});
  v1::EditBatch drag = Drag(point, {0.5, 0.5, 2});
  drag.set_structure_id(2);

  ASSERT_OK(Apply(drag));

  ExpectAt(point, {0.5, 0.5, 2});
}

}  // namespace
}  // namespace latticed::testing
