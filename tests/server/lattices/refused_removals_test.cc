// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What is refused about lattices that edits remove: of the last one, by the structure, by folds; edits of what is gone.
#include <utility>
#include <vector>

#include "tests/server/lattices/removed_fixture.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

TEST_F(RemovedLatticesTest, OthersAreToldByTheStructure) {
  ASSERT_OK(Create(RequestOf({Whole(), Spot()})));
  v1::EditBatch update = Push(1, 21, {0.05, 0, 0}, "bob");
  update.set_gesture_id("drag");
  ASSERT_OK(Apply(update));
  ASSERT_OK(Apply(Remove(1)));

  update.set_sequence(++sequence_);
  ExpectRefused(Apply(update), Code::kAborted, "STRUCTURE_CHANGED");
  for (v1::EditBatch batch : {Push(1, 21, {0, 0, 1}, "bob"), Remove(1), Redo(1, "bob")}) {
    const bool redo = batch.edits(0).has_redo();
    ExpectRefused(Apply(batch), Code::kFailedPrecondition,
                  redo ? "NOTHING_TO_REDO" : "LATTICE_REMOVED");
  }
  const absl::Status conflict = Apply(Undo(1, "bob"));
  ExpectRefused(conflict, Code::kAborted, "UNDO_CONFLICT");
  EXPECT_EQ(conflict.message(), "undo: editor 'ann' has since removed the lattice");
  v1::EditBatch any = Undo(1, "bob");
  any.mutable_edits(0)->mutable_undo()->set_scope(v1::UNDO_SCOPE_SCENE);
  ASSERT_OK(Apply(any));
  EXPECT_EQ(Numbers(), (Numbered{0, 1}));
  ASSERT_OK(Apply(Undo(1, "bob")));  // the gesture, which the removal has ended
  ASSERT_OK(Apply(Remove(1)));
  ExpectRefused(Apply(Redo(1, "bob")), Code::kAborted, "UNDO_CONFLICT");
  EXPECT_EQ(Numbers(), Numbered{0});
}

TEST_F(RemovedLatticesTest, TheLastStays) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole())})));
  const auto before = Chunks();
  ExpectRefused(Apply(Remove(0)), Code::kFailedPrecondition, "LAST_LATTICE");
  ASSERT_OK(Apply(Put(1, Spot())));
  ASSERT_OK(Apply(Remove(0)));
  ExpectRefused(Apply(Remove(1)), Code::kFailedPrecondition, "LAST_LATTICE");
  ExpectRefused(Apply(Undo(1)), Code::kFailedPrecondition, "LAST_LATTICE");  // of the addition
  EXPECT_EQ(Numbers(), Numbered{1});
  EXPECT_EQ(Get().revision(), 2u);
  ASSERT_OK(Apply(Undo(0)));
  ASSERT_OK(Apply(Undo(1)));
  EXPECT_EQ(Numbers(), Numbered{0});
  EXPECT_EQ(Chunks().size(), before.size());
  v1::EditBatch redo = Redo(1);
  ASSERT_OK(Apply(redo));
  ASSERT_OK(Apply(Remove(0)));
  ExpectRefused(Apply(Remove(1)), Code::kFailedPrecondition, "LAST_LATTICE");
}

TEST_F(RemovedLatticesTest, WhatCannotBeRemovedChangesNothing) {
  ASSERT_OK(Create(RequestOf({Whole(), Spot()})));
  ExpectRefused(Apply(Remove(2)), Code::kInvalidArgument, "OUT_OF_RANGE", "lattice");
  v1::EditBatch old = Remove(1);
  old.set_structure_id(7);
  ExpectRefused(Apply(old), Code::kAborted, "STRUCTURE_CHANGED");
  v1::EditBatch late = Remove(1);
  late.set_expected_revision(5);
  ExpectRefused(Apply(late), Code::kAborted, "REVISION_CHANGED");
  v1::EditBatch gesture = Remove(1);
  gesture.set_gesture_id("drag");
  ExpectRefused(Apply(gesture), Code::kInvalidArgument, "INVALID_FIELD", "edits[0].remove_lattice");
  v1::EditBatch two = Remove(1);
  two.add_edits()->mutable_remove_lattice();
  ExpectRefused(Apply(two), Code::kInvalidArgument, "INVALID_FIELD", "edits[0].remove_lattice");
  EXPECT_EQ(Numbers(), (Numbered{0, 1}));
  EXPECT_EQ(Get().revision(), 0u);
  EXPECT_EQ(Get().structure_id(), 1u);

  const v1::EditBatch remove = Remove(1);
  ASSERT_OK(Apply(remove));
  v1::EditResult again;
  ASSERT_OK(Apply(remove, &again));  // sent again, it gets its result
  EXPECT_EQ(again.revision(), 1u);
  EXPECT_EQ(Get().revision(), 1u);
  v1::EditBatch fit = Put(1, Spot());
  fit.mutable_edits(0)->mutable_replace_lattice()->set_keep_shape(true);
  ExpectRefused(Apply(fit), Code::kInvalidArgument, "INVALID_FIELD",
                "edits[0].replace_lattice.keep_shape");
  EXPECT_EQ(Get().revision(), 1u);
}

TEST_F(RemovedLatticesTest, AReplacementThatWasAppliedGetsItsResultAfterTheRemoval) {
  ASSERT_OK(Create(RequestOf({Whole(), Shaken(Whole())})));
  v1::EditBatch fit = Put(1, Whole({3, 3, 3}));
  fit.mutable_edits(0)->mutable_replace_lattice()->set_keep_shape(true);
  v1::EditResult first, again;
  ASSERT_OK(Apply(fit, &first));  // its answer is lost
  ASSERT_OK(Apply(Remove(1, "bob")));

  ASSERT_OK(Apply(fit, &again));

  EXPECT_EQ(again.revision(), 1u);
  EXPECT_EQ(again.structure_id(), first.structure_id());
  EXPECT_EQ(again.drag_residual(), first.drag_residual());
  EXPECT_EQ(Get().revision(), 2u);
  EXPECT_EQ(Numbers(), Numbered{0});
  v1::EditBatch late = Put(1, Whole({3, 3, 3}));
  late.mutable_edits(0)->mutable_replace_lattice()->set_keep_shape(true);
  ExpectRefused(Apply(late), Code::kInvalidArgument, "INVALID_FIELD",
                "edits[0].replace_lattice.keep_shape");
}

TEST_F(RemovedLatticesTest, AShapeThatIsGoneIsRefusedInItsPlaceInTheSequence) {
  ASSERT_OK(Create(RequestOf({Whole(), Shaken(Whole())})));
  ASSERT_OK(Apply(Remove(1, "bob")));
  v1::EditBatch fit = Put(1, Whole({3, 3, 3}));
  fit.mutable_edits(0)->mutable_replace_lattice()->set_keep_shape(true);
  const auto refused = [&] {
    ExpectRefused(Apply(fit), Code::kInvalidArgument, "INVALID_FIELD",
                  "edits[0].replace_lattice.keep_shape");
  };
  refused();
  ASSERT_OK(Apply(Undo(1, "bob")));  // now there is a shape
  fit.set_structure_id(Get().structure_id());
  refused();  // sent again, it gets its result
  Restart();
  refused();
  EXPECT_EQ(LatticeAt(1).lattice().degree().u(), 2);
  EXPECT_EQ(Get().revision(), 2u);
  fit.set_sequence(++sequence_);
  ASSERT_OK(Apply(fit));
  EXPECT_EQ(LatticeAt(1).lattice().degree().u(), 3);
}

TEST_F(RemovedLatticesTest, NoNewFoldIfItIsRefused) {
  ASSERT_OK(Create(RequestOf({Whole({1, 1, 1}), Whole({1, 1, 1})})));
  // The first folds the cube over; the second takes that back.
  for (const auto& [number, dx] : {std::pair(0u, 2.0), std::pair(1u, -2.0)}) {
    v1::EditBatch batch = Push(number, 1, {dx, 0, 0});
    auto* all = batch.mutable_edits(0)->mutable_move_control_points()->mutable_indices();
    for (uint32_t row = 1; row < 16; ++row) all->Add(1 + 4 * row);
    ASSERT_OK(Apply(batch));
  }
  const std::vector<Vec3d> world = SomePoints(20);
  const auto before = Evaluate(world);
  v1::EditBatch careful = Remove(1);
  careful.set_refuse_folds(true);
  ExpectRefused(Apply(careful), Code::kFailedPrecondition, "FOLD");
  EXPECT_EQ(Numbers(), (Numbered{0, 1}));
  EXPECT_EQ(Evaluate(world), before);
  ASSERT_OK(Apply(Remove(1)));
}

}  // namespace
}  // namespace latticed::testing
