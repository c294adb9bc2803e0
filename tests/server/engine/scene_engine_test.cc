// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The scene engine without a transport. The test itself runs the views' turns, on one thread.
#include <algorithm>

#include <gtest/gtest.h>

#include "absl/time/clock.h"
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
    return {.evaluator = "cpu",
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

TEST_F(SceneEngineTest, LatestWinsForASlowReader) {
  const auto scene = MakeScene();
  WatcherClient client = Watch(scene, Options());
  client.RunToHead();

  // The reader begins an update and then reads nothing while 50 edits come.
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

// The first lattice of a stream is the newest. What a client evaluates by itself needs that of its update.
TEST_F(SceneEngineTest, AnEditWhileAStreamOpensIsInItsFirstUpdateOfPatches) {
  const auto scene = MakeScene();
  WatcherOptions options = Options();
  options.view = {.key = {{.normals = NormalMode::kNone, .format = VertexFormat::kEdgeBounds},
                          Encoding::kPatches}};
  WatcherClient before = Watch(scene, options);
  before.RunToHead();

  WatcherClient opening = Watch(scene, options);
  ASSERT_OK(scene->ApplyEdits(MoveBatch(*scene, "alice", 1, {62}, {0.01, 0, 0})));
  opening.RunToUpdate();

  EXPECT_EQ(opening.lattice_wholes(), 1u);
  EXPECT_EQ(opening.lattice_revision(), 1u);
  EXPECT_EQ(opening.updates()[0].end.revision, 1u);
  ExpectEqualsFresh(opening, *scene);
}

TEST_F(SceneEngineTest, ARetiredSnapshotRestartsItsWatcher) {
  const auto scene = MakeScene();
  std::vector<std::unique_ptr<WatcherClient>> slow;
  WatcherClient fast = Watch(scene, Options());
  fast.RunToHead();

  // Each slow watcher stops inside the update of another revision. These need more snapshots than a view
  // may keep.
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

}  // namespace
}  // namespace latticed::testing
