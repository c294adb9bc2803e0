// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The scene engine without a transport: on the CPU backend, where the stages of a view follow each
// other, and as if that were a device, where they overlap.
#include <algorithm>

#include <gtest/gtest.h>

#include "absl/time/clock.h"
#include "core/base/limits.h"
#include "tests/server/engine/engine_support.h"
#include "tests/server/engine/staged_backend.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

class SceneEngineTest : public ::testing::TestWithParam<bool> {
 protected:
  std::shared_ptr<Scene> MakeScene(const std::string& id = "scene-one", int cells = 8,
                                   int size = 5) {
    auto scene = registry_.Create(MakeSceneConfig(id, cells, size));
    EXPECT_OK(scene);
    return *scene;
  }
  WatcherOptions Options() const {
    return {.boot_id = "boot",
            .editor_id = "alice",
            .view = MakeSceneConfig("x").default_view,
            .max_unacked_updates = 0};
  }
  static void ExpectEqualsFresh(const WatcherClient& client, const Scene& scene) {
    const auto state = scene.State();
    const auto fresh = EvaluateAfresh(*state, *client.view());
    ASSERT_EQ(client.chunks().size(), fresh.size());
    for (size_t c = 0; c < fresh.size(); ++c) {
      const auto bytes = client.chunks()[c].span();
      EXPECT_TRUE(std::ranges::equal(bytes, fresh[c])) << "chunk " << c;
    }
    EXPECT_EQ(client.cage(), *state->control_points);
  }

  StagedBackend backend_{/*on_device=*/GetParam()};
  SceneRegistry registry_{&backend_, 2};
};

TEST_P(SceneEngineTest, FirstUpdateHoldsEveryChunk) {
  const auto scene = MakeScene();
  WatcherClient client(scene, Options());

  client.RunToHead();

  ASSERT_EQ(client.updates().size(), 1u);
  EXPECT_EQ(client.updates()[0].begin.chunk_count, scene->State()->plan->chunk_count());
  EXPECT_GT(client.updates()[0].begin.chunk_count, 4u);
  EXPECT_TRUE(client.updates()[0].end.full_detail);
  EXPECT_EQ(client.lattice_wholes(), 1u);
  ExpectEqualsFresh(client, *scene);
}

TEST_P(SceneEngineTest, UnwatchedSceneEvaluatesNothing) {
  const auto scene = MakeScene();
  const auto view = scene->AcquireView(MakeSceneConfig("x").default_view.key);
  ASSERT_OK(view);

  ASSERT_OK(scene->ApplyEdits(MoveBatch(*scene, "alice", 1, {3}, {0.1, 0, 0})));
  absl::SleepFor(absl::Milliseconds(50));

  EXPECT_EQ((*view)->evaluations(), 0u);
  EXPECT_EQ((*view)->newest(), nullptr);
}

TEST_P(SceneEngineTest, PausedAndSilentWatchersEvaluateNothing) {
  const auto scene = MakeScene();
  WatcherClient client(scene, Options());
  client.RunToHead();
  const auto view = *scene->AcquireView(client.watcher().view().key);
  const uint64_t evaluations = view->evaluations();

  client.watcher().SetPaused(true);
  ASSERT_OK(scene->ApplyEdits(MoveBatch(*scene, "alice", 1, {60}, {0.1, 0, 0})));
  client.watcher().SetSilent(true);
  client.watcher().SetPaused(false);
  ASSERT_OK(scene->ApplyEdits(MoveBatch(*scene, "alice", 2, {61}, {0.1, 0, 0})));
  absl::SleepFor(absl::Milliseconds(50));
  while (client.Step()) continue;

  EXPECT_EQ(view->evaluations(), evaluations);
  EXPECT_EQ(client.updates().size(), 1u);
  EXPECT_EQ(client.lattice_revision(), 2u) << "the cage goes on";

  client.watcher().SetSilent(false);
  client.RunToHead();
  ExpectEqualsFresh(client, *scene);
}

TEST_P(SceneEngineTest, AnEditSendsTheChunksItTouchesAndNoMore) {
  const auto scene = MakeScene("scene-one", 32, 8);
  WatcherClient client(scene, Options());
  client.RunToHead();
  const size_t all = client.updates()[0].begin.chunk_count;

  const auto summary =
      scene->ApplyEdits(MoveBatch(*scene, "alice", 7, {4 * 64 + 4 * 8 + 4}, {0, 0, 0.05}));
  ASSERT_OK(summary);
  client.RunToHead();

  EXPECT_GT(summary->patches_touched, 0u);
  EXPECT_LT(summary->patches_touched, scene->State()->plan->patches.size());
  EXPECT_GT(client.updates().back().begin.chunk_count, 0u);
  EXPECT_LT(client.updates().back().begin.chunk_count, all / 2);
  EXPECT_EQ(client.updates().back().end.applied_sequence, 7u);
  ExpectEqualsFresh(client, *scene);
}

TEST_P(SceneEngineTest, ARevisionWithoutChangedBytesIsCoveredByAnEmptyUpdate) {
  const auto scene = MakeScene();
  WatcherClient client(scene, Options());
  client.RunToHead();

  ASSERT_OK(scene->ApplyEdits(MoveBatch(*scene, "alice", 1, {3}, {0, 0, 0})));
  client.RunToHead();

  ASSERT_EQ(client.updates().size(), 2u);
  EXPECT_EQ(client.updates()[1].begin.chunk_count, 0u);
  EXPECT_EQ(client.updates()[1].end.revision, 1u);
}

TEST_P(SceneEngineTest, LatestWinsForASlowReader) {
  const auto scene = MakeScene();
  WatcherClient client(scene, Options());
  client.RunToHead();
  const auto view = *scene->AcquireView(client.watcher().view().key);
  const uint64_t evaluations = view->evaluations();

  // The reader begins an update and falls asleep; fifty edits come.
  ASSERT_OK(scene->ApplyEdits(MoveBatch(*scene, "alice", 1, {62}, {0.01, 0, 0})));
  while (!client.watcher().update_in_progress()) {
    if (!client.Step()) client.bell().Wait(absl::Milliseconds(10));
  }
  for (uint64_t i = 2; i <= 51; ++i) {
    ASSERT_OK(scene->ApplyEdits(MoveBatch(*scene, "alice", i, {62}, {0.001, 0, 0})));
  }
  absl::SleepFor(absl::Milliseconds(50));

  // One evaluation ahead of the reader, whatever happens.
  EXPECT_LE(view->evaluations(), evaluations + 2);
  client.RunToHead();
  EXPECT_LE(client.updates().size(), 4u);
  EXPECT_EQ(client.updates().back().end.revision, 51u);
  ExpectEqualsFresh(client, *scene);
}

TEST_P(SceneEngineTest, WatchersOfOneViewShareEvaluationAndBytes) {
  const auto scene = MakeScene();
  WatcherClient first(scene, Options());
  first.RunToHead();
  WatcherClient second(scene, Options());
  second.RunToHead();

  const auto view = *scene->AcquireView(first.watcher().view().key);
  EXPECT_EQ(view->evaluations(), 1u);
  ASSERT_EQ(first.chunks().size(), second.chunks().size());
  for (size_t c = 0; c < first.chunks().size(); ++c) {
    EXPECT_EQ(first.chunks()[c].data, second.chunks()[c].data) << "the same memory";
  }
}

TEST_P(SceneEngineTest, ARetiredSnapshotRestartsItsWatcher) {
  const auto scene = MakeScene();
  std::vector<std::unique_ptr<WatcherClient>> slow;
  WatcherClient fast(scene, Options());
  fast.RunToHead();
  const auto view = *scene->AcquireView(fast.watcher().view().key);
  const uint64_t oldest = view->newest()->number;

  // Each slow one stops inside the update of another revision, so that four sets would have to
  // live.
  for (uint64_t i = 1; i <= 4; ++i) {
    slow.push_back(std::make_unique<WatcherClient>(scene, Options()));
    while (!slow.back()->watcher().update_in_progress()) {
      if (!slow.back()->Step()) slow.back()->bell().Wait(absl::Milliseconds(10));
    }
    while (slow.back()->topologies() == 0 || slow.back()->quantisations() == 0) {
      slow.back()->Step();
    }
    slow.back()->Step();  // update_begin
    // Or it would have stalled where all this takes seconds.
    ASSERT_NE(view->Find(oldest), nullptr);
    ASSERT_OK(scene->ApplyEdits(MoveBatch(*scene, "alice", i, {62}, {0.01, 0, 0})));
    fast.RunToHead();
  }
  for (const auto& client : slow) client->RunToHead();

  EXPECT_FALSE(slow[0]->updates()[0].begin.restart) << "the oldest goes on";
  EXPECT_TRUE(slow[1]->updates()[0].begin.restart);
  EXPECT_EQ(slow[1]->updates()[0].begin.chunk_count, scene->State()->plan->chunk_count());
  for (const auto& client : slow) ExpectEqualsFresh(*client, *scene);
}

TEST_P(SceneEngineTest, LeavingTheBoxMakesANewOneAndSendsEverything) {
  const auto scene = MakeScene();
  WatcherClient client(scene, Options());
  client.RunToHead();
  const uint64_t box = scene->State()->box.id;

  ASSERT_OK(scene->ApplyEdits(MoveBatch(*scene, "alice", 1, {62}, {40, 0, 0})));
  client.RunToHead();

  EXPECT_GT(scene->State()->box.id, box);
  EXPECT_EQ(client.quantisations(), 2u);
  EXPECT_EQ(client.updates().back().begin.chunk_count, scene->State()->plan->chunk_count());
  ExpectEqualsFresh(client, *scene);
}

TEST_P(SceneEngineTest, KnotInsertionSendsLatticeTopologyAndEverything) {
  const auto scene = MakeScene();
  WatcherClient client(scene, Options());
  client.RunToHead();

  ASSERT_OK(scene->ApplyEdits(KnotBatch(*scene, "alice", 1, 0, 0.37)));
  client.RunToHead();

  EXPECT_EQ(scene->State()->structure_id, 2u);
  EXPECT_EQ(client.lattice_wholes(), 2u);
  EXPECT_EQ(client.topologies(), 2u);
  EXPECT_EQ(client.cage().size(), 150u);
  ExpectEqualsFresh(client, *scene);
}

TEST_P(SceneEngineTest, AStaleStructureIsRefusedAndChangesNothing) {
  const auto scene = MakeScene();
  EditBatch stale = MoveBatch(*scene, "alice", 1, {3}, {1, 0, 0});
  stale.structure_id = 9;

  EXPECT_THAT(scene->ApplyEdits(stale), StatusIs(absl::StatusCode::kAborted));
  EXPECT_EQ(scene->State()->revision, 0u);
}

TEST_P(SceneEngineTest, ARepeatedSequenceReturnsTheStoredResult) {
  const auto scene = MakeScene();
  const EditBatch batch = MoveBatch(*scene, "alice", 5, {3}, {0.1, 0, 0});

  const auto first = scene->ApplyEdits(batch);
  const auto again = scene->ApplyEdits(batch);

  ASSERT_OK(first);
  ASSERT_OK(again);
  EXPECT_EQ(again->revision, first->revision);
  EXPECT_EQ(again->patches_touched, first->patches_touched);
  EXPECT_EQ(scene->State()->revision, 1u);
}

TEST_P(SceneEngineTest, ATokenResumesWithWhatChangedSince) {
  const auto scene = MakeScene("scene-one", 32, 8);
  WatcherClient client(scene, Options());
  client.RunToHead();
  ASSERT_OK(scene->ApplyEdits(MoveBatch(*scene, "bob", 1, {4 * 64 + 4 * 8 + 4}, {0, 0, 0.05})));

  client.Reconnect(Options());
  EXPECT_TRUE(client.watcher().resumed());
  client.RunToHead();

  EXPECT_LT(client.updates().back().begin.chunk_count, scene->State()->plan->chunk_count() / 2);
  ExpectEqualsFresh(client, *scene);
}

TEST_P(SceneEngineTest, TokensOfAnotherRunViewOrStructureResumeNothing) {
  const auto scene = MakeScene();
  WatcherClient client(scene, Options());
  client.RunToHead();
  WatcherOptions options = Options();
  options.resume_token = client.updates().back().end.resume_token;

  WatcherOptions other_boot = options;
  other_boot.boot_id = "another";
  EXPECT_FALSE((*Watcher::Create(scene, other_boot))->resumed());
  WatcherOptions other_view = options;
  other_view.view.key.spec.segments = 3;
  EXPECT_FALSE((*Watcher::Create(scene, other_view))->resumed());
  WatcherOptions garbage = options;
  garbage.resume_token = "a/b/c/d/e/f/g";
  EXPECT_FALSE((*Watcher::Create(scene, garbage))->resumed());
  ASSERT_OK(scene->ApplyEdits(KnotBatch(*scene, "alice", 1, 1, 0.37)));
  EXPECT_FALSE((*Watcher::Create(scene, options))->resumed());
}

TEST_P(SceneEngineTest, AViewChangeTakesEffectWithTheNextUpdate) {
  const auto scene = MakeScene();
  WatcherClient client(scene, Options());
  client.RunToHead();

  WatchView finer = client.watcher().view();
  finer.key.spec.segments = 7;
  ASSERT_OK(client.watcher().SetView(finer));
  client.RunToHead();

  EXPECT_EQ(client.topologies(), 2u);
  EXPECT_EQ(client.updates().back().begin.view.key.spec.segments, 7);
  EXPECT_EQ(client.updates().back().end.revision, 0u);
  ExpectEqualsFresh(client, *scene);
}

TEST_P(SceneEngineTest, MaxPointsBelowOneSegmentAreRefused) {
  const auto scene = MakeScene();
  WatcherOptions options = Options();
  options.view.max_points = 3 * scene->State()->plan->patches.size() - 1;

  EXPECT_THAT(Watcher::Create(scene, options), StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST_P(SceneEngineTest, MaxBytesPerSecondSpacesBatches) {
  const auto scene = MakeScene();
  WatcherOptions options = Options();
  options.view.key.spec.segments = 32;
  WatcherClient free(scene, options);
  free.RunToHead();
  size_t bytes = 0;
  for (const SharedBytes& chunk : free.chunks()) bytes += chunk.size;
  // A quarter of a second is free; the rest of the bytes takes half a second.
  options.view.max_bytes_per_second = static_cast<uint64_t>(static_cast<double>(bytes) / 0.75);
  ASSERT_GT(bytes, size_t{1} << 20) << "several batches";

  const absl::Time start = absl::Now();
  WatcherClient paced(scene, options);
  while (paced.updates().empty()) {
    if (paced.Step()) continue;
    absl::SleepFor(absl::Milliseconds(5));
  }

  EXPECT_GT(absl::Now() - start, absl::Milliseconds(150));
}

TEST_P(SceneEngineTest, DistinctViewsAreLimitedAndIdleOnesMakeRoom) {
  const auto scene = MakeScene();
  ViewKey key = MakeSceneConfig("x").default_view.key;
  std::vector<std::shared_ptr<SceneView>> held;
  for (int i = 0; i < limits::kMaxViewsPerScene; ++i) {
    key.spec.segments = 1 + i;
    held.push_back(*scene->AcquireView(key));
  }
  key.spec.segments = 20;

  EXPECT_THAT(scene->AcquireView(key), StatusIs(absl::StatusCode::kResourceExhausted));
  held.pop_back();
  EXPECT_OK(scene->AcquireView(key));
  key.spec.segments = 33;
  EXPECT_THAT(scene->AcquireView(key), StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST_P(SceneEngineTest, ADeletedSceneEndsItsWatchersAndRefusesEdits) {
  const auto scene = MakeScene();
  WatcherClient client(scene, Options());
  client.RunToHead();

  ASSERT_OK(registry_.Delete("scene-one"));

  EXPECT_FALSE(client.Step());
  EXPECT_THAT(client.status(), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(scene->ApplyEdits(MoveBatch(*scene, "alice", 1, {3}, {1, 0, 0})),
              StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(registry_.Find("scene-one"), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(registry_.Delete("scene-one"), StatusIs(absl::StatusCode::kNotFound));
}

INSTANTIATE_TEST_SUITE_P(Stages, SceneEngineTest, ::testing::Bool(), [](const auto& on_device) {
  return std::string(on_device.param ? "Overlap" : "FollowEachOther");
});

}  // namespace
}  // namespace latticed::testing
