// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views and snapshots are destroyed with no lock held, because that may wait for a device. Other calls are
// answered meanwhile.
#include <chrono>
#include <future>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "absl/time/clock.h"
#include "core/base/limits.h"
#include "tests/server/engine/engine_support.h"
#include "tests/server/support/scripted_backend.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kPoint = 62;

class ReleaseTest : public ::testing::Test {
 protected:
  void SetUp() override {
    SceneConfig config = MakeSceneConfig("scene-one");
    options_ = {.view = config.default_view, .max_unacked_updates = 0};
    auto scene = registry_.Create(std::move(config));
    ASSERT_OK(scene);
    scene_ = *scene;
  }
  std::unique_ptr<WatcherClient> Watch() {
    auto client = std::make_unique<WatcherClient>(scene_, options_, &registry_.queue());
    client->RunToHead();
    return client;
  }
  ViewKey WithSegments(int segments) const {
    ViewKey key = options_.view.key;
    key.spec.segments = segments;
    return key;
  }
  void Move() {
    ASSERT_OK(scene_->ApplyEdits(MoveBatch(*scene_, "alice", ++sequence_, {kPoint}, {0, 0, 0.1})));
  }
  // During the next call of `step`, another thread acquires a view. Sets answered_ if it can.
  void ExpectAnswersDuring(Step step, int segments) {
    backend_.script().DuringNext(step, [this, segments] {
      during_ = std::async(std::launch::async, [this, segments] {
        return scene_->AcquireView(WithSegments(segments));
      });
      answered_ = during_.wait_for(std::chrono::seconds(20)) == std::future_status::ready;
    });
  }

  ScriptedBackend backend_{uint64_t{1} << 30};
  SceneRegistry registry_{&backend_, 0};
  std::shared_ptr<Scene> scene_;
  WatcherOptions options_;
  uint64_t sequence_ = 0;
  std::future<absl::StatusOr<std::shared_ptr<SnapshotBoard>>> during_;
  bool answered_ = false;
};

TEST_F(ReleaseTest, OfAViewThatWasIdleForLong) {
  Watch();
  ExpectAnswersDuring(Step::kDestroyView, 4);
  scene_->Tick(absl::Now() + absl::Minutes(2));
  EXPECT_TRUE(answered_);
  Watch();
}

TEST_F(ReleaseTest, OfAViewThatMakesWayForAnother) {
  Watch();
  for (int segments = 5; segments < 4 + limits::kMaxViewsPerScene; ++segments) {
    ASSERT_OK(scene_->AcquireView(WithSegments(segments)));
  }
  ExpectAnswersDuring(Step::kDestroyView, 5);
  EXPECT_OK(scene_->AcquireView(WithSegments(1))) << "in place of the one idle longest";
  EXPECT_TRUE(answered_);
}

TEST_F(ReleaseTest, OfAViewThatIsEvicted) {
  Watch();
  ExpectAnswersDuring(Step::kDestroyView, 4);
  EXPECT_TRUE(scene_->Evict());
  EXPECT_TRUE(answered_);
  const auto client = Watch();
  EXPECT_FALSE(scene_->Evict()) << "it is watched";
}

TEST_F(ReleaseTest, OfASnapshotThatItsLastReaderLetsGo) {
  const auto client = Watch();
  auto lease = SnapshotLease::OfNewest(*scene_->AcquireView(options_.view.key), absl::Now());
  Move();
  client->RunToHead();
  ExpectAnswersDuring(Step::kFreeChunk, 4);
  lease.reset();
  EXPECT_TRUE(answered_);
}

TEST_F(ReleaseTest, OfASnapshotThatIsRetired) {
  const auto client = Watch();
  const auto board = *scene_->AcquireView(options_.view.key);
  std::vector<SnapshotLease> leases;
  for (int reader = 0; reader < limits::kMaxSnapshotsPerView; ++reader) {
    leases.push_back(*SnapshotLease::OfNewest(board, absl::Now()));
    Move();
    if (reader + 1 == limits::kMaxSnapshotsPerView) ExpectAnswersDuring(Step::kFreeChunk, 4);
    client->RunToHead();
  }
  EXPECT_TRUE(answered_);
  EXPECT_EQ(leases[1].Get(absl::Now()), nullptr);
}

}  // namespace
}  // namespace latticed::testing
