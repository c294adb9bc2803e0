// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lattices that edits add to a scene: as if it had been created with them, with undo, deltas and restarts.
#include <map>

#include "tests/server/lattices/several_fixture.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

constexpr char kBoth[] = "both-scene";  // created with both lattices

class AddedLatticesTest : public SeveralLatticesTest {
 protected:
  static v1::EditBatch Add(uint32_t number, uint64_t sequence, const v1::Lattice& lattice,
                           uint64_t structure_id = 1) {
    v1::EditBatch batch = MoveIn(number, sequence, 0, {});
    *batch.mutable_edits(0)->mutable_replace_lattice()->mutable_lattice() = lattice;
    batch.set_structure_id(structure_id);
    return batch;
  }
  static v1::EditBatch At(uint64_t structure_id, v1::EditBatch batch) {
    batch.set_structure_id(structure_id);
    return batch;
  }
};

TEST_F(AddedLatticesTest, TheSceneIsAsIfCreatedWithThem) {
  const v1::Lattice one = Shaken(Whole()), other = Shaken(Spot({1, 2, 3}));
  ASSERT_OK(Create(RequestOf({one})));
  ASSERT_OK(Create(RequestOf({one, other}, kBoth)));
  v1::EditResult result;
  ASSERT_OK(Apply(Add(1, 1, other), &result));
  EXPECT_EQ(result.structure_id(), 2u);
  EXPECT_EQ(Get().lattices_size(), 2);
  const std::vector<Vec3d> world = SomePoints(100);
  EXPECT_EQ(Evaluate(world), Evaluate(world, kBoth));
  EXPECT_EQ(Get().patches(), Get(kBoth).patches());
  EXPECT_EQ(LatticeAt(1).lattice().SerializeAsString(), [&] {
    auto request = For<v1::GetLatticeRequest>(kBoth);
    request.set_lattice(1);
    v1::LatticeState state;
    EXPECT_OK(Call(&Scenes::GetLattice, request, &state));
    return state.lattice().SerializeAsString();
  }());
  // Sent again, it adds no other.
  v1::EditResult again;
  ASSERT_OK(Apply(Add(1, 1, other), &again));
  EXPECT_EQ(again.revision(), 1u);
  EXPECT_EQ(Get().lattices_size(), 2);
}

TEST_F(AddedLatticesTest, UndoTakesItAwayAndRedoBack) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole())})));
  const auto before = Chunks();
  ASSERT_OK(Apply(Add(1, 1, Shaken(Spot()))));
  const std::string lattice = LatticeAt(1).lattice().SerializeAsString();
  const auto added = Chunks();

  v1::EditBatch undo = At(2, UndoMine("ann", 2));
  undo.set_lattice(1);
  ASSERT_OK(Apply(undo));

  EXPECT_TRUE(Chunks() == before);
  EXPECT_EQ(Get().lattices_size(), 1);
  EXPECT_EQ(Get().structure_id(), 3u);
  undo.set_sequence(3);
  undo.set_structure_id(3);
  ExpectRefused(Apply(undo), Code::kFailedPrecondition, "NOTHING_TO_UNDO");
  ExpectRefused(Apply(At(3, MoveIn(1, 4, 0, {}))), Code::kFailedPrecondition, "LATTICE_REMOVED");
  v1::EditBatch redo = At(3, MoveIn(1, 5, 0, {}));
  redo.mutable_edits(0)->mutable_redo();
  ASSERT_OK(Apply(redo));
  EXPECT_TRUE(Chunks() == added);
  EXPECT_EQ(LatticeAt(1).lattice().SerializeAsString(), lattice);
}

TEST_F(AddedLatticesTest, AWatcherFollowsThem) {
  ASSERT_OK(Create(RequestOf({Whole()})));
  WatchClient watcher(*scenes_, RawWatch());
  watcher.ReadUpdates(1);
  EXPECT_TRUE(watcher.log.others.empty());

  ASSERT_OK(Apply(Add(1, 1, Spot())));
  watcher.ReadUntilRevision(1);
  ASSERT_EQ(watcher.log.others.size(), 1u);
  EXPECT_EQ(watcher.log.lattice.structure_id(), 2u);
  ASSERT_OK(Apply(At(2, MoveIn(1, 2, 21, {0.05, 0, 0}))));
  watcher.ReadUntilRevision(2);

  EXPECT_EQ(watcher.log.deltas, 1u);
  EXPECT_EQ(watcher.log.others.at(1).lattice().SerializeAsString(),
            LatticeAt(1).lattice().SerializeAsString());
}

TEST_F(AddedLatticesTest, ARestartKeepsThem) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole())})));
  ASSERT_OK(Apply(MoveIn(0, 1, 42, {0, 0.1, 0})));
  ASSERT_OK(Apply(Add(1, 2, Shaken(Spot()))));
  ASSERT_OK(Apply(At(2, Add(2, 3, Shaken(Whole({1, 1, 1}))))));
  ASSERT_OK(Apply(At(3, MoveIn(1, 4, 21, {0.05, 0, 0}))));
  const auto before = Chunks();

  for (int i = 0; i < 2; ++i) {  // from records, then from a snapshot
    Restart();
    EXPECT_TRUE(Chunks() == before);
    EXPECT_EQ(Get().lattices_size(), 3);
    EXPECT_EQ(Get().revision(), 4u);
  }
  v1::EditBatch undo = At(3, UndoMine("ann", 5));
  undo.set_lattice(1);
  ASSERT_OK(Apply(undo));
  EXPECT_FALSE(Chunks() == before);
}

// Each history has results of many editors, and moves when another lattice joins it.
TEST_F(AddedLatticesTest, ManyEditorsAreRememberedAlsoAfterARestart) {
  ASSERT_OK(Create(RequestOf({Whole()})));
  const std::vector<std::string> editors{"ann",  "bob", "carol",
                                         "dave", "eve", "a longer name than fits"};
  std::map<std::string, uint64_t> sequences;
  std::map<std::string, uint64_t> revisions;  // of the last batch of each
  std::map<std::string, v1::EditBatch> batches;
  const auto move_in = [&](uint32_t lattice) {
    for (const std::string& editor : editors) {
      v1::EditBatch batch = MoveIn(lattice, ++sequences[editor], 21, {0.01, 0, 0});
      batch.set_editor_id(editor);
      batch.set_structure_id(Get().structure_id());
      v1::EditResult result;
      ASSERT_OK(Apply(batch, &result));
      revisions[editor] = result.revision();
      batches[editor] = batch;
    }
  };
  const auto expect_repeated = [&] {
    const uint64_t revision = Get().revision();
    for (const std::string& editor : editors) {
      v1::EditResult result;
      ASSERT_OK(Apply(batches[editor], &result));
      EXPECT_EQ(result.revision(), revisions[editor]) << editor;
      v1::EditBatch late = batches[editor];
      late.set_sequence(late.sequence() - 1);
      late.set_lattice(0);
      if (late.sequence() > 0) {
        ExpectRefused(Apply(late), Code::kAborted, "OUT_OF_ORDER");
      }
    }
    EXPECT_EQ(Get().revision(), revision);
  };
  move_in(0);
  for (uint32_t k = 1; k < 5; ++k) {
    ASSERT_OK(Apply(Add(k, ++sequences["ann"], Shaken(Whole({1, 1, 1})), k)));
    for (uint32_t lattice = 0; lattice <= k; ++lattice) move_in(lattice);
    expect_repeated();
  }
  Restart();
  expect_repeated();
  move_in(2);
  Restart();
  expect_repeated();
  for (const std::string& editor : editors) {
    v1::WatchRequest watch = For<v1::WatchRequest>();
    watch.set_editor_id(editor);
    WatchClient watcher(*scenes_, watch);
    watcher.ReadUpdates(1);
    EXPECT_EQ(watcher.log.ends.back().applied_sequence(), sequences[editor]) << editor;
  }
}

TEST_F(AddedLatticesTest, OfTwoWhoAddAtOnceOneIsTold) {
  ASSERT_OK(Create(RequestOf({Whole()})));
  v1::EditBatch bobs = Add(1, 1, Spot());
  bobs.set_editor_id("bob");
  ASSERT_OK(Apply(Add(1, 1, Whole())));
  ExpectRefused(Apply(bobs), Code::kAborted, "STRUCTURE_CHANGED");
  EXPECT_EQ(Get().lattices_size(), 2);
  EXPECT_EQ(LatticeAt(1).lattice().frame().origin().x(), -0.1);
}

TEST_F(AddedLatticesTest, WhatCannotBeAddedChangesNothing) {
  ASSERT_OK(Create(RequestOf({Whole()})));
  v1::Lattice turned = TurnedSpot();
  turned.clear_outside();
  ExpectRefused(Apply(Add(1, 1, turned)), Code::kInvalidArgument, "INVALID_FIELD",
                "lattices[1].outside");
  ExpectRefused(Apply(Add(1, 2, HalfLattice())), Code::kInvalidArgument, "INVALID_FIELD",
                "lattices[1].outside");
  ExpectRefused(Apply(Add(2, 3, Whole())), Code::kInvalidArgument, "OUT_OF_RANGE", "lattice");
  ExpectRefused(Apply(Add(1, 4, Whole(), 7)), Code::kAborted, "STRUCTURE_CHANGED");
  v1::Lattice wrong = Whole();
  SetAxes(*wrong.mutable_degree(), 2, 2, 7);
  ExpectRefused(Apply(Add(1, 5, wrong)), Code::kInvalidArgument, "OUT_OF_RANGE",
                "edits[0].replace_lattice.lattice.degree.w");
  v1::EditBatch fit = Add(1, 6, Whole());
  fit.mutable_edits(0)->mutable_replace_lattice()->set_keep_shape(true);
  ExpectRefused(Apply(fit), Code::kInvalidArgument, "INVALID_FIELD",
                "edits[0].replace_lattice.keep_shape");
  v1::EditBatch gesture = Add(1, 8, Whole());
  gesture.set_gesture_id("drag");
  ExpectRefused(Apply(gesture), Code::kInvalidArgument, "INVALID_FIELD",
                "edits[0].replace_lattice");
  ExpectRefused(Apply(MoveIn(1, 7, 0, {})), Code::kInvalidArgument, "OUT_OF_RANGE", "lattice");
  EXPECT_EQ(Get().lattices_size(), 1);
  EXPECT_EQ(Get().revision(), 0u);
  EXPECT_EQ(Get().structure_id(), 1u);

  ASSERT_OK(Create(RequestOf(std::vector<v1::Lattice>(8, Whole({1, 1, 1})), kBoth)));
  v1::EditBatch ninth = Add(8, 1, Whole());
  ninth.set_scene(kBoth);
  ExpectRefused(Apply(ninth), Code::kInvalidArgument, "OUT_OF_RANGE", "lattice");
}

}  // namespace
}  // namespace latticed::testing
