// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Watchers that are sent no more than they acknowledge, on the CPU backend and as if that were a device.
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "absl/time/clock.h"
#include "tests/server/engine/staged_scene.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

class AcknowledgementTest : public StagedScene, public ::testing::WithParamInterface<bool> {
 protected:
  AcknowledgementTest() : StagedScene(GetParam()) {}

  // Has the first update, and has acknowledged nothing.
  std::unique_ptr<WatcherClient> WatchUnacked(size_t most) {
    options_.max_unacked_updates = most;
    auto client = std::make_unique<WatcherClient>(scene_, options_);
    client->RunToUpdate();
    view_ = *scene_->AcquireView(client->watcher().view().key);
    return client;
  }
  // Acknowledges update `id`, and is sent `revision` next.
  void AckAndExpect(WatcherClient& client, uint64_t id, uint64_t revision) {
    ASSERT_OK(client.watcher().Ack(id));
    client.RunToUpdate();
    EXPECT_EQ(client.updates().back().end.revision, revision);
    ExpectRight(client);
  }
};

TEST_P(AcknowledgementTest, NoMoreThanTheUnackedUpdatesAreBegun) {
  const auto client = WatchUnacked(2);
  Move(kCorner);
  client->RunToUpdate();
  Move(kCorner);
  absl::SleepFor(kAWhile);
  while (client->Step()) continue;

  EXPECT_EQ(client->updates().size(), 2u);
  EXPECT_THAT(client->watcher().Ack(3), StatusIs(absl::StatusCode::kInvalidArgument));
  AckAndExpect(*client, 1, 2);
}

TEST_P(AcknowledgementTest, WhatFollowsIsTheNewestAndNothingIsEvaluatedBefore) {
  const auto client = WatchUnacked(1);
  const uint64_t evaluations = view_->evaluations();
  Move(kCorner);
  absl::SleepFor(kAWhile);
  Move(kOtherCorner);
  while (client->Step()) continue;
  EXPECT_EQ(view_->evaluations(), evaluations);

  AckAndExpect(*client, 1, 2);
  EXPECT_EQ(view_->evaluations(), evaluations + 1);
}

TEST_P(AcknowledgementTest, AnotherWatcherIsSentEveryRevisionMeanwhile) {
  const auto slow = WatchUnacked(1);
  const auto quick = WatchUnacked(0);
  for (uint64_t revision = 1; revision <= 3; ++revision) {
    Move(kCorner);
    quick->RunToUpdate();
    EXPECT_EQ(quick->updates().back().end.revision, revision);
  }
  while (slow->Step()) continue;
  EXPECT_EQ(slow->updates().size(), 1u);

  AckAndExpect(*slow, 1, 3);
}

TEST_P(AcknowledgementTest, NothingIsEvaluatedBesideAnEncodingThatMustBeAcknowledgedFirst) {
  const auto client = WatchUnacked(1);
  ASSERT_OK(client->watcher().Ack(1));
  while (client->Step()) continue;
  MoveAndHoldEncoding(kCorner);
  const uint64_t evaluations = view_->evaluations();

  Move(kOtherCorner);
  while (client->Step()) continue;
  absl::SleepFor(kAWhile);
  gates().Open(Stage::kEncode);
  client->RunToUpdate();
  absl::SleepFor(kAWhile);

  EXPECT_EQ(client->updates().back().end.revision, 1u);
  EXPECT_EQ(view_->evaluations(), evaluations);
  Move(kCorner);
  AckAndExpect(*client, 2, 3);
  EXPECT_EQ(view_->evaluations(), evaluations + 1);
}

TEST_P(AcknowledgementTest, WhatWasEvaluatedForAnotherMakesOneUpdateOldAndNotAllThatFollow) {
  const auto slow = WatchUnacked(1);
  auto quick = WatchUnacked(0);
  Move(kCorner);
  quick->RunToUpdate();
  quick = nullptr;
  Move(kOtherCorner);
  while (view_->newest()->revision < 2) absl::SleepFor(absl::Milliseconds(1));
  Move(kCorner);
  AckAndExpect(*slow, 1, 2);

  const uint64_t evaluations = view_->evaluations();
  Move(kOtherCorner);
  absl::SleepFor(kAWhile);
  EXPECT_EQ(view_->evaluations(), evaluations);
  AckAndExpect(*slow, 2, 4);
}

INSTANTIATE_TEST_SUITE_P(Stages, AcknowledgementTest, ::testing::Bool(), [](const auto& on_device) {
  return std::string(on_device.param ? "Overlap" : "FollowEachOther");
});

}  // namespace
}  // namespace latticed::testing
