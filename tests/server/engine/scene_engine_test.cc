// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The scene engine without a transport, on one thread: the test runs the turns of the views itself.
#include <algorithm>

#include <gtest/gtest.h>

#include "absl/time/clock.h"
#include "core/base/limits.h"
#include "core/cpu/cpu_backend.h"
#include "tests/server/engine/engine_support.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

class SceneEngineTest : public ::testing::Test {
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

  WatcherClient Watch(const std::shared_ptr<Scene>& scene, const WatcherOptions& options) {
    return {scene, options, &registry_.queue()};
  }

  const std::unique_ptr<Backend> backend_ = MakeCpuBackend({.threads = 2});
  SceneRegistry registry_{backend_.get(), /*workers=*/0};
};

TEST_F(SceneEngineTest, FirstUpdateHoldsEveryChunk) {
  const auto scene = MakeScene();
  WatcherClient client = Watch(scene, Options());

  client.RunToHead();

  ASSERT_EQ(client.updates().size(), 1u);
  EXPECT_EQ(client.updates()[0].begin.chunk_count, scene->State()->plan->chunk_count());
  EXPECT_GT(client.updates()[0].begin.chunk_count, 4u);
  EXPECT_TRUE(client.updates()[0].end.full_detail);
  EXPECT_EQ(client.lattice_wholes(), 1u);
  ExpectEqualsFresh(client, *scene);
}

TEST_F(SceneEngineTest, AnEditSendsTheChunksItTouchesAndNoMore) {
  const auto scene = MakeScene("scene-one", 32, 8);
  WatcherClient client = Watch(scene, Options());
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

TEST_F(SceneEngineTest, ARevisionWithoutChangedBytesIsCoveredByAnEmptyUpdate) {
  const auto scene = MakeScene();
  WatcherClient client = Watch(scene, Options());
  client.RunToHead();

  ASSERT_OK(scene->ApplyEdits(MoveBatch(*scene, "alice", 1, {3}, {0, 0, 0})));
  client.RunToHead();

  ASSERT_EQ(client.updates().size(), 2u);
  EXPECT_EQ(client.updates()[1].begin.chunk_count, 0u);
  EXPECT_EQ(client.updates()[1].end.revision, 1u);
}

TEST_F(SceneEngineTest, LatestWinsForASlowReader) {
  const auto scene = MakeScene();
  WatcherClient client = Watch(scene, Options());
  client.RunToHead();

  // The reader begins an update and falls asleep; fifty edits come.
  ASSERT_OK(scene->ApplyEdits(MoveBatch(*scene, "alice", 1, {62}, {0.01, 0, 0})));
  client.RunIntoUpdate();
  for (uint64_t i = 2; i <= 51; ++i) {
    ASSERT_OK(scene->ApplyEdits(MoveBatch(*scene, "alice", i, {62}, {0.001, 0, 0})));
    while (registry_.queue().RunNext(RenderQueue::Role::kAny)) continue;
  }

  EXPECT_EQ(registry_.counts().evaluations.load(), 3u) << "one ahead of the reader";
  client.RunToHead();
  EXPECT_EQ(client.updates().size(), 4u);
  EXPECT_EQ(client.updates().back().end.revision, 51u);
  ExpectEqualsFresh(client, *scene);
}

TEST_F(SceneEngineTest, WatchersOfOneViewShareEvaluationAndBytes) {
  const auto scene = MakeScene();
  WatcherClient first = Watch(scene, Options());
  first.RunToHead();
  WatcherClient second = Watch(scene, Options());
  second.RunToHead();

  EXPECT_EQ(registry_.counts().evaluations.load(), 1u);
  ASSERT_EQ(first.chunks().size(), second.chunks().size());
  for (size_t c = 0; c < first.chunks().size(); ++c) {
    EXPECT_EQ(first.chunks()[c].data, second.chunks()[c].data) << "the same memory";
  }
}

TEST_F(SceneEngineTest, ARetiredSnapshotRestartsItsWatcher) {
  const auto scene = MakeScene();
  std::vector<std::unique_ptr<WatcherClient>> slow;
  WatcherClient fast = Watch(scene, Options());
  fast.RunToHead();

  // Each slow one stops inside the update of another revision, so that four sets would have to
  // live.
  for (uint64_t i = 1; i <= 4; ++i) {
    slow.push_back(std::make_unique<WatcherClient>(scene, Options(), &registry_.queue()));
    slow.back()->RunIntoUpdate();
    ASSERT_OK(scene->ApplyEdits(MoveBatch(*scene, "alice", i, {62}, {0.01, 0, 0})));
    fast.RunToHead();
  }
  for (const auto& client : slow) client->RunToHead();

  EXPECT_FALSE(slow[0]->updates()[0].begin.restart) << "the oldest goes on";
  EXPECT_TRUE(slow[1]->updates()[0].begin.restart);
  EXPECT_EQ(slow[1]->updates()[0].begin.chunk_count, scene->State()->plan->chunk_count());
  for (const auto& client : slow) ExpectEqualsFresh(*client, *scene);
}

TEST_F(SceneEngineTest, LeavingTheBoxMakesANewOneAndSendsEverything) {
  const auto scene = MakeScene();
  WatcherClient client = Watch(scene, Options());
  client.RunToHead();
  const uint64_t box = scene->State()->box.id;

  ASSERT_OK(scene->ApplyEdits(MoveBatch(*scene, "alice", 1, {62}, {40, 0, 0})));
  client.RunToHead();

  EXPECT_GT(scene->State()->box.id, box);
  EXPECT_EQ(client.quantisations(), 2u);
  EXPECT_EQ(client.updates().back().begin.chunk_count, scene->State()->plan->chunk_count());
  ExpectEqualsFresh(client, *scene);
}

TEST_F(SceneEngineTest, KnotInsertionSendsLatticeTopologyAndEverything) {
  const auto scene = MakeScene();
  WatcherClient client = Watch(scene, Options());
  client.RunToHead();

  ASSERT_OK(scene->ApplyEdits(KnotBatch(*scene, "alice", 1, 0, 0.37)));
  client.RunToHead();

  EXPECT_EQ(scene->State()->structure_id, 2u);
  EXPECT_EQ(client.lattice_wholes(), 2u);
  EXPECT_EQ(client.topologies(), 2u);
  EXPECT_EQ(client.cage().size(), 150u);
  ExpectEqualsFresh(client, *scene);
}

TEST_F(SceneEngineTest, AStaleStructureIsRefusedAndChangesNothing) {
  const auto scene = MakeScene();
  EditBatch stale = MoveBatch(*scene, "alice", 1, {3}, {1, 0, 0});
  stale.structure_id = 9;

  EXPECT_THAT(scene->ApplyEdits(stale), StatusIs(absl::StatusCode::kAborted));
  EXPECT_EQ(scene->State()->revision, 0u);
}

TEST_F(SceneEngineTest, ARepeatedSequenceReturnsTheStoredResult) {
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

TEST_F(SceneEngineTest, ATokenResumesWithWhatChangedSince) {
  const auto scene = MakeScene("scene-one", 32, 8);
  WatcherClient client = Watch(scene, Options());
  client.RunToHead();
  ASSERT_OK(scene->ApplyEdits(MoveBatch(*scene, "bob", 1, {4 * 64 + 4 * 8 + 4}, {0, 0, 0.05})));

  client.Reconnect(Options());
  EXPECT_TRUE(client.watcher().resumed());
  client.RunToHead();

  EXPECT_LT(client.updates().back().begin.chunk_count, scene->State()->plan->chunk_count() / 2);
  ExpectEqualsFresh(client, *scene);
}

TEST_F(SceneEngineTest, AViewChangeTakesEffectWithTheNextUpdate) {
  const auto scene = MakeScene();
  WatcherClient client = Watch(scene, Options());
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

TEST_F(SceneEngineTest, MaxPointsBelowOneSegmentAreRefused) {
  const auto scene = MakeScene();
  WatcherOptions options = Options();
  options.view.max_points = 3 * scene->State()->plan->patches.size() - 1;

  EXPECT_THAT(Watcher::Create(scene, options), StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST_F(SceneEngineTest, DistinctViewsAreLimitedAndIdleOnesMakeRoom) {
  const auto scene = MakeScene();
  ViewKey key = MakeSceneConfig("x").default_view.key;
  std::vector<std::shared_ptr<SnapshotBoard>> held;
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

TEST_F(SceneEngineTest, ADeletedSceneEndsItsWatchersAndRefusesEdits) {
  const auto scene = MakeScene();
  WatcherClient client = Watch(scene, Options());
  client.RunToHead();

  ASSERT_OK(registry_.Delete("scene-one"));

  EXPECT_FALSE(client.Step());
  EXPECT_THAT(client.status(), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(scene->ApplyEdits(MoveBatch(*scene, "alice", 1, {3}, {1, 0, 0})),
              StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(registry_.Find("scene-one"), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(registry_.Delete("scene-one"), StatusIs(absl::StatusCode::kNotFound));
}

}  // namespace
}  // namespace latticed::testing
