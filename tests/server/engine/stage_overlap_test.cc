// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluate(k+1), encode(k) and send(k-1) at once.
#include "tests/server/engine/staged_scene.h"

namespace latticed::testing {
namespace {

using StageOverlapTest = StagedScene;

TEST_F(StageOverlapTest, EvaluatesTheNextRevisionWhileOneIsEncoded) {
  const auto client = Watch();
  const int encoded = gates().ended(Stage::kEncode);

  MoveAndHoldEncoding(kCorner);
  MoveAndWaitForEvaluation(kOtherCorner);

  EXPECT_EQ(gates().ended(Stage::kEncode), encoded) << "the revision before is still being encoded";
  EXPECT_EQ(view_->evaluations_beside(), 1u);
  gates().Open(Stage::kEncode);
  ExpectRightAtHead(*client);
}

TEST_F(StageOverlapTest, EverySlotCatchesUpWithWhatWasEvaluatedInTheOther) {
  const auto client = Watch();

  for (int turn = 0; turn < 6; ++turn) {
    MoveAndHoldEncoding(turn % 2 == 0 ? kCorner : kOtherCorner);
    MoveAndWaitForEvaluation(turn % 3 == 0 ? kCorner : kOtherCorner);
    gates().Open(Stage::kEncode);
    client->RunToUpdate();
    EXPECT_GT(client->updates().back().begin.chunk_count, 0u) << "the edits show";
    ExpectRight(*client);
    ExpectRightAtHead(*client);
  }

  EXPECT_EQ(view_->evaluations_beside(), 6u);
}

TEST_F(StageOverlapTest, OneUpdateIsSentAnotherEncodedAThirdEvaluated) {
  const auto fast = Watch();
  const auto slow = Watch();
  Move(kCorner);
  while (!slow->watcher().update_in_progress()) {
    if (!slow->Step()) slow->bell().Wait(absl::Milliseconds(10));
  }
  fast->RunToHead();

  MoveAndHoldEncoding(kOtherCorner);
  while (fast->Step()) continue;
  gates().Close(Stage::kEvaluate);
  const int begun = gates().begun(Stage::kEvaluate);
  Move(kCorner);
  ASSERT_TRUE(gates().WaitForBegun(Stage::kEvaluate, begun + 1));
  slow->RunToUpdate();

  EXPECT_EQ(slow->updates().back().end.revision, 1u);
  gates().Open(Stage::kEvaluate);
  gates().Open(Stage::kEncode);
  ExpectRight(*slow);
  ExpectRightAtHead(*fast);
  ExpectRightAtHead(*slow);
}

TEST_F(StageOverlapTest, NothingIsEvaluatedBesideWhileTheReaderIsBusy) {
  const auto client = Watch();
  Move(kCorner);
  while (!client->watcher().update_in_progress()) {
    if (!client->Step()) client->bell().Wait(absl::Milliseconds(10));
  }
  MoveAndHoldEncoding(kCorner);
  const uint64_t evaluations = view_->evaluations();

  Move(kOtherCorner);
  absl::SleepFor(kAWhile);

  EXPECT_EQ(view_->evaluations(), evaluations);
  gates().Open(Stage::kEncode);
  ExpectRightAtHead(*client);
}

TEST_F(StageOverlapTest, NothingIsEvaluatedBesideBeforeTheLastBatchIsEncoded) {
  MakeScene(96, 1);
  const auto client = Watch();
  ASSERT_GT(scene_->State()->plan->chunk_count(), 2 * 256u);
  const int begun = gates().begun(Stage::kEncode);
  gates().Close(Stage::kEncode);
  Move(kCorner, {40, 0, 0});  // out of the box: all chunks
  ASSERT_TRUE(gates().WaitForBegun(Stage::kEncode, begun + 1));
  const uint64_t evaluations = view_->evaluations();

  Move(kOtherCorner);
  absl::SleepFor(kAWhile);

  EXPECT_EQ(view_->evaluations(), evaluations);
  gates().Open(Stage::kEncode);
  ExpectRightAtHead(*client);
}

TEST_F(StageOverlapTest, ANewBoxIsEvaluatedWholeBesideTheOldOne) {
  const auto client = Watch();
  MoveAndHoldEncoding(kCorner);
  const int ended = gates().ended(Stage::kEvaluate);

  Move(kOtherCorner, {40, 0, 0});

  EXPECT_TRUE(gates().WaitForEnded(Stage::kEvaluate, ended + 1));
  gates().Open(Stage::kEncode);
  ExpectRightAtHead(*client);
  EXPECT_EQ(client->quantisations(), 2u);
}

TEST_F(StageOverlapTest, AnotherStructureWaitsForTheEncodingAndTakesTheMemoryOfBothSlots) {
  const auto client = Watch();
  MoveAndHoldEncoding(kCorner);
  MoveAndWaitForEvaluation(kOtherCorner);
  gates().Open(Stage::kEncode);
  ExpectRightAtHead(*client);
  MoveAndHoldEncoding(kCorner);
  const uint64_t evaluations = view_->evaluations();

  Apply(KnotBatch(*scene_, "alice", ++sequence_, 0, 0.37));
  absl::SleepFor(kAWhile);

  EXPECT_EQ(view_->evaluations(), evaluations);
  gates().Open(Stage::kEncode);
  ExpectRightAtHead(*client);
  // The same numbers are other points now, in the middle.
  MoveAndHoldEncoding(kOtherCorner);
  MoveAndWaitForEvaluation(kOtherCorner + 1);
  gates().Open(Stage::kEncode);
  ExpectRightAtHead(*client);
}

TEST_F(StageOverlapTest, TheMemoryOfBothSlotsIsTheDevices) {
  const auto client = Watch();
  const uint64_t vertices = view_->memory().at("vertices");
  const uint64_t reserved = budget_->used_bytes();

  MoveAndHoldEncoding(kCorner);
  MoveAndWaitForEvaluation(kOtherCorner);
  gates().Open(Stage::kEncode);
  ExpectRightAtHead(*client);

  EXPECT_EQ(view_->memory().at("vertices"), 2 * vertices);
  EXPECT_EQ(budget_->used_bytes(), reserved) << "of the host";
  MoveAndHoldEncoding(kCorner);
  MoveAndWaitForEvaluation(kOtherCorner);
  gates().Open(Stage::kEncode);
  ExpectRightAtHead(*client);
  EXPECT_EQ(view_->memory().at("vertices"), 2 * vertices) << "the same two";
}

TEST_F(StageOverlapTest, WhatRoundsToTheSameIntegersIsNotEncoded) {
  const auto client = Watch();
  const int all = static_cast<int>(scene_->State()->plan->chunk_count());
  ASSERT_EQ(gates().encoded_chunks(), all);
  const double step = scene_->State()->box.step(options_.view.key.spec.position_bits);

  Move(kCorner, {1e-12 * step, 0, 0});
  client->RunToHead();

  EXPECT_EQ(gates().encoded_chunks(), all);
  EXPECT_EQ(client->updates().back().begin.chunk_count, 0u);
  EXPECT_EQ(client->updates().back().end.revision, 1u) << "which is covered all the same";
  ExpectRight(*client);
}

TEST_F(StageOverlapTest, WhatAnotherWriterHasEncodedIsEncodedOnceMoreAndNotSent) {
  const auto client = Watch();
  const double step = scene_->State()->box.step(options_.view.key.spec.position_bits);
  const int at_first = gates().encoded_chunks();

  gates().ChangeDigests();
  Move(kCorner, {1e-12 * step, 0, 0});
  client->RunToHead();
  const int once_more = gates().encoded_chunks();
  Move(kCorner, {1e-12 * step, 0, 0});
  client->RunToHead();

  EXPECT_GT(once_more, at_first);
  EXPECT_EQ(gates().encoded_chunks(), once_more);
  for (size_t i = 1; i < client->updates().size(); ++i) {
    EXPECT_EQ(client->updates()[i].begin.chunk_count, 0u);
  }
  EXPECT_EQ(client->updates().back().end.revision, 2u);
  ExpectRight(*client);
}

TEST_F(StageOverlapTest, OnlyChunksWhoseIntegersChangedAreEncodedWhicheverSlotHasThem) {
  const auto client = Watch();

  for (int turn = 0; turn < 4; ++turn) {
    MoveAndHoldEncoding(turn % 2 == 0 ? kCorner : kOtherCorner);
    MoveAndWaitForEvaluation(turn % 2 == 0 ? kCorner : kOtherCorner);
    const int encoded = gates().encoded_chunks();
    gates().Open(Stage::kEncode);
    client->RunToHead();
    const int encoded_now = gates().encoded_chunks();

    // Two revisions, each against the one before, whose vertices were in the other slot.
    const uint64_t head = scene_->State()->revision;
    int changed = 0;
    for (const uint64_t revision : {head - 1, head}) {
      const auto before = EvaluateAfresh(*states_.at(revision - 1), *client->view());
      const auto after = EvaluateAfresh(*states_.at(revision), *client->view());
      for (size_t c = 0; c < after.size(); ++c) changed += before[c] == after[c] ? 0 : 1;
    }
    EXPECT_GT(changed, 0);
    EXPECT_EQ(encoded_now - encoded, changed);
    ExpectRight(*client);
  }

  EXPECT_EQ(view_->evaluations_beside(), 4u);
}

class HostStagesTest : public StagedScene {
 protected:
  HostStagesTest() : StagedScene(/*on_device=*/false) {}
};

TEST_F(HostStagesTest, FollowEachOtherInOneSlot) {
  const auto client = Watch();
  const uint64_t vertices = view_->memory().at("vertices");
  MoveAndHoldEncoding(kCorner);
  const uint64_t evaluations = view_->evaluations();

  Move(kOtherCorner);
  absl::SleepFor(kAWhile);

  EXPECT_EQ(view_->evaluations(), evaluations);
  gates().Open(Stage::kEncode);
  ExpectRightAtHead(*client);
  EXPECT_EQ(view_->memory().at("vertices"), vertices);
}

}  // namespace
}  // namespace latticed::testing
