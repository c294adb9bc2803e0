// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Turns of the workers, and the watchdog that looks at them.
#include "server/base/worker_lanes.h"

#include <gtest/gtest.h>

#include <latch>
#include <string>

#include "absl/time/clock.h"
#include "server/base/watchdog.h"

namespace latticed::testing {
namespace {

using Lane = WorkerLanes::Lane;

// Work that says that it runs, and waits until it may end. It and latches must outlive the lanes, whose destructor waits
// for work.
struct Blocked {
  std::latch begun{1}, may_end{1};
  std::function<void()> Run() {
    return [this] {
      begun.count_down();
      may_end.wait();
    };
  }
};

constexpr int kAlice = 1, kMallory = 2;

TEST(WorkerLanesTest, QuickWorkRunsBesideLongWork) {
  Blocked first, second;
  std::latch done(1);
  WorkerLanes lanes(1, 2);
  lanes.Post(Lane::kLong, &kMallory, first.Run());
  lanes.Post(Lane::kLong, &kAlice, second.Run());
  first.begun.wait();
  second.begun.wait();

  lanes.Post(Lane::kQuick, &kMallory, [&] { done.count_down(); });

  done.wait();
  first.may_end.count_down();
  second.may_end.count_down();
}

TEST(WorkerLanesTest, OneCallerNeverHasAllLongWorkers) {
  Blocked first, second;
  std::latch done(1);
  WorkerLanes lanes(1, 2);
  lanes.Post(Lane::kLong, &kMallory, first.Run());
  lanes.Post(Lane::kLong, &kMallory, second.Run());
  first.begun.wait();

  lanes.Post(Lane::kLong, &kAlice, [&] { done.count_down(); });

  done.wait();
  EXPECT_FALSE(second.begun.try_wait()) << "a second work of the first caller waits for the first";
  first.may_end.count_down();
  second.begun.wait();
  second.may_end.count_down();
}

TEST(WorkerLanesTest, CallersHaveTurns) {
  std::string order;
  {
    Blocked block;
    WorkerLanes lanes(1, 2);
    lanes.Post(Lane::kQuick, &kMallory, block.Run());
    block.begun.wait();
    for (int i = 0; i < 3; ++i) lanes.Post(Lane::kQuick, &kMallory, [&] { order += 'm'; });
    for (int i = 0; i < 2; ++i) lanes.Post(Lane::kQuick, &kAlice, [&] { order += 'a'; });
    EXPECT_GT(lanes.QuickStill(absl::Now() + absl::Seconds(5)), absl::Seconds(4));
    EXPECT_EQ(lanes.quick_taken(), 1u);
    block.may_end.count_down();
  }  // runs what waits

  EXPECT_EQ(order, "mamam");
}

TEST(WatchdogTest, AnEngineThatDoesNotTickIsStuck) {
  Watchdog watchdog;
  Pulse pulse{.engine_ticks = 7};
  EXPECT_FALSE(watchdog.IsStuck(pulse));
  for (int i = 1; i < Watchdog::kPatience; ++i) EXPECT_FALSE(watchdog.IsStuck(pulse)) << i;

  EXPECT_TRUE(watchdog.IsStuck(pulse));

  ++pulse.engine_ticks;
  EXPECT_FALSE(watchdog.IsStuck(pulse));
}

TEST(WatchdogTest, CallsThatWaitForAWorkerAreStuckUnlessOneIsTaken) {
  Watchdog watchdog;
  Pulse pulse{.quick_calls_wait = true};
  const auto next = [&] {
    ++pulse.engine_ticks;
    return watchdog.IsStuck(pulse);
  };
  for (int i = 1; i < Watchdog::kPatience; ++i) EXPECT_FALSE(next()) << i;
  ++pulse.quick_calls;
  for (int i = 0; i < Watchdog::kPatience; ++i) EXPECT_FALSE(next()) << i;

  EXPECT_TRUE(next());
}

}  // namespace
}  // namespace latticed::testing
