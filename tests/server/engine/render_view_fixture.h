// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene of the engine, of which the test is the worker: it runs turns of views and controls the backend.
#ifndef LATTICED_TESTS_SERVER_ENGINE_RENDER_VIEW_FIXTURE_H_
#define LATTICED_TESTS_SERVER_ENGINE_RENDER_VIEW_FIXTURE_H_

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "tests/server/engine/engine_support.h"
#include "tests/server/support/scripted_backend.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {

// Two control points in a lattice of 8^3, far apart and near the surface. An edit of one changes chunks
// that an edit of the other leaves alone.
inline constexpr uint32_t kCorner = 5 * 64 + 1 * 8 + 1;
inline constexpr uint32_t kOtherCorner = 2 * 64 + 6 * 8 + 6;

class RenderViewTest : public ::testing::Test {
 protected:
  RenderViewTest() = default;
  // On a fake device.
  explicit RenderViewTest(uint64_t device_bytes) : backend_(device_bytes) {}
  void SetUp() override { MakeScene(32, 4); }

  void MakeScene(int cells, int segments) {
    MakeScene(MakeSceneConfig("scene-" + std::to_string(cells), cells, 8), segments);
  }
  void MakeScene(SceneConfig config, int segments) {
    options_ = {.editor_id = "alice", .view = config.default_view, .max_unacked_updates = 0};
    options_.view.key.spec.segments = segments;
    auto scene = registry_.Create(std::move(config));
    ASSERT_OK(scene);
    scene_ = *scene;
    states_[0] = scene_->State();
  }
  std::unique_ptr<WatcherClient> Connect() {
    return std::make_unique<WatcherClient>(scene_, options_, &registry_.queue());
  }
  std::unique_ptr<WatcherClient> Watch() {
    auto client = Connect();
    client->RunToHead();
    return client;
  }
  Script& script() { return backend_.script(); }
  bool RunTurn() { return registry_.queue().RunNext(RenderQueue::Role::kAny); }

  void Move(uint32_t point, Vec3d offset = {0, 0, 0.05}) {
    ASSERT_OK(scene_->ApplyEdits(MoveBatch(*scene_, "alice", ++sequence_, {point}, offset)));
    states_[scene_->State()->revision] = scene_->State();
  }
  // Runs to the head. The chunks then equal, byte for byte, a new evaluation of that revision.
  void ExpectRightAtHead(WatcherClient& client) {
    client.RunToHead();
    const uint64_t revision = client.updates().back().end.revision;
    EXPECT_EQ(revision, scene_->State()->revision);
    const auto fresh = EvaluateAfresh(*states_.at(revision), *client.view());
    ASSERT_EQ(client.chunks().size(), fresh.size());
    for (size_t c = 0; c < fresh.size(); ++c) {
      EXPECT_TRUE(std::ranges::equal(client.chunks()[c].span(), fresh[c]))
          << "chunk " << c << " at revision " << revision;
    }
  }
  // Runs turns until the client's watch ends.
  void RunToEnd(WatcherClient& client) {
    while (client.status().ok()) {
      if (!client.Step()) RunTurn();
    }
  }

  ScriptedBackend backend_;
  const std::shared_ptr<MemoryBudget> budget_ = std::make_shared<MemoryBudget>(uint64_t{1} << 30);
  SceneRegistry registry_{&backend_, 0, {.memory = budget_}};
  std::shared_ptr<Scene> scene_;
  WatcherOptions options_;
  std::map<uint64_t, std::shared_ptr<const SceneState>> states_;
  uint64_t sequence_ = 0;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_ENGINE_RENDER_VIEW_FIXTURE_H_
