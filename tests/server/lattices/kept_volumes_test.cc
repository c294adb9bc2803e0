// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A volume that one lattice of a scene keeps, after edits of others and after replacements: parallel lattices and turned ones.
#include <cmath>
#include <string>
#include <vector>

#include "tests/server/lattices/removed_fixture.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

constexpr double kVolumeSlack = 1e-12 + 4e-16;  // and rounding
constexpr double kMoved = 1e-5;                 // of the volume: an edit that nothing follows

class KeptVolumesTest : public RemovedLatticesTest, public ::testing::WithParamInterface<bool> {
 protected:
  v1::Lattice Other() const { return GetParam() ? TurnedSpot() : Spot(); }
  v1::EditBatch Keep(uint32_t number) {
    v1::EditBatch batch = Batch(number);
    batch.add_edits()->mutable_set_constraints()->mutable_constraints()->mutable_volume();
    return batch;
  }
  v1::EditBatch Strength(uint32_t number, double strength) {
    v1::EditBatch batch = Batch(number);
    batch.add_edits()->mutable_set_strength()->set_strength(strength);
    return batch;
  }
  v1::EditBatch Weigh() {
    const std::vector<float> weights{1, 0.5F, 1, 1, 0.25F, 1, 1, 0.75F};
    v1::EditBatch batch = Batch(0);
    batch.add_edits()->mutable_set_weights()->set_values(
        reinterpret_cast<const char*>(weights.data()), weights.size() * sizeof(float));
    return batch;
  }
  v1::EditBatch Update(double z, v1::GesturePhase phase = v1::GESTURE_PHASE_UPDATE) {
    v1::EditBatch batch = Push(1, 21, {0, 0, z});
    batch.set_gesture_id("g");
    batch.set_gesture_phase(phase);
    if (phase != v1::GESTURE_PHASE_UPDATE) batch.clear_edits();
    return batch;
  }
  // The volume over that at rest, minus 1.
  double Excess() { return MeasuredVolume() - 1; }
  std::string Points(uint32_t number) { return LatticeAt(number).lattice().SerializeAsString(); }
  // Applies an edit that moves lattice 0 for the volume.
  void ApplyFollowed(const v1::EditBatch& batch, const char* what) {
    SCOPED_TRACE(what);
    const std::string before = Points(0);
    ASSERT_OK(Apply(batch));
    EXPECT_LE(std::abs(Excess()), kVolumeSlack);
    EXPECT_NE(Points(0), before);
  }
};

TEST_P(KeptVolumesTest, EditsOfOtherLatticesAreFollowed) {
  ASSERT_OK(Create(RequestOf({Whole(), Other()})));
  ASSERT_OK(Apply(Push(1, 21, {0, 0, -0.1})));
  EXPECT_GT(std::abs(Excess()), kMoved);
  ASSERT_OK(Apply(Keep(0)));

  ApplyFollowed(Push(1, 25, {0, 0, -0.1}), "move");
  ApplyFollowed(Strength(1, 0.5), "strength");
  v1::Lattice wider = LatticeAt(1).lattice();
  for (int n : {0, 1, 2, 3, 5}) wider.mutable_outside()->set_widths(n, 0.6);
  wider.mutable_outside()->clear_steps();
  ApplyFollowed(Put(1, wider), "another falloff");
  ApplyFollowed(Put(2, Shaken(Other())), "an addition");
  ApplyFollowed(Push(2, 21, {0, 0, -0.1}), "move of the addition");
  ApplyFollowed(Push(0, 21, {0, 0, 0.1}), "move of its own");
  ApplyFollowed(Remove(1), "removal");
  ApplyFollowed(Weigh(), "weights");
  v1::EditBatch reset = Batch(2);
  reset.add_edits()->mutable_reset();
  ApplyFollowed(reset, "reset");
  Restart();
  EXPECT_LE(std::abs(Excess()), kVolumeSlack);
  ApplyFollowed(Push(2, 21, {0, 0, 0.1}), "after a restart");
}

TEST_P(KeptVolumesTest, UndoAndRedoTakeBothLattices) {
  ASSERT_OK(Create(RequestOf({Whole(), Other()})));
  ASSERT_OK(Apply(Keep(0)));
  ASSERT_OK(Apply(Push(0, 21, {0, 0, 0.1})));
  const std::vector<std::string> first{Points(0), Points(1)};
  ApplyFollowed(Push(1, 21, {0, 0, -0.1}), "move");
  const std::vector<std::string> second{Points(0), Points(1)};
  ApplyFollowed(Remove(1), "removal");
  const std::string third = Points(0);
  ExpectRefused(Apply(Undo(0)), Code::kAborted, "UNDO_CONFLICT");

  ASSERT_OK(Apply(Undo(1)));
  EXPECT_EQ((std::vector<std::string>{Points(0), Points(1)}), second);
  Restart();
  ASSERT_OK(Apply(Undo(1)));
  EXPECT_EQ((std::vector<std::string>{Points(0), Points(1)}), first);
  EXPECT_LE(std::abs(Excess()), kVolumeSlack);
  ASSERT_OK(Apply(Redo(1)));
  EXPECT_EQ((std::vector<std::string>{Points(0), Points(1)}), second);
  ASSERT_OK(Apply(Redo(1)));
  EXPECT_EQ(Points(0), third);
  ASSERT_OK(Apply(Undo(1)));
  ASSERT_OK(Apply(Undo(1)));
  ASSERT_OK(Apply(Undo(0)));  // nothing follows it any more
  ExpectRefused(Apply(Redo(0, "bob")), Code::kFailedPrecondition, "NOTHING_TO_REDO");
}

TEST_P(KeptVolumesTest, ARedoLeavesWhatOthersWroteSince) {
  ASSERT_OK(Create(RequestOf({Whole(), Other()})));
  ASSERT_OK(Apply(Keep(0)));
  ApplyFollowed(Push(1, 21, {0, 0, -0.1}), "move");
  ASSERT_OK(Apply(Undo(1)));
  ASSERT_OK(Apply(Push(0, 25, {0, 0, 0.1}, "bob")));
  const std::string after = Points(0);

  ASSERT_OK(Apply(Redo(1)));
  EXPECT_EQ(Points(0), after);
  ASSERT_OK(Apply(Undo(0, "bob")));
  ApplyFollowed(Push(1, 25, {0, 0, -0.1}), "the next edit");
}

TEST_P(KeptVolumesTest, AGestureIsFollowedFromItsBegin) {
  ASSERT_OK(Create(RequestOf({Whole(), Other()})));
  ASSERT_OK(Apply(Keep(0)));
  const std::vector<std::string> begin{Points(0), Points(1)};
  ApplyFollowed(Update(-0.1), "first");
  const std::string after = Points(0);
  ApplyFollowed(Update(0.05), "second");
  ApplyFollowed(Update(-0.1), "third");
  EXPECT_EQ(Points(0), after) << "rounding does not add up";
  Restart();
  ASSERT_OK(Apply(Update(0, v1::GESTURE_PHASE_CANCEL)));
  EXPECT_EQ((std::vector<std::string>{Points(0), Points(1)}), begin);

  ApplyFollowed(Update(-0.1), "first");
  ApplyFollowed(Update(0.05), "second");
  const std::string last = Points(0);
  ASSERT_OK(Apply(Update(0, v1::GESTURE_PHASE_COMMIT)));
  EXPECT_EQ(Points(0), last);
  ASSERT_OK(Apply(Undo(1)));
  EXPECT_EQ((std::vector<std::string>{Points(0), Points(1)}), begin);
}

TEST_P(KeptVolumesTest, WatchersGetTheMovesOfBoth) {
  ASSERT_OK(Create(RequestOf({Whole(), Other()})));
  ASSERT_OK(Apply(Keep(0)));
  WatchClient watcher(*scenes_, RawWatch());
  watcher.ReadUpdates(1);
  ASSERT_OK(Apply(Push(1, 21, {0, 0, -0.1})));
  watcher.ReadUntilRevision(2);
  ASSERT_OK(Apply(Undo(1)));
  watcher.ReadUntilRevision(3);
  ASSERT_OK(Apply(Redo(1)));
  watcher.ReadUntilRevision(4);
  EXPECT_EQ(watcher.log.deltas, 6u);
  EXPECT_EQ(watcher.log.lattice.lattice().SerializeAsString(), Points(0));
  EXPECT_EQ(watcher.log.others.at(1).lattice().SerializeAsString(), Points(1));
}

TEST_P(KeptVolumesTest, WhatCannotBeFollowedIsRefused) {
  ASSERT_OK(Create(RequestOf({Whole(), Other()})));
  v1::EditBatch hold = Keep(0);
  auto& constraints = *hold.mutable_edits(0)->mutable_set_constraints()->mutable_constraints();
  for (uint32_t n = 0; n < 64; ++n) constraints.add_held(n);
  ASSERT_OK(Apply(hold));
  const std::vector<std::string> before{Points(0), Points(1)};
  ExpectRefused(Apply(Push(1, 21, {0, 0, -0.1})), Code::kFailedPrecondition, "VOLUME_NOT_KEPT");
  ExpectRefused(Apply(Put(2, Shaken(Other()))), Code::kFailedPrecondition, "VOLUME_NOT_KEPT");
  EXPECT_EQ((std::vector<std::string>{Points(0), Points(1)}), before);
  EXPECT_EQ(Get().revision(), 1u);
}

TEST_P(KeptVolumesTest, TheEditedLatticeComesFirstThenTheFirstThatKeepsIt) {
  ASSERT_OK(Create(RequestOf({Whole(), Other(), Other()})));
  ASSERT_OK(Apply(Keep(1)));
  ASSERT_OK(Apply(Keep(0)));
  const std::string first = Points(0);
  ASSERT_OK(Apply(Push(1, 21, {0, 0, -0.1})));
  EXPECT_LE(std::abs(Excess()), kVolumeSlack);
  EXPECT_EQ(Points(0), first);
  const std::string second = Points(1);
  ApplyFollowed(Push(2, 21, {0, 0, -0.1}), "move of the third");
  EXPECT_EQ(Points(1), second);
}

TEST_P(KeptVolumesTest, AReplacementKeepsItsOwn) {
  const v1::Lattice falloff = GetParam() ? TurnedSpot() : Spot();
  ASSERT_OK(Create(RequestOf({falloff})));
  ASSERT_OK(Apply(Keep(0)));
  ASSERT_OK(Apply(Push(0, 21, {0, 0, -0.1})));
  const std::string before = Points(0);
  v1::Lattice next = falloff;
  for (int n : {0, 1, 2, 3, 5}) next.mutable_outside()->set_widths(n, 0.6);
  for (const int size : {4, 5}) {
    SetAxes(*next.mutable_size(), size, size, size);
    v1::EditBatch batch = Put(0, next);
    batch.mutable_edits(0)->mutable_replace_lattice()->set_keep_shape(true);
    ASSERT_OK(Apply(batch));
    EXPECT_LE(std::abs(Excess()), kVolumeSlack) << size;
    EXPECT_TRUE(LatticeAt(0).constraints().has_volume());
  }
  ASSERT_OK(Apply(Undo(0)));
  ASSERT_OK(Apply(Undo(0)));
  EXPECT_EQ(Points(0), before);
  EXPECT_LE(std::abs(Excess()), kVolumeSlack);
}

INSTANTIATE_TEST_SUITE_P(ParallelAndTurned, KeptVolumesTest, ::testing::Bool());

}  // namespace
}  // namespace latticed::testing
