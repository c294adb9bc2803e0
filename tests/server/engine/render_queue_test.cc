// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which scene's turn is next, by role. Only the last test has threads.
#include "server/engine/render/render_queue.h"

#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace latticed::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
constexpr auto kAny = RenderQueue::Role::kAny, kShort = RenderQueue::Role::kShort;
constexpr uint64_t kSmall = 1'000, kHuge = 10 * RenderQueue::kShortPoints;

// A source with the turns that it is given, of `points` each. It logs each turn that runs.
class FakeScene : public RenderSource {
 public:
  FakeScene(std::string name, uint64_t points, std::vector<std::string>* log)
      : name_(std::move(name)), points_(points), log_(log) {}
  void Give(int turns) { turns_ += turns; }
  // Runs inside each turn.
  std::function<void()> during = [] {};

  std::function<void()> TakeWork(uint64_t most_points) override {
    if (turns_ == 0 || points_ > most_points) return nullptr;
    --turns_;
    return [this] {
      log_->push_back(name_);
      during();
    };
  }

 private:
  const std::string name_;
  const uint64_t points_;
  std::vector<std::string>* const log_;
  int turns_ = 0;
};

class RenderQueueTest : public ::testing::Test {
 protected:
  std::shared_ptr<FakeScene> Edited(std::string name, uint64_t points, int turns = 1) {
    auto scene = std::make_shared<FakeScene>(std::move(name), points, &log_);
    scene->Give(turns);
    queue_.Schedule(scene);
    return scene;
  }
  std::vector<std::string> RunAll(RenderQueue::Role role) {
    while (queue_.RunNext(role)) continue;
    return std::exchange(log_, {});
  }

  std::vector<std::string> log_;
  RenderQueue queue_{/*workers=*/0};
};

TEST_F(RenderQueueTest, ScenesTakeTurnsInTheOrderOfTheirEdits) {
  const auto a = Edited("a", kHuge, 3), b = Edited("b", kSmall, 2), c = Edited("c", kHuge);

  EXPECT_THAT(RunAll(kAny), ElementsAre("a", "b", "c", "a", "b", "a"));
  EXPECT_FALSE(queue_.RunNext(kAny));
}

TEST_F(RenderQueueTest, TheShortWorkerTakesShortTurnsInTheSameOrderAndLeavesLongOnes) {
  const auto a = Edited("huge", kHuge), b = Edited("b", kSmall, 2), c = Edited("c", kSmall, 2);

  EXPECT_THAT(RunAll(kShort), ElementsAre("b", "c", "b", "c"));
  EXPECT_THAT(RunAll(kAny), ElementsAre("huge"));
}

TEST_F(RenderQueueTest, ATurnOfTheLimitIsShortAndOneMorePointIsNot) {
  const auto a = Edited("at", RenderQueue::kShortPoints);
  const auto b = Edited("above", RenderQueue::kShortPoints + 1);

  EXPECT_THAT(RunAll(kShort), ElementsAre("at"));
  EXPECT_THAT(RunAll(kAny), ElementsAre("above"));
}

TEST_F(RenderQueueTest, BesideTwoHugeScenesASmallOneWaitsForNeither) {
  const auto a = Edited("huge-a", kHuge), b = Edited("huge-b", kHuge);
  std::shared_ptr<FakeScene> small;
  a->during = [&] {
    small = Edited("small", kSmall);
    EXPECT_TRUE(queue_.RunNext(kShort)) << "while a huge turn runs";
  };

  EXPECT_THAT(RunAll(kAny), ElementsAre("huge-a", "small", "huge-b"));
}

TEST_F(RenderQueueTest, ASceneThatEditsWithoutRestLetsOthersHaveTheShortWorker) {
  const auto restless = Edited("restless", kSmall, 100), other = Edited("other", kSmall);

  EXPECT_TRUE(queue_.RunNext(kShort));
  EXPECT_TRUE(queue_.RunNext(kShort));

  EXPECT_THAT(log_, ElementsAre("restless", "other"));
}

TEST_F(RenderQueueTest, AnotherViewOfASceneMayBeEvaluatedBesideItsFirst) {
  const auto scene = Edited("scene", kSmall, 2);
  bool beside = false;
  scene->during = [&] {
    if (std::exchange(beside, true)) return;
    EXPECT_TRUE(queue_.RunNext(kAny));
  };

  EXPECT_THAT(RunAll(kAny), ElementsAre("scene", "scene"));
}

TEST_F(RenderQueueTest, ASceneThatIsGoneIsSkipped) {
  Edited("gone", kSmall).reset();
  const auto scene = Edited("scene", kSmall);

  EXPECT_THAT(RunAll(kShort), ElementsAre("scene"));
  Edited("gone", kSmall).reset();
  EXPECT_THAT(RunAll(kAny), IsEmpty());
}

TEST(RenderQueueThreadsTest, WorkersRunWhatIsScheduledAndEndWithTheQueue) {
  std::vector<std::string> log;
  auto scene = std::make_shared<FakeScene>("scene", kHuge, &log);
  scene->Give(1);
  std::promise<void> ran;
  scene->during = [&] { ran.set_value(); };
  {
    RenderQueue queue(3);
    queue.Schedule(scene);
    EXPECT_EQ(ran.get_future().wait_for(std::chrono::seconds(20)), std::future_status::ready);
  }
  EXPECT_THAT(log, ElementsAre("scene"));
}

}  // namespace
}  // namespace latticed::testing
