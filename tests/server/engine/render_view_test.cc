// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The stages of a view, on one thread: the test acts as the worker and controls the backend.
#include "server/engine/render/render_view.h"

#include <algorithm>
#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include "absl/time/clock.h"
#include "core/base/error.h"
#include "tests/server/engine/render_view_fixture.h"

namespace latticed::testing {
namespace {

using Stage = RenderView::Stage;

TEST_F(RenderViewTest, NothingIsEvaluatedForNobody) {
  const auto view = scene_->AcquireView(options_.view.key);
  ASSERT_OK(view);
  Move(kCorner);
  EXPECT_FALSE(RunTurn()) << "not watched";

  const auto client = Watch();
  client->watcher().SetPaused(true);
  Move(kCorner);
  EXPECT_FALSE(RunTurn()) << "paused";
  client->watcher().SetSilent(true);
  client->watcher().SetPaused(false);
  Move(kCorner);
  EXPECT_FALSE(RunTurn()) << "silent";
  while (client->Step()) continue;
  EXPECT_EQ(client->lattice_revision(), 3u) << "the cage goes on";

  client->watcher().SetSilent(false);
  ExpectRightAtHead(*client);
}

TEST_F(RenderViewTest, ASnapshotAheadOfTheReaderIsTheLastUntilItIsTaken) {
  const auto client = Watch();
  Move(kCorner);
  client->RunIntoUpdate();
  Move(kCorner);
  EXPECT_TRUE(RunTurn()) << "while the update before it is sent";
  Move(kOtherCorner);
  EXPECT_FALSE(RunTurn()) << "it would be old when the reader comes";

  ExpectRightAtHead(*client);
  EXPECT_EQ(client->updates().size(), 4u);
}

TEST_F(RenderViewTest, EditsDuringEachStageAreInTheNextUpdate) {
  const auto client = Watch();
  for (const Step step : {Step::kEvaluate, Step::kEncode}) {
    Move(kCorner);
    script().DuringNext(step, [&] {
      EXPECT_FALSE(RunTurn()) << "one turn at a time";
      Move(kOtherCorner);
    });
    client->RunToUpdate();
    EXPECT_EQ(client->updates().back().end.revision + 1, scene_->State()->revision);
    ExpectRightAtHead(*client);
  }
}

TEST_F(RenderViewTest, ATurnThatNobodyWaitsForAnyMoreLeavesItsChunksToTheNext) {
  MakeScene(96, 1);
  ASSERT_GT(scene_->State()->plan->chunk_count(), 2 * 256u) << "encoded in several batches";
  const auto client = Watch();
  const auto view = *scene_->AcquireView(options_.view.key);
  for (const Step step : {Step::kEvaluate, Step::kEncode}) {
    const uint64_t revision = scene_->State()->revision;
    script().DuringNext(step, [&] { client->watcher().SetPaused(true); });
    Move(kCorner, {step == Step::kEvaluate ? 40.0 : -40.0, 0, 0});  // a new box: all chunks
    EXPECT_TRUE(RunTurn());
    EXPECT_EQ(view->newest()->revision, revision) << "stopped";

    Move(kOtherCorner);
    client->watcher().SetPaused(false);
    ExpectRightAtHead(*client);
  }
}

TEST_F(RenderViewTest, AFailureEndsTheWatchersAndANewOneIsANewTry) {
  for (const Step step : {Step::kCreateView, Step::kEvaluate, Step::kEncode}) {
    MakeScene(33 + static_cast<int>(step), 2);
    script().FailNext(step, absl::InternalError("no such luck"));
    const auto client = Connect();

    RunToEnd(*client);

    EXPECT_THAT(client->status(), StatusIs(absl::StatusCode::kInternal));
    EXPECT_FALSE(RunTurn()) << "it is not tried again by itself";
    const auto another = Watch();
    Move(kCorner);
    ExpectRightAtHead(*another);
    ASSERT_OK(registry_.Delete(scene_->id()));
    states_.clear();
  }
}

TEST_F(RenderViewTest, WhatRoundsToTheSameIntegersIsNotEncoded) {
  const auto client = Watch();
  const int all = static_cast<int>(scene_->State()->plan->chunk_count());
  ASSERT_EQ(script().encoded_chunks(), all);
  const double step = scene_->State()->box.step(options_.view.key.spec.position_bits);

  Move(kCorner, {1e-12 * step, 0, 0});
  ExpectRightAtHead(*client);

  EXPECT_EQ(script().encoded_chunks(), all);
  EXPECT_EQ(client->updates().back().begin.chunk_count, 0u);
  EXPECT_EQ(client->updates().back().end.revision, 1u) << "which is covered all the same";
}

TEST_F(RenderViewTest, WhatAnotherWriterHasEncodedIsEncodedOnceMoreAndNotSent) {
  const auto client = Watch();
  const double step = scene_->State()->box.step(options_.view.key.spec.position_bits);
  const int at_first = script().encoded_chunks();

  script().ChangeDigests();
  Move(kCorner, {1e-12 * step, 0, 0});
  client->RunToHead();
  const int once_more = script().encoded_chunks();
  Move(kCorner, {1e-12 * step, 0, 0});
  ExpectRightAtHead(*client);

  EXPECT_GT(once_more, at_first);
  EXPECT_EQ(script().encoded_chunks(), once_more);
  EXPECT_EQ(client->updates()[1].begin.chunk_count, 0u);
  EXPECT_EQ(client->updates()[2].begin.chunk_count, 0u);
}

}  // namespace
}  // namespace latticed::testing
