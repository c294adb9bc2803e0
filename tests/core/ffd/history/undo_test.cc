// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Undo, redo and the memory use of an edit history.
#include <chrono>
#include <random>

#include "tests/core/ffd/history/edit_history_fixture.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST_F(EditHistoryTest, UndoAndRedoWalkTheStepsOfOneEditor) {
  ASSERT_OK(Do("ann", Move({0}, 1)));
  ASSERT_OK(Do("bob", Move({5}, 1)));
  ASSERT_OK(Do("ann", Move({0}, 1)));

  ASSERT_OK_AND_ASSIGN(auto undone, Do("ann", Undo{}));
  EXPECT_THAT(undone.changed, ElementsAre(0));
  EXPECT_EQ(undone.summary.revision, 4u);
  ASSERT_OK(Do("ann", Undo{}));
  EXPECT_EQ(Moved(0), 0);
  EXPECT_EQ(Moved(5), 1);
  EXPECT_EQ(Reason(Do("ann", Undo{})), "NOTHING_TO_UNDO");

  ASSERT_OK(Do("ann", Redo{}));
  ASSERT_OK(Do("ann", Redo{}));
  EXPECT_EQ(Moved(0), 2);
  auto none = Do("ann", Redo{});
  EXPECT_THAT(none, StatusIs(absl::StatusCode::kFailedPrecondition));
  EXPECT_EQ(Reason(none), "NOTHING_TO_REDO");
}

TEST_F(EditHistoryTest, ANewEditClearsTheCallersRedo) {
  ASSERT_OK(Do("ann", Move({0}, 1)));
  ASSERT_OK(Do("ann", Undo{}));
  ASSERT_OK(Do("bob", Move({5}, 1)));  // another editor, other points: keeps ann's redo
  ASSERT_OK(Do("ann", Redo{}));
  ASSERT_OK(Do("ann", Undo{}));
  ASSERT_OK(Do("ann", Move({3}, 1)));
  EXPECT_EQ(Reason(Do("ann", Redo{})), "NOTHING_TO_REDO");
}

TEST_F(EditHistoryTest, UndoOfMineNamesWhoMovedTheSamePoints) {
  ASSERT_OK(Do("ann", Move({0, 1}, 1)));
  ASSERT_OK(Do("bob", Move({1, 2}, 1)));

  auto conflict = Do("ann", Undo{});
  EXPECT_THAT(conflict, StatusIs(absl::StatusCode::kAborted, HasSubstr("bob")));
  EXPECT_EQ(Reason(conflict), "UNDO_CONFLICT");
  EXPECT_EQ(error::DetailsOf(conflict.status()).metadata.at("editor_id"), "bob");
  EXPECT_EQ(Moved(1), 2);

  ASSERT_OK(Do("bob", Undo{}));
  ASSERT_OK(Do("ann", Undo{}));
  EXPECT_TRUE(AtStart());
}

TEST_F(EditHistoryTest, RedoNamesWhoMovedTheSamePointsMeanwhile) {
  ASSERT_OK(Do("ann", Move({0}, 1)));
  ASSERT_OK(Do("ann", Undo{}));
  ASSERT_OK(Do("bob", Move({0}, 1)));

  EXPECT_EQ(Reason(Do("ann", Redo{})), "UNDO_CONFLICT");
  ASSERT_OK(Do("bob", Undo{}));
  ASSERT_OK(Do("ann", Redo{}));
  EXPECT_EQ(Moved(0), 1);
}

TEST_F(EditHistoryTest, UndoOfTheSceneTakesTheLastStepOfAnyEditor) {
  ASSERT_OK(Do("ann", Move({0}, 1)));
  ASSERT_OK(Drag("bob", "g", {0}, 1));
  ASSERT_OK(Do("cleo", Undo{UndoScope::kScene}));
  EXPECT_EQ(Moved(0), 1);
  ASSERT_OK(Do("cleo", Undo{UndoScope::kScene}));
  EXPECT_TRUE(AtStart());
  EXPECT_EQ(Reason(Do("cleo", Undo{UndoScope::kScene})), "NOTHING_TO_UNDO");
}

TEST_F(EditHistoryTest, UndoMustBeAlone) {
  EXPECT_THAT(Apply({.editor_id = "ann", .edits = {Move({0}, 1), Undo{}}}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("edits[1].undo")));
  EXPECT_THAT(Apply({.editor_id = "ann", .gesture_id = "g", .edits = {InsertKnot{0, 0.5}}}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("edits[0].insert_knot")));
  EXPECT_TRUE(AtStart());
}

TEST_F(EditHistoryTest, InsertedKnotsComeAndGo) {
  ASSERT_OK(Do("ann", Move({0}, 1)));
  const Lattice before = history_.lattice();

  ASSERT_OK_AND_ASSIGN(auto inserted, Do("ann", InsertKnot{1, 0.5}));
  EXPECT_TRUE(inserted.structure_changed);
  EXPECT_TRUE(inserted.changed.empty());
  EXPECT_EQ(inserted.summary.structure_id, 2u);
  EXPECT_EQ(history_.lattice().control_points.size(), 80u);
  const Lattice after = history_.lattice();
  ASSERT_OK(Do("ann", Move({79}, 1)));
  ASSERT_OK(Do("ann", Undo{}));

  ASSERT_OK(Do("ann", Undo{}));
  EXPECT_EQ(history_.lattice().structure, before.structure);
  EXPECT_EQ(history_.lattice().control_points, before.control_points);
  EXPECT_EQ(history_.structure_id(), 3u);

  ASSERT_OK(Do("ann", Redo{}));
  EXPECT_EQ(history_.lattice().structure, after.structure);
  EXPECT_EQ(history_.lattice().control_points, after.control_points);
  ASSERT_OK(Do("ann", Redo{}));  // the move of point 79: its index is valid again
  EXPECT_EQ(history_.structure_id(), 4u);
}

TEST_F(EditHistoryTest, AReplacedLatticeComesAndGoes) {
  ASSERT_OK(Do("ann", Move({0}, 0.5)));
  const Lattice before = history_.lattice();
  const Lattice wanted = *FitLattice(UnitBounds(), {5, 3, 4}, {3, 1, 2}, 0.25);
  const auto replaced = Do("ann", ReplaceLattice{wanted});
  ASSERT_OK(replaced);
  EXPECT_TRUE(replaced->structure_changed);
  EXPECT_EQ(replaced->summary.drag_residual, 0);
  EXPECT_EQ(history_.structure_id(), 2);
  EXPECT_EQ(history_.lattice().structure, wanted.structure);
  EXPECT_EQ(history_.lattice().control_points, wanted.control_points);

  ASSERT_OK(Do("ann", Move({59}, 0.5)));
  ASSERT_OK(Do("ann", Reset{ResetTo::kInitial}));
  EXPECT_EQ(history_.lattice().control_points, wanted.control_points);
  ASSERT_OK(Do("ann", InsertKnot{0, 0.5}));
  ASSERT_OK(Do("ann", Reset{ResetTo::kInitial}));
  EXPECT_EQ(history_.lattice().control_points, IdentityControlPoints(history_.lattice().structure));

  for (int n = 0; n < 5; ++n) ASSERT_OK(Do("ann", Undo{}));
  EXPECT_EQ(history_.lattice().structure, before.structure);
  EXPECT_EQ(history_.lattice().control_points, before.control_points);
  ASSERT_OK(Do("ann", Redo{}));
  EXPECT_EQ(history_.lattice().structure, wanted.structure);
  EXPECT_EQ(history_.lattice().control_points, wanted.control_points);
  ASSERT_OK(Do("ann", Redo{}));
  EXPECT_NEAR(history_.lattice().control_points[59].x - wanted.control_points[59].x, 0.5, 1e-12);
}

TEST_F(EditHistoryTest, AReplacementMayKeepTheShape) {
  ASSERT_OK(Do("ann", Move({0}, 0.5)));
  const Lattice before = history_.lattice();
  ReplaceLattice finer{*FitLattice(UnitBounds(), {6, 4, 4}, {2, 2, 2}, 0), true};
  finer.lattice.control_points.clear();
  const auto kept = Do("ann", finer);  // knots 1, 2, 3 of 4 instead of 1 of 2
  ASSERT_OK(kept);
  EXPECT_LT(kept->summary.drag_residual, 1e-12);
  EXPECT_EQ(history_.lattice().structure.size[0], 6);

  finer.lattice = *FitLattice(UnitBounds(), {3, 3, 3}, {2, 2, 2}, 0);
  const auto coarser = Do("bob", finer);
  ASSERT_OK(coarser);
  EXPECT_GT(coarser->summary.drag_residual, 0.01);
  EXPECT_EQ(Reason(Do("ann", Undo{})), "UNDO_CONFLICT");
  ASSERT_OK(Do("bob", Undo{}));
  const auto again = Do("bob", Redo{});
  ASSERT_OK(again);
  EXPECT_EQ(again->summary.drag_residual, coarser->summary.drag_residual);
  ASSERT_OK(Do("bob", Undo{}));
  ASSERT_OK(Do("ann", Undo{}));
  EXPECT_EQ(history_.lattice().control_points, before.control_points);

  finer.lattice.structure.frame.origin.x = 0.125;
  EXPECT_THAT(Do("ann", finer), StatusIs(absl::StatusCode::kInvalidArgument,
                                         HasSubstr("edits[0].replace_lattice.lattice.frame")));
  EXPECT_THAT(Apply({.editor_id = "ann", .gesture_id = "g", .edits = {finer}}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("only edit of its batch")));
}

TEST_F(EditHistoryTest, CountsTheLatticeThatASmallerOneReplaces) {
  const size_t before = history_.MemoryBytes();
  ASSERT_OK(Do("ann", ReplaceLattice{*FitLattice(UnitBounds(), {2, 2, 2}, {1, 1, 1}, 0)}));
  // The base has 64 points instead of 8, and its initial lattice 64.
  EXPECT_GE(history_.MemoryBytes(), before + (56 + 64) * sizeof(Vec3d));
}

TEST_F(EditHistoryTest, AFoldedReplacementStaysTheStart) {
  const Lattice wanted = *FitLattice(UnitBounds(), {5, 3, 4}, {3, 1, 2}, 0.25);
  ASSERT_OK(Do("ann", ReplaceLattice{wanted}));
  ASSERT_OK(Do("ann", Move({3}, 0.5)));
  ASSERT_TRUE(history_.ForgetOldestStep());
  ASSERT_OK(Do("ann", Undo{}));
  EXPECT_EQ(history_.lattice().control_points, wanted.control_points);
  EXPECT_EQ(history_.initial().structure, wanted.structure);
  EXPECT_EQ(Reason(Do("ann", Undo{})), "NOTHING_TO_UNDO");
}

TEST_F(EditHistoryTest, AnInsertionStopsUndoOfWhatOthersDidBefore) {
  ASSERT_OK(Do("ann", Move({0}, 1)));
  ASSERT_OK(Drag("ann", "g", {2}, 1));
  ASSERT_OK(Do("bob", InsertKnot{0, 0.5}));
  EXPECT_FALSE(history_.gesture_open());

  EXPECT_EQ(Reason(Do("ann", Undo{})), "UNDO_CONFLICT");
}

TEST_F(EditHistoryTest, RedoAcrossAVanishedStructureIsAConflict) {
  ASSERT_OK(Do("bob", InsertKnot{0, 0.5}));
  ASSERT_OK(Do("ann", Move({79}, 1)));
  ASSERT_OK(Do("ann", Undo{}));
  ASSERT_OK(Do("bob", Undo{}));

  EXPECT_EQ(Reason(Do("ann", Redo{})), "UNDO_CONFLICT");
}

TEST_F(EditHistoryTest, TheSceneMayRefuseAStructure) {
  admission_ = error::OutOfMemory("plan", 10, 1);
  EXPECT_THAT(Do("ann", InsertKnot{0, 0.5}), StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_EQ(history_.structure_id(), 1u);
  EXPECT_EQ(history_.revision(), 0u);

  admission_ = absl::OkStatus();
  ASSERT_OK(Do("ann", InsertKnot{0, 0.5}));
  admission_ = error::OutOfMemory("plan", 10, 1);
  EXPECT_THAT(Do("ann", Undo{}), StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_EQ(history_.structure_id(), 2u);
  EXPECT_EQ(history_.lattice().control_points.size(), 80u);
}

TEST_F(EditHistoryTest, Keeps256Steps) {
  for (int n = 0; n < 300; ++n) ASSERT_OK(Do("ann", Move({0}, 1)));
  EXPECT_EQ(history_.undo_steps(), 256u);
  for (int n = 0; n < 256; ++n) ASSERT_OK(Do("ann", Undo{}));
  EXPECT_EQ(Moved(0), 44);
  EXPECT_EQ(Reason(Do("ann", Undo{})), "NOTHING_TO_UNDO");
}

TEST_F(EditHistoryTest, AFoldedInsertionStaysTheBase) {
  ASSERT_OK(Do("ann", InsertKnot{0, 0.5}));
  for (int n = 0; n < 256; ++n) ASSERT_OK(Do("ann", Move({79}, 1)));
  for (int n = 0; n < 256; ++n) ASSERT_OK(Do("ann", Undo{}));
  EXPECT_EQ(history_.lattice().control_points.size(), 80u);
  for (int n = 0; n < 256; ++n) ASSERT_OK(Do("ann", Redo{}));
  EXPECT_EQ(history_.structure_id(), 2u);
}

TEST(EditHistoryMemoryTest, Keeps64MiB) {
  Bounds bounds;
  bounds.Extend(Vec3d{0, 0, 0});
  bounds.Extend(Vec3d{1, 1, 1});
  EditHistory history(*FitLattice(bounds, {32, 32, 32}, {2, 2, 2}, 0));
  // 32,768 points of 28 bytes: 73 steps fill 64 MiB.
  for (uint64_t n = 1; n <= 100; ++n) {
    const EditBatch batch{.editor_id = "ann",
                          .sequence = n,
                          .structure_id = 1,
                          .edits = {ReplaceControlPoints{std::vector<Vec3d>(32768)}}};
    ASSERT_OK(history.Apply(batch, {}, [](const LatticeStructure&) { return absl::OkStatus(); }));
    ASSERT_LE(history.MemoryBytes(), size_t{64} << 20);
  }
  EXPECT_EQ(history.undo_steps(), 73u);
}

TEST_F(EditHistoryTest, ForgetsTheOldestStepButNeverTheNewest) {
  for (int n = 0; n < 4; ++n) ASSERT_OK(Do("ann", Move({0}, 1)));
  ASSERT_OK(Do("ann", Undo{}));
  const size_t bytes = history_.MemoryBytes();

  EXPECT_TRUE(history_.ForgetOldestStep()) << "what was undone goes first";
  EXPECT_EQ(Reason(Do("ann", Redo{})), "NOTHING_TO_REDO");
  EXPECT_TRUE(history_.ForgetOldestStep());
  EXPECT_TRUE(history_.ForgetOldestStep());
  EXPECT_FALSE(history_.ForgetOldestStep());

  EXPECT_LT(history_.MemoryBytes(), bytes);
  EXPECT_EQ(Moved(0), 3) << "what they did stays";
  ASSERT_OK(Do("ann", Undo{}));
  EXPECT_EQ(Moved(0), 2);
  EXPECT_EQ(Reason(Do("ann", Undo{})), "NOTHING_TO_UNDO");
}

TEST_F(EditHistoryTest, ForgetsTheEditorSilentLongestButNeverTheLast) {
  ASSERT_OK(Do("ann", Move({0}, 1)));
  const size_t one = history_.MemoryBytes();
  ASSERT_OK(Do("bob", Move({0}, 1)));
  EXPECT_EQ(Reason(Do("cat", Redo{})), "NOTHING_TO_REDO");
  EXPECT_GT(history_.MemoryBytes(), 2 * one) << "a refusal is kept with its words";

  EXPECT_TRUE(history_.ForgetOldestEditor());
  EXPECT_TRUE(history_.ForgetOldestEditor());
  EXPECT_FALSE(history_.ForgetOldestEditor());

  EXPECT_EQ(history_.last_sequence("ann"), 0u);
  EXPECT_EQ(history_.last_sequence("bob"), 0u);
  EXPECT_EQ(history_.last_sequence("cat"), 1u);
}

// Memory is counted by additions and removals, as steps come, change and go. In the end the count
// must be exact.
TEST_F(EditHistoryTest, CountsItsMemoryHoweverStepsComeAndGo) {
  ASSERT_OK(Do("ann", Move({0}, 1)));
  ASSERT_OK(Do("bob", Move({9}, 1)));
  ASSERT_OK(Do("ann", Undo{UndoScope::kScene}));
  ASSERT_OK(Do("bob", Undo{UndoScope::kScene}));
  while (history_.ForgetOldestStep()) continue;
  const size_t nothing = history_.MemoryBytes();

  ASSERT_OK(Drag("ann", "g", {0, 1, 2}, 1));
  ASSERT_OK(Drag("ann", "g", {3}, 2));
  ASSERT_OK(Drag("bob", "h", {7, 8}, 2));
  ASSERT_OK(End("bob", "h", GesturePhase::kCancel));
  const size_t open = history_.MemoryBytes();
  ASSERT_OK(End("ann", "g", GesturePhase::kCommit));
  EXPECT_LT(history_.MemoryBytes(), open) << "where its points began is of no use now";
  ASSERT_OK(Drag("bob", "i", {5}, 2));
  now_ += std::chrono::minutes(2);
  history_.CommitIdleGestures(now_);
  ASSERT_OK(Do("bob", InsertKnot{0, 0.37}));
  ASSERT_OK(Do("bob", Undo{}));
  ASSERT_OK(Do("bob", Redo{}));
  ASSERT_OK(Do("bob", Undo{}));
  ASSERT_OK(Do("bob", Move({4}, 1)));  // nothing to redo
  ASSERT_OK(Do("ann", Undo{}));
  ASSERT_OK(Do("ann", Redo{}));
  ASSERT_OK(Do("ann", Move({2}, 1)));
  EXPECT_GT(history_.MemoryBytes(), nothing);
  while (history_.undo_steps() > 0) ASSERT_OK(Do("bob", Undo{UndoScope::kScene}));
  while (history_.ForgetOldestStep()) continue;

  EXPECT_EQ(history_.MemoryBytes(), nothing);
}

// Two editors edit at random. Undoing the whole scene must restore the start, bit for bit.
TEST_F(EditHistoryTest, UndoingAllOfARandomSessionRestoresTheStart) {
  constexpr uint64_t kSeed = 42;
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  const auto below = [&](uint64_t n) { return random() % n; };
  int applied = 0;
  for (int n = 0; n < 200; ++n) {
    const std::string editor = below(2) == 0 ? "ann" : "bob";
    const auto point = static_cast<uint32_t>(below(6));
    const double x = static_cast<double>(below(100)) / 7;
    const auto revision = history_.revision();
    absl::StatusOr<EditOutcome> outcome;
    switch (below(6)) {
      case 0:
        outcome = Do(editor, Undo{below(2) == 0 ? UndoScope::kMine : UndoScope::kScene});
        break;
      case 1:
        outcome = Do(editor, Redo{});
        break;
      case 2:
        outcome = End(editor, "g", GesturePhase::kCancel);
        break;
      case 3:
        outcome = Do(editor, Move({point, 7}, x));
        break;
      case 4:
        outcome = Drag(editor, "g", {point, 8}, x, GesturePhase::kCommit);
        break;
      default:
        outcome = Drag(editor, "g", {point, point + 1}, x);
        break;
    }
    ASSERT_EQ(history_.revision(), revision + (outcome.ok() ? 1 : 0));
    applied += outcome.ok() ? 1 : 0;
  }
  EXPECT_GT(applied, 100);
  while (history_.undo_steps() > 0) ASSERT_OK(Do("ann", Undo{UndoScope::kScene}));
  EXPECT_TRUE(AtStart());
}

TEST_F(EditHistoryTest, ABareCommitLeavesWhatWasUndoneToRedo) {
  ASSERT_OK(Do("alice", Move({5}, 1.0)));
  ASSERT_OK(Do("alice", Undo{UndoScope::kMine}));
  ASSERT_TRUE(AtStart());

  ASSERT_OK(End("alice", "drag", GesturePhase::kCommit));
  ASSERT_OK(Do("alice", Redo{}));

  EXPECT_EQ(Moved(5), 1.0);
}

}  // namespace
}  // namespace latticed
