// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene on a backend whose stages the test holds up, and what it must send at every revision.
#ifndef LATTICED_TESTS_SERVER_ENGINE_STAGED_SCENE_H_
#define LATTICED_TESTS_SERVER_ENGINE_STAGED_SCENE_H_

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "absl/time/clock.h"
#include "tests/server/engine/engine_support.h"
#include "tests/server/engine/staged_backend.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {

// Far apart in a lattice of 8^3 control points, near the surface: an edit of one changes chunks that
// one of the other leaves alone.
inline constexpr uint32_t kCorner = 5 * 64 + 1 * 8 + 1;
inline constexpr uint32_t kOtherCorner = 2 * 64 + 6 * 8 + 6;
// Long enough for a worker to begin what it must not begin.
inline constexpr absl::Duration kAWhile = absl::Milliseconds(50);

class StagedScene : public ::testing::Test {
 protected:
  explicit StagedScene(bool on_device = true) : backend_(on_device) {}
  void SetUp() override { MakeScene(32, 4); }
  void TearDown() override { gates().OpenAll(); }

  void MakeScene(int cells, int segments) {
    SceneConfig config = MakeSceneConfig("scene-" + std::to_string(cells), cells, 8);
    config.memory = budget_;
    options_.editor_id = "alice";
    options_.max_unacked_updates = 0;
    options_.view = config.default_view;
    options_.view.key.spec.segments = segments;
    auto scene = registry_.Create(std::move(config));
    ASSERT_OK(scene);
    scene_ = *scene;
    Remember();
  }
  std::unique_ptr<WatcherClient> Watch() {
    auto client = std::make_unique<WatcherClient>(scene_, options_);
    client->RunToHead();
    view_ = *scene_->AcquireView(client->watcher().view().key);
    return client;
  }
  StageGates& gates() { return backend_.gates(); }

  void Remember() { states_[scene_->State()->revision] = scene_->State(); }
  void Apply(EditBatch batch) {
    ASSERT_OK(scene_->ApplyEdits(batch));
    Remember();
  }
  void Move(uint32_t point, Vec3d offset = {0, 0, 0.05}) {
    Apply(MoveBatch(*scene_, "alice", ++sequence_, {point}, offset));
  }
  // Moves `point`, and returns when its update is being encoded: held at the gate.
  void MoveAndHoldEncoding(uint32_t point) {
    const int begun = gates().begun(Stage::kEncode);
    gates().Close(Stage::kEncode);
    Move(point);
    ASSERT_TRUE(gates().WaitForBegun(Stage::kEncode, begun + 1));
  }
  // Moves `point`, and returns when that is evaluated.
  void MoveAndWaitForEvaluation(uint32_t point) {
    const int ended = gates().ended(Stage::kEvaluate);
    Move(point);
    ASSERT_TRUE(gates().WaitForEnded(Stage::kEvaluate, ended + 1)) << "it waits for the encoding";
  }
  // The last update has, byte for byte, what an evaluation of its revision from nothing gives.
  void ExpectRight(const WatcherClient& client) {
    const auto fresh =
        EvaluateAfresh(*states_.at(client.updates().back().end.revision), *client.view());
    ASSERT_EQ(client.chunks().size(), fresh.size());
    for (size_t c = 0; c < fresh.size(); ++c) {
      EXPECT_TRUE(std::ranges::equal(client.chunks()[c].span(), fresh[c]))
          << "chunk " << c << " at revision " << client.updates().back().end.revision;
    }
  }
  void ExpectRightAtHead(WatcherClient& client) {
    client.RunToHead();
    EXPECT_EQ(client.updates().back().end.revision, scene_->State()->revision);
    ExpectRight(client);
  }

  StagedBackend backend_;
  std::shared_ptr<MemoryBudget> budget_ = std::make_shared<MemoryBudget>(uint64_t{1} << 30);
  SceneRegistry registry_{&backend_, 2};
  std::shared_ptr<Scene> scene_;
  WatcherOptions options_;
  std::shared_ptr<SceneView> view_;
  std::map<uint64_t, std::shared_ptr<const SceneState>> states_;
  uint64_t sequence_ = 0;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_ENGINE_STAGED_SCENE_H_
