// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which scene's turn is next, by role. Only the last tests have threads.
#include "server/engine/render/render_queue.h"

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <semaphore>
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
    if (points_ > most_points) return nullptr;
    int left = turns_;
    while (left > 0 && !turns_.compare_exchange_weak(left, left - 1)) continue;
    if (left == 0) return nullptr;
    return [this] {
      log_->push_back(name_);
      during();
    };
  }

 private:
  const std::string name_;
  const uint64_t points_;
  std::vector<std::string>* const log_;
  std::atomic<int> turns_ = 0;
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

// The worker of short turns sleeps while another one is idle, but not while all others run.
TEST(RenderQueueThreadsTest, AShortTurnRunsBesideLongOnesOnAllOtherWorkers) {
  for (const int workers : {2, 3}) {
    std::vector<std::string> long_log, log;
    std::vector<std::shared_ptr<FakeScene>> huge;
    std::promise<void> ended;
    const std::shared_future<void> end = ended.get_future().share();
    std::counting_semaphore<> begun(0);
    RenderQueue queue(workers);
    for (int i = 1; i < workers; ++i) {
      huge.push_back(std::make_shared<FakeScene>("huge", kHuge, &long_log));
      huge.back()->Give(1);
      huge.back()->during = [&] {
        begun.release();
        end.wait();
      };
      queue.Schedule(huge.back());
      begun.acquire();
    }
    auto small = std::make_shared<FakeScene>("small", kSmall, &log);
    small->during = [&] { begun.release(); };
    for (int turn = 0; turn < 3; ++turn) {
      small->Give(1);
      queue.Schedule(small);
      EXPECT_TRUE(begun.try_acquire_for(std::chrono::seconds(20))) << "turn " << turn;
    }
    ended.set_value();
  }
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
