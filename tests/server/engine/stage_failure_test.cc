// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What of two overlapping stages is refused, fails, or is wanted no more.
#include "core/base/error.h"
#include "tests/server/engine/staged_scene.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

using StageFailureTest = StagedScene;

// For want of what no waiting brings: where it is memory, the call is tried again (residency.h).
absl::Status Refusal() { return error::LimitExceeded("slots", 1); }

class RefusedSlotTest : public StageFailureTest, public ::testing::WithParamInterface<Stage> {};

TEST_P(RefusedSlotTest, OneSlotDoesWhereTheBackendRefusesTwo) {
  const auto client = Watch();
  MoveAndHoldEncoding(kCorner);
  const int begun = gates().begun(GetParam());
  gates().FailNext(GetParam(), Refusal());

  Move(kOtherCorner);
  ASSERT_TRUE(gates().WaitForEnded(GetParam(), begun + 1));
  gates().Open(Stage::kEncode);

  ExpectRightAtHead(*client);
  EXPECT_OK(view_->failure());
  MoveAndHoldEncoding(kCorner);
  const uint64_t evaluations = view_->evaluations();
  Move(kOtherCorner);
  absl::SleepFor(kAWhile);
  EXPECT_EQ(view_->evaluations(), evaluations) << "it is not tried again";
  gates().Open(Stage::kEncode);
  ExpectRightAtHead(*client);
  const auto another = Watch();
  MoveAndHoldEncoding(kCorner);
  MoveAndWaitForEvaluation(kOtherCorner);
  EXPECT_GT(view_->evaluations_beside(), 0u) << "a new watcher is a new try";
}

INSTANTIATE_TEST_SUITE_P(Stages, RefusedSlotTest,
                         ::testing::Values(Stage::kCreateView, Stage::kEvaluate),
                         [](const auto& stage) {
                           return std::string(stage.param == Stage::kEvaluate ? "Evaluate"
                                                                              : "CreateView");
                         });

TEST_F(StageFailureTest, WhatIsRefusedForWantOfMemoryIsTriedAgain) {
  const auto client = Watch();
  for (const Stage stage : {Stage::kEvaluate, Stage::kEncode}) {
    gates().FailNext(stage, error::OutOfMemory("the stage", 2, 1));
    Move(kCorner);
    client->RunToUpdate();
    ExpectRightAtHead(*client);
  }

  EXPECT_OK(view_->failure());
  EXPECT_EQ(client->updates().size(), 3u) << "the first one's, and one of each edit";
}

TEST_F(StageFailureTest, TheNextUpdateHoldsWhatCouldNotBeEncoded) {
  const auto client = Watch();
  MoveAndHoldEncoding(kCorner);
  MoveAndWaitForEvaluation(kOtherCorner);
  gates().FailNext(Stage::kEncode, Refusal());

  gates().Open(Stage::kEncode);
  client->RunToUpdate();

  EXPECT_OK(view_->failure());
  EXPECT_EQ(client->updates().back().end.revision, 2u) << "the first of them was given up";
  ExpectRight(*client);
  Move(kCorner);
  ExpectRightAtHead(*client);
}

TEST_F(StageFailureTest, AFailedEncodingEndsTheWatchersAndTheNextOneBeginsAfresh) {
  const auto client = Watch();
  MoveAndHoldEncoding(kCorner);
  MoveAndWaitForEvaluation(kOtherCorner);
  gates().FailNext(Stage::kEncode, absl::InternalError("no such luck"), 2);

  gates().Open(Stage::kEncode);
  while (client->status().ok()) {
    if (!client->Step()) client->bell().Wait(absl::Milliseconds(10));
  }

  EXPECT_THAT(client->status(), StatusIs(absl::StatusCode::kInternal));
  EXPECT_EQ(client->updates().back().end.revision, 0u);
  const auto another = Watch();
  ExpectRight(*another);
}

TEST_F(StageFailureTest, AFailedEvaluationEndsTheWatchersAndTheNextOneBeginsAfresh) {
  const auto client = Watch();
  MoveAndHoldEncoding(kCorner);
  gates().FailNext(Stage::kEvaluate, absl::InternalError("no such luck"), 2);
  MoveAndWaitForEvaluation(kOtherCorner);

  gates().Open(Stage::kEncode);
  while (client->status().ok()) {
    if (!client->Step()) client->bell().Wait(absl::Milliseconds(10));
  }

  EXPECT_THAT(client->status(), StatusIs(absl::StatusCode::kInternal));
  const auto another = Watch();
  ExpectRightAtHead(*another);
}

TEST_F(StageFailureTest, WhatWasEvaluatedAheadForNobodyIsEncodedLater) {
  const auto client = Watch();
  MoveAndHoldEncoding(kCorner);
  MoveAndWaitForEvaluation(kOtherCorner);

  client->watcher().SetPaused(true);
  gates().Open(Stage::kEncode);
  EXPECT_TRUE(Becomes(2000, [&] { return view_->newest()->revision == 1; }));
  absl::SleepFor(kAWhile);
  EXPECT_EQ(view_->newest()->revision, 1u);
  client->watcher().SetPaused(false);

  ExpectRightAtHead(*client);
}

TEST_F(StageFailureTest, AnEvaluationThatNobodyWaitsForAnyMoreIsKept) {
  const auto client = Watch();
  MoveAndHoldEncoding(kCorner);
  gates().Close(Stage::kEvaluate);
  const int begun = gates().begun(Stage::kEvaluate);
  Move(kOtherCorner);
  ASSERT_TRUE(gates().WaitForBegun(Stage::kEvaluate, begun + 1));

  client->watcher().SetPaused(true);
  gates().Open(Stage::kEvaluate);
  ASSERT_TRUE(gates().WaitForEnded(Stage::kEvaluate, begun + 1));
  absl::SleepFor(kAWhile);
  client->watcher().SetPaused(false);
  Move(kCorner);
  gates().Open(Stage::kEncode);

  ExpectRightAtHead(*client);
}

TEST_F(StageFailureTest, AnEvaluationThatNobodyWantsBeforeItBeginsIsMadeLater) {
  const auto client = Watch();
  options_.view.key.spec.segments = 2;
  const auto second = Watch();
  options_.view.key.spec.segments = 3;
  const auto third = Watch();
  client->watcher().SetPaused(true);
  const int begun = gates().begun(Stage::kEncode);
  gates().Close(Stage::kEncode);
  Move(kCorner);
  ASSERT_TRUE(gates().WaitForBegun(Stage::kEncode, begun + 2)) << "both workers are busy";

  client->watcher().SetPaused(false);
  const auto alone = [](uint64_t) {};
  std::optional<ViewWork> work = scene_->TakeWork(kAnyPoints);
  while (work.has_value() && work->view->key() != client->watcher().key()) {
    scene_->RunWork(*std::move(work), alone);  // beside what the workers encode
    work = scene_->TakeWork(kAnyPoints);
  }
  ASSERT_TRUE(work.has_value());
  client->watcher().SetPaused(true);
  scene_->RunWork(*std::move(work), alone);
  client->watcher().SetPaused(false);
  gates().Open(Stage::kEncode);

  ExpectRightAtHead(*client);
}

TEST_F(StageFailureTest, AnEncodingThatIsStoppedLeavesItsChunksToTheNext) {
  MakeScene(96, 1);
  const auto client = Watch();
  const int begun = gates().begun(Stage::kEncode);
  gates().Close(Stage::kEncode);
  Move(kCorner, {40, 0, 0});  // out of the box: all chunks, several batches
  ASSERT_TRUE(gates().WaitForBegun(Stage::kEncode, begun + 1));

  client->watcher().SetPaused(true);
  gates().Open(Stage::kEncode);
  absl::SleepFor(kAWhile);
  EXPECT_EQ(view_->newest()->revision, 0u) << "stopped";
  Move(kOtherCorner);
  client->watcher().SetPaused(false);

  ExpectRightAtHead(*client);
}

// Blocks that are little used have no room, what is used of them has.
TEST_F(StageFailureTest, ChunksLeaveTheirBlocksBeforeAViewFailsForWantOfMemory) {
  gates().UseRoomyBlocks();
  const uint64_t vertices = VertexBytes(*scene_->State()->plan, options_.view.key);
  const uint64_t free = budget_->total_bytes() - budget_->used_bytes();
  const auto others = budget_->Reserve("others", free - vertices * 13 / 4);
  ASSERT_OK(others);

  const auto client = Watch();

  ASSERT_OK(client->status());
  EXPECT_LT(view_->newest()->held_bytes, vertices * 13 / 4);
  ExpectRight(*client);
  Move(kCorner);
  ExpectRightAtHead(*client);
}

TEST_F(StageFailureTest, WhatIsStagedForCopiesIsOfTheBudget) {
  constexpr uint64_t kStaging = uint64_t{16} << 20;
  const uint64_t before = budget_->used_bytes();
  auto client = Watch();
  const uint64_t without = budget_->used_bytes() - before;
  gates().SetStaging(kStaging);
  Move(kCorner);
  ExpectRightAtHead(*client);

  EXPECT_EQ(budget_->used_bytes() - before, without + kStaging);

  MoveAndHoldEncoding(kCorner);
  MoveAndWaitForEvaluation(kOtherCorner);
  gates().Open(Stage::kEncode);
  ExpectRightAtHead(*client);
  EXPECT_EQ(budget_->used_bytes() - before, without + 2 * kStaging) << "of both slots";
}

TEST_F(StageFailureTest, WithoutRoomForWhatIsStagedTheWatchersEnd) {
  const auto client = Watch();
  gates().SetStaging(budget_->total_bytes() - budget_->used_bytes() + 1);

  Move(kCorner);
  while (client->status().ok()) {
    if (!client->Step()) client->bell().Wait(absl::Milliseconds(10));
  }

  EXPECT_THAT(client->status(), StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_EQ(error::DetailsOf(client->status()).reason, "OUT_OF_MEMORY");
  gates().SetStaging(0);
  ExpectRightAtHead(*Watch());
}

TEST_F(StageFailureTest, ADeletedSceneEndsWithBothStagesUnderWay) {
  auto client = Watch();
  MoveAndHoldEncoding(kCorner);
  gates().Close(Stage::kEvaluate);
  const int begun = gates().begun(Stage::kEvaluate);
  Move(kOtherCorner);
  ASSERT_TRUE(gates().WaitForBegun(Stage::kEvaluate, begun + 1));

  ASSERT_OK(registry_.Delete(scene_->id()));
  EXPECT_FALSE(client->Step());
  EXPECT_THAT(client->status(), StatusIs(absl::StatusCode::kNotFound));
  client.reset();
  view_.reset();
  states_.clear();
  const std::weak_ptr<Scene> scene = std::exchange(scene_, nullptr);
  gates().Open(Stage::kEvaluate);
  gates().Open(Stage::kEncode);

  const absl::Time deadline = absl::Now() + absl::Seconds(20);
  // The worker that let go of it last may still be destroying it.
  while (budget_->used_bytes() > 0 && absl::Now() < deadline) absl::SleepFor(absl::Milliseconds(1));
  EXPECT_TRUE(scene.expired());
  EXPECT_EQ(budget_->used_bytes(), 0u);
}

}  // namespace
}  // namespace latticed::testing
