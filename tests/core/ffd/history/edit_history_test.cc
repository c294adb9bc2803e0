// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The order of batches, preconditions, and gestures of several editors.
#include "tests/core/ffd/history/edit_history_fixture.h"

namespace latticed {
namespace {

using ::latticed::testing::IsOk;
using ::latticed::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(EditHistoryTest, SaysWhatChanged) {
  ASSERT_OK_AND_ASSIGN(auto outcome, Do("ann", Move({9, 3, 5}, 0.25)));
  EXPECT_THAT(outcome.changed, ElementsAre(3, 5, 9));
  EXPECT_EQ(outcome.summary.largest_move, 0.25);
  EXPECT_EQ(outcome.summary.revision, 1u);
  EXPECT_EQ(outcome.summary.sequence, 1u);
  EXPECT_EQ(outcome.summary.structure_id, 1u);
  EXPECT_FALSE(outcome.structure_changed);
}

TEST_F(EditHistoryTest, ARefusedBatchChangesNothing) {
  auto outcome = Apply({.editor_id = "ann", .edits = {Move({0}, 1), Move({64}, 1)}});

  EXPECT_THAT(outcome, StatusIs(absl::StatusCode::kInvalidArgument,
                                HasSubstr("edits[1].move_control_points.indices[0]")));
  EXPECT_TRUE(AtStart());
  EXPECT_EQ(history_.revision(), 0u);
  EXPECT_EQ(history_.undo_steps(), 0u);
}

TEST_F(EditHistoryTest, TheSameSequenceReturnsTheStoredResult) {
  ASSERT_OK(Apply({.editor_id = "ann", .sequence = 5, .edits = {Move({0}, 1)}}));
  history_.SetTouched("ann", 8, 99);

  ASSERT_OK_AND_ASSIGN(auto again,
                       Apply({.editor_id = "ann", .sequence = 5, .edits = {Move({0}, 1)}}));
  EXPECT_TRUE(again.repeated);
  EXPECT_EQ(again.summary.revision, 1u);
  EXPECT_EQ(again.summary.patches_touched, 99u);
  EXPECT_EQ(history_.revision(), 1u);
  EXPECT_EQ(Moved(0), 1);
}

TEST_F(EditHistoryTest, TheSameSequenceReturnsTheStoredRefusal) {
  EXPECT_THAT(Apply({.editor_id = "ann", .sequence = 5, .edits = {Move({64}, 1)}}), Not(IsOk()));

  auto again = Apply({.editor_id = "ann", .sequence = 5, .edits = {Move({0}, 1)}});

  EXPECT_THAT(again, StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_TRUE(AtStart());
}

TEST_F(EditHistoryTest, ALowerSequenceIsOutOfOrder) {
  ASSERT_OK(Apply({.editor_id = "ann", .sequence = 5, .edits = {Move({0}, 1)}}));

  auto late = Apply({.editor_id = "ann", .sequence = 4, .edits = {Move({0}, 1)}});

  EXPECT_THAT(late, StatusIs(absl::StatusCode::kAborted));
  EXPECT_EQ(Reason(late), "OUT_OF_ORDER");
  EXPECT_OK(Apply({.editor_id = "bob", .sequence = 1, .edits = {Move({0}, 1)}}));
  EXPECT_EQ(history_.last_sequence("ann"), 5u);
}

TEST_F(EditHistoryTest, RemembersTheLast1024Editors) {
  for (int n = 0; n < 1025; ++n) ASSERT_OK(Do("editor-" + std::to_string(n), Move({0}, 1)));

  EXPECT_EQ(history_.last_sequence("editor-0"), 0u);
  EXPECT_EQ(history_.last_sequence("editor-1"), 1u);
  EXPECT_EQ(history_.last_sequence("editor-1024"), 1u);
}

TEST_F(EditHistoryTest, RefusesUnusableIds) {
  const Edit edit = Move({0}, 1);
  const std::string longest(64, 'x');
  const auto apply = [&](EditBatch batch) {
    batch.structure_id = 1;
    return history_.Apply(batch, now_, [](const LatticeStructure&) { return absl::OkStatus(); });
  };
  EXPECT_THAT(apply({.editor_id = "", .sequence = 1, .edits = {edit}}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("editor_id")));
  EXPECT_THAT(apply({.editor_id = longest + "x", .sequence = 1, .edits = {edit}}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("editor_id")));
  EXPECT_THAT(apply({.editor_id = "ann", .sequence = 0, .edits = {edit}}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("sequence")));
  EXPECT_EQ(history_.last_sequence(longest + "x"), 0u) << "kept for replay";
  EXPECT_THAT(
      apply({.editor_id = "ann", .sequence = 1, .gesture_id = longest + "x", .edits = {edit}}),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("gesture_id")));
  EXPECT_OK(apply({.editor_id = longest, .sequence = 1, .gesture_id = longest, .edits = {edit}}));
}

TEST_F(EditHistoryTest, RefusesBatchesWithoutEdits) {
  EXPECT_THAT(Apply({.editor_id = "ann"}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("edits")));
  EXPECT_THAT(End("ann", "g", GesturePhase::kUpdate), StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_THAT(Drag("ann", "g", {0}, 1, GesturePhase::kCancel),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("edits")));
  // Without a gesture_id, the phase is ignored.
  EXPECT_OK(
      Apply({.editor_id = "ann", .gesture_phase = GesturePhase::kCancel, .edits = {Move({0}, 1)}}));
}

TEST_F(EditHistoryTest, ComparesStructureAndRevision) {
  auto other = Apply({.editor_id = "ann", .structure_id = 7, .edits = {Move({0}, 1)}});
  EXPECT_THAT(other, StatusIs(absl::StatusCode::kAborted));
  EXPECT_EQ(Reason(other), "STRUCTURE_CHANGED");

  auto stale = Apply({.editor_id = "ann", .expected_revision = 3, .edits = {Move({0}, 1)}});
  EXPECT_THAT(stale, StatusIs(absl::StatusCode::kAborted));
  EXPECT_EQ(Reason(stale), "REVISION_CHANGED");
  EXPECT_EQ(error::DetailsOf(stale.status()).metadata.at("revision"), "0");

  EXPECT_OK(Apply({.editor_id = "ann", .expected_revision = 0, .edits = {Move({0}, 1)}}));
}

TEST_F(EditHistoryTest, AnUpdateReplacesTheOneBefore) {
  ASSERT_OK(Drag("ann", "g", {0, 1}, 1));
  EXPECT_TRUE(history_.gesture_open());
  ASSERT_OK(Drag("ann", "g", {0, 1}, 3));
  EXPECT_EQ(Moved(0), 3);  // not 4
  ASSERT_OK(Drag("ann", "g", {0}, 2));
  EXPECT_EQ(Moved(0), 2);
  EXPECT_EQ(Moved(1), 0);  // the previous update's other moves are undone
  ASSERT_OK(Drag("ann", "g", {0}, 5, GesturePhase::kCommit));
  EXPECT_EQ(Moved(0), 5);
  EXPECT_FALSE(history_.gesture_open());
  EXPECT_EQ(history_.undo_steps(), 1u);

  ASSERT_OK(Do("ann", Undo{}));
  EXPECT_TRUE(AtStart());
}

TEST_F(EditHistoryTest, ABareCommitKeepsTheLastUpdate) {
  ASSERT_OK(Drag("ann", "g", {0}, 1));
  ASSERT_OK(End("ann", "g", GesturePhase::kCommit));
  EXPECT_EQ(Moved(0), 1);
  EXPECT_FALSE(history_.gesture_open());
  ASSERT_OK(Drag("ann", "g", {0}, 1));  // after a commit the same id is a new gesture
  EXPECT_EQ(Moved(0), 2);
}

TEST_F(EditHistoryTest, CancelRestoresOnlyTheGesturesPoints) {
  ASSERT_OK(Drag("ann", "g", {0, 1}, 1));
  ASSERT_OK(Do("bob", Move({1, 2}, 10)));
  ASSERT_OK(End("ann", "g", GesturePhase::kCancel));

  EXPECT_EQ(Moved(0), 0);
  EXPECT_EQ(Moved(1), 11);  // bob wrote last
  EXPECT_EQ(Moved(2), 10);
  EXPECT_FALSE(history_.gesture_open());
  EXPECT_OK(End("ann", "never begun", GesturePhase::kCancel));
}

TEST_F(EditHistoryTest, ConcurrentGesturesOfTwoEditors) {
  ASSERT_OK(Drag("ann", "g", {0}, 1));
  ASSERT_OK(Drag("bob", "g", {1}, 1));
  ASSERT_OK(Drag("ann", "g", {0}, 2));
  ASSERT_OK(Drag("bob", "g", {1}, 3));
  EXPECT_EQ(Moved(0), 2);
  EXPECT_EQ(Moved(1), 3);

  ASSERT_OK(Do("ann", Undo{}));
  EXPECT_EQ(Moved(0), 0);
  EXPECT_EQ(Moved(1), 3);
}

TEST_F(EditHistoryTest, AnotherBatchCommitsTheOpenGesture) {
  ASSERT_OK(Drag("ann", "g", {0}, 1));
  ASSERT_OK(Drag("ann", "h", {0}, 1));
  EXPECT_EQ(Moved(0), 2);
  ASSERT_OK(Do("ann", Move({0}, 1)));
  EXPECT_EQ(Moved(0), 3);
  EXPECT_FALSE(history_.gesture_open());
  EXPECT_EQ(history_.undo_steps(), 3u);
}

TEST_F(EditHistoryTest, AGestureCommitsAfter60SecondsOfSilence) {
  ASSERT_OK(Drag("ann", "g", {0}, 1));
  now_ += std::chrono::seconds(59);
  history_.CommitIdleGestures(now_);
  EXPECT_TRUE(history_.gesture_open());
  now_ += std::chrono::seconds(1);
  history_.CommitIdleGestures(now_);
  EXPECT_FALSE(history_.gesture_open());
  EXPECT_EQ(Moved(0), 1);

  // The editor only paused: the drag continues as the same step, and does not drift.
  ASSERT_OK(Drag("ann", "g", {0}, 2));
  EXPECT_EQ(Moved(0), 2);
  EXPECT_EQ(history_.undo_steps(), 1u);
}

}  // namespace
}  // namespace latticed
