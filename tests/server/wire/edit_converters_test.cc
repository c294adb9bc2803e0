// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/edit_converters.h"

#include <variant>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::ElementsAre;

constexpr absl::StatusCode kInvalidEdit = absl::StatusCode::kInvalidArgument;

v1::EditBatch BatchOf(const v1::Edit& edit) {
  v1::EditBatch batch;
  *batch.add_edits() = edit;
  return batch;
}

// A right triangle with legs of length 4 along x and y.
const PolygonMesh& Mesh() {
  static const auto* const kMesh = new PolygonMesh{.positions = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}},
                                                   .face_offsets = {0, 3},
                                                   .corner_vertices = {0, 1, 2}};
  return *kMesh;
}

TEST(EditConverter, KeepsEveryFieldOfABatch) {
  v1::EditBatch batch;
  batch.set_editor_id("editor");
  batch.set_sequence(8);
  batch.set_structure_id(3);
  batch.set_expected_revision(0);
  batch.set_gesture_id("drag");
  batch.set_gesture_phase(v1::GESTURE_PHASE_COMMIT);

  const auto result = FromProto(batch, Mesh());

  ASSERT_OK(result);
  EXPECT_EQ(result->editor_id, "editor");
  EXPECT_EQ(result->sequence, 8U);
  EXPECT_EQ(result->structure_id, 3U);
  EXPECT_EQ(result->expected_revision, 0U);
  EXPECT_EQ(result->gesture_id, "drag");
  EXPECT_EQ(result->gesture_phase, GesturePhase::kCommit);
  batch.clear_expected_revision();
  batch.set_gesture_phase(v1::GESTURE_PHASE_UNSPECIFIED);
  EXPECT_FALSE(FromProto(batch, Mesh())->expected_revision.has_value());
  EXPECT_EQ(FromProto(batch, Mesh())->gesture_phase, GesturePhase::kUpdate);
}

TEST(EditConverter, ReadsEveryArmInOrder) {
  v1::EditBatch batch;
  auto* set = batch.add_edits()->mutable_set_control_points();
  set->add_indices(5);
  for (double x : {1.0, 2.0, 3.0}) set->add_positions(x);
  auto* move = batch.add_edits()->mutable_move_control_points();
  move->add_indices(6);
  move->mutable_offset()->set_z(-1);
  auto* transform = batch.add_edits()->mutable_transform_control_points();
  transform->add_indices(7);
  for (int i = 0; i < 16; ++i) transform->add_matrix(i);
  for (int i = 0; i < 6; ++i) {
    if (i == 0) batch.add_edits()->mutable_replace_control_points();
    batch.mutable_edits(3)->mutable_replace_control_points()->add_control_points(i);
  }
  auto* knot = batch.add_edits()->mutable_insert_knot();
  knot->set_axis(v1::LATTICE_AXIS_W);
  knot->set_value(0.75);
  batch.add_edits()->mutable_reset()->set_target(v1::RESET_TARGET_INITIAL);
  batch.add_edits()->mutable_undo()->set_scope(v1::UNDO_SCOPE_SCENE);
  batch.add_edits()->mutable_redo();

  const auto result = FromProto(batch, Mesh());

  ASSERT_OK(result);
  ASSERT_EQ(result->edits.size(), 8U);
  EXPECT_THAT(std::get<SetControlPoints>(result->edits[0]).indices, ElementsAre(5));
  EXPECT_THAT(std::get<SetControlPoints>(result->edits[0]).positions, ElementsAre(Vec3d{1, 2, 3}));
  EXPECT_EQ(std::get<MoveControlPoints>(result->edits[1]).offset, (Vec3d{0, 0, -1}));
  EXPECT_EQ(std::get<TransformControlPoints>(result->edits[2]).matrix[13], 13);
  EXPECT_THAT(std::get<ReplaceControlPoints>(result->edits[3]).control_points,
              ElementsAre(Vec3d{0, 1, 2}, Vec3d{3, 4, 5}));
  EXPECT_EQ(std::get<InsertKnot>(result->edits[4]).axis, 2);
  EXPECT_EQ(std::get<InsertKnot>(result->edits[4]).value, 0.75);
  EXPECT_EQ(std::get<Reset>(result->edits[5]).to, ResetTo::kInitial);
  EXPECT_EQ(std::get<Undo>(result->edits[6]).scope, UndoScope::kScene);
  EXPECT_TRUE(std::holds_alternative<Redo>(result->edits[7]));
}

TEST(EditConverter, ReadsAParentThatCarries) {
  v1::Edit edit;
  auto& carry = *edit.mutable_carry_control_points();
  v1::LatticeFrame& frame = *carry.mutable_parent()->mutable_frame();
  frame.mutable_origin();
  frame.mutable_u()->set_x(1);
  frame.mutable_v()->set_y(2);
  frame.mutable_w()->set_z(3);
  for (int i = 0; i < 3 * 64; ++i) carry.mutable_parent()->add_control_points(i);
  const auto all = FromProto(BatchOf(edit), Mesh());
  ASSERT_OK(all);
  EXPECT_THAT(std::get<CarryControlPoints>(all->edits[0]).indices, ::testing::IsEmpty());
  EXPECT_EQ(std::get<CarryControlPoints>(all->edits[0]).parent.control_points[1], (Vec3d{3, 4, 5}));

  carry.add_indices(9);
  const auto one = FromProto(BatchOf(edit), Mesh());
  ASSERT_OK(one);
  EXPECT_THAT(std::get<CarryControlPoints>(one->edits[0]).indices, ElementsAre(9));
}

TEST(EditConverter, ALatticeThatReplacesMustBeAlone) {
  v1::Edit edit;
  v1::Lattice& lattice = *edit.mutable_replace_lattice()->mutable_lattice();
  lattice.mutable_frame()->mutable_origin();
  lattice.mutable_frame()->mutable_u()->set_x(1);
  lattice.mutable_frame()->mutable_v()->set_y(2);
  lattice.mutable_frame()->mutable_w()->set_z(3);
  v1::EditBatch batch = BatchOf(edit);
  const auto given = FromProto(batch, Mesh());
  ASSERT_OK(given);
  const auto& replace = std::get<ReplaceLattice>(given->edits[0]);
  EXPECT_EQ(replace.lattice.structure.frame.edges[1], (Vec3d{0, 2, 0}));
  EXPECT_EQ(replace.lattice.control_points.size(), 64U);
  EXPECT_FALSE(replace.keep_shape);

  batch.mutable_edits(0)->mutable_replace_lattice()->set_keep_shape(true);
  const auto kept = FromProto(batch, Mesh());
  ASSERT_OK(kept);
  EXPECT_TRUE(std::get<ReplaceLattice>(kept->edits[0]).keep_shape);
  EXPECT_TRUE(std::get<ReplaceLattice>(kept->edits[0]).lattice.control_points.empty());

  *batch.add_edits() = edit;
  EXPECT_THAT(FromProto(batch, Mesh()).status(),
              StatusIs(kInvalidEdit, ::testing::HasSubstr("must be the only edit of its batch")));
}

TEST(EditConverter, UnknownEnumValuesAreUnsupported) {
  v1::Edit knot, reset, undo;
  knot.mutable_insert_knot()->set_axis(static_cast<v1::LatticeAxis>(4));
  reset.mutable_reset()->set_target(static_cast<v1::ResetTarget>(4));
  undo.mutable_undo()->set_scope(static_cast<v1::UndoScope>(4));
  v1::EditBatch phase;
  phase.set_gesture_phase(static_cast<v1::GesturePhase>(9));
  for (const auto& batch : {BatchOf(knot), BatchOf(reset), BatchOf(undo), phase}) {
    const auto status = FromProto(batch, Mesh()).status();
    EXPECT_THAT(status, StatusIs(kInvalidEdit));
    EXPECT_EQ(error::DetailsOf(status).reason, "UNSUPPORTED");
  }
}

TEST(EditConverter, ResultsCarryTheStatusOnlyWhenRefused) {
  EditSummary summary{.sequence = 4,
                      .status = absl::OkStatus(),
                      .revision = 9,
                      .structure_id = 2,
                      .boxes_touched = 27,
                      .patches_touched = 512,
                      .largest_move = 0.5};
  const v1::EditResult applied = ToProto(summary);
  summary.status = error::Aborted("STRUCTURE_CHANGED", "fetch the lattice");
  const v1::EditResult refused = ToProto(summary);

  EXPECT_EQ(applied.sequence(), 4U);
  EXPECT_FALSE(applied.has_status());
  EXPECT_EQ(applied.revision(), 9U);
  EXPECT_EQ(applied.structure_id(), 2U);
  EXPECT_EQ(applied.boxes_touched(), 27U);
  EXPECT_EQ(applied.patches_touched(), 512U);
  EXPECT_EQ(applied.largest_move(), 0.5);
  EXPECT_EQ(refused.status().code(), 10);
}

}  // namespace
}  // namespace latticed
