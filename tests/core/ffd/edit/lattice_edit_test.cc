// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The effect of each edit on a lattice, and the field path of each refusal.
#include "core/ffd/edit/lattice_edit.h"

#include <cmath>

#include "core/base/error.h"
#include "core/ffd/edit/knot_insertion.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Lattice Unit() {
  Bounds bounds;
  bounds.Extend(Vec3d{0, 0, 0});
  bounds.Extend(Vec3d{1, 1, 1});
  return *FitLattice(bounds, {3, 3, 3}, {2, 2, 2}, 0);
}

class LatticeEditTest : public ::testing::Test {
 protected:
  absl::Status Apply(const Edit& edit) {
    const auto initial = [this] { return initial_; };
    return ApplyEdit(edit, initial, "edits[2]", target_);
  }
  const Vec3d& point(size_t i) const { return target_.lattice.control_points[i]; }

  const Lattice initial_ = Unit();
  EditTarget target_{initial_};
};

TEST_F(LatticeEditTest, SetsMovesAndTransforms) {
  ASSERT_OK(Apply(SetControlPoints{{26, 0}, {{7, 8, 9}, {1, 2, 3}}}));
  EXPECT_EQ(point(26), (Vec3d{7, 8, 9}));
  EXPECT_EQ(point(0), (Vec3d{1, 2, 3}));

  ASSERT_OK(Apply(MoveControlPoints{{0}, {0.5, 0, -1}}));
  EXPECT_EQ(point(0), (Vec3d{1.5, 2, 2}));

  // x -> y, y -> -x, z -> z, then + (10, 20, 30): column-major.
  ASSERT_OK(
      Apply(TransformControlPoints{{0}, {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 10, 20, 30, 1}}));
  EXPECT_EQ(point(0), (Vec3d{8, 21.5, 32}));
  EXPECT_TRUE(target_.written[0]);
  EXPECT_TRUE(target_.written[26]);
  EXPECT_FALSE(target_.written[1]);
}

// The parent's frame is the lower half of the cube, and its points are moved along x: at u by 1 + u^2 of degree 2.
TEST_F(LatticeEditTest, CarriesPointsAsTheParentMovesTheWorld) {
  Bounds lower;
  lower.Extend(Vec3d{0, 0, 0});
  lower.Extend(Vec3d{1, 1, 0.5});
  Lattice parent = *FitLattice(lower, {3, 3, 3}, {2, 2, 2}, 0);
  for (size_t i = 0; i < parent.control_points.size(); ++i) {
    parent.control_points[i].y += std::array{1.0, 1.0, 2.0}[i % 3];
  }
  const auto rest = initial_.control_points;

  ASSERT_OK(Apply(CarryControlPoints{{}, parent}));

  for (size_t i = 0; i < rest.size(); ++i) {
    const bool inside = rest[i].z <= 0.5;
    const Vec3d expected = rest[i] + Vec3d{0, inside ? 1 + rest[i].x * rest[i].x : 0, 0};
    EXPECT_LE(Norm(point(i) - expected), 1e-15) << i;
    EXPECT_EQ(target_.written[i], inside) << i;
  }
}

// The parent goes on outside: linearly, so points above its frame move as those at its face.
TEST_F(LatticeEditTest, CarriesPointsOutsideOfAParentThatGoesOn) {
  Bounds lower;
  lower.Extend(Vec3d{0, 0, 0});
  lower.Extend(Vec3d{1, 1, 0.5});
  Lattice parent = *FitLattice(lower, {3, 3, 3}, {2, 2, 2}, 0);
  parent.structure.outside = {.mode = OutsideMode::kLinear, .widths = {0, 0, 0, 0, 0, 2}};
  ASSERT_OK(Validate(parent.structure));
  for (Vec3d& p : parent.control_points) p += Vec3d{3, 0, 0};

  ASSERT_OK(Apply(CarryControlPoints{{}, parent}));

  for (size_t i = 0; i < 27; ++i) {
    EXPECT_LE(Norm(point(i) - initial_.control_points[i] - Vec3d{3, 0, 0}), 1e-14) << i;
  }
}

TEST_F(LatticeEditTest, CarriesThePointsThatAreNamed) {
  Lattice parent = initial_;
  for (Vec3d& p : parent.control_points) p += Vec3d{0, 0, 3};

  ASSERT_OK(Apply(CarryControlPoints{{4, 9}, parent}));

  for (size_t i = 0; i < 27; ++i) {
    const Vec3d move{0, 0, i == 4 || i == 9 ? 3.0 : 0.0};
    EXPECT_LE(Norm(point(i) - initial_.control_points[i] - move), 1e-15) << i;
  }
}

TEST_F(LatticeEditTest, ReplacesAndResets) {
  const std::vector<Vec3d> all(27, Vec3d{1, 1, 1});
  ASSERT_OK(Apply(ReplaceControlPoints{all}));
  EXPECT_EQ(target_.lattice.control_points, all);

  ASSERT_OK(Apply(Reset{ResetTo::kIdentity}));
  EXPECT_EQ(target_.lattice.control_points, IdentityControlPoints(initial_.structure));
}

TEST_F(LatticeEditTest, ResetToInitialKeepsInsertedKnots) {
  Lattice moved = initial_;
  moved.control_points[13] = {0.7, 0.6, 0.5};
  const auto initial = [&] { return moved; };
  ASSERT_OK_AND_ASSIGN(auto refined, WithKnotInserted(moved, 1, 0.25, "f"));
  EditTarget target(refined);
  ASSERT_OK(ApplyEdit(MoveControlPoints{{4}, {1, 1, 1}}, initial, "edits[0]", target));

  ASSERT_OK(ApplyEdit(Reset{ResetTo::kInitial}, initial, "edits[0]", target));

  EXPECT_EQ(target.lattice.structure, refined.structure);
  EXPECT_EQ(target.lattice.control_points, refined.control_points);
}

TEST_F(LatticeEditTest, RefusesByField) {
  std::array<double, 16> not_finite{}, projective{1, 0, 0, 0, 0, 1, 0, 0.5, 0, 0, 1, 0, 0, 0, 0, 1};
  not_finite[15] = 1;
  not_finite[6] = kNan;
  ASSERT_OK(Apply(SetControlPoints{{3}, {{9e17, 0, 0}}}));
  const struct {
    Edit edit;
    const char* field;
    const char* reason;
  } cases[] = {
      {SetControlPoints{{0, 27}, {{}, {}}}, "set_control_points.indices[1]", "OUT_OF_RANGE"},
      {SetControlPoints{{5, 6, 5}, {{}, {}, {}}}, "set_control_points.indices[2]", "INVALID_FIELD"},
      {MoveControlPoints{{1, 1}, {}}, "move_control_points.indices[1]", "INVALID_FIELD"},
      {MoveControlPoints{{}, {}}, "move_control_points.indices", "INVALID_FIELD"},
      {TransformControlPoints{{99}, {}}, "transform_control_points.indices[0]", "OUT_OF_RANGE"},
      {SetControlPoints{{0, 1}, {{}, {0, kNan, 0}}}, "set_control_points.positions[4]",
       "NOT_FINITE"},
      {MoveControlPoints{{0}, {HUGE_VAL, 0, 0}}, "move_control_points.offset", "NOT_FINITE"},
      {ReplaceControlPoints{std::vector<Vec3d>(27, Vec3d{0, 0, kNan})},
       "replace_control_points.control_points[2]", "NOT_FINITE"},
      {TransformControlPoints{{0}, not_finite}, "transform_control_points.matrix", "NOT_FINITE"},
      // Values that float32 cannot hold.
      {SetControlPoints{{0}, {{0, 0, -1.1e18}}}, "set_control_points.positions[2]", "OUT_OF_RANGE"},
      {MoveControlPoints{{3}, {9e17, 0, 0}}, "move_control_points.offset", "OUT_OF_RANGE"},
      {SetControlPoints{{0, 1}, {{}}}, "set_control_points.positions", "INVALID_FIELD"},
      {ReplaceControlPoints{std::vector<Vec3d>(26)}, "replace_control_points.control_points",
       "INVALID_FIELD"},
      {TransformControlPoints{{0}, projective}, "transform_control_points.matrix", "INVALID_FIELD"},
      {TransformControlPoints{{0}, {}}, "transform_control_points.matrix", "INVALID_FIELD"},
      // Edits that must be alone in their batch.
      {Undo{}, "undo", "INVALID_FIELD"},
      {Redo{}, "redo", "INVALID_FIELD"},
      {InsertKnot{0, 0.5}, "insert_knot", "INVALID_FIELD"},
  };
  for (const auto& c : cases) {
    const absl::Status status = Apply(c.edit);
    EXPECT_THAT(status, StatusIs(absl::StatusCode::kInvalidArgument)) << c.field;
    EXPECT_EQ(error::DetailsOf(status).field, std::string("edits[2].") + c.field);
    EXPECT_EQ(error::DetailsOf(status).reason, c.reason) << c.field;
  }
}

}  // namespace
}  // namespace latticed
