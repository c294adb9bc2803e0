// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One release of the lock eventually serves every waiter that can continue, whatever each waits for.
#include "core/base/mutex.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace latticed {
namespace {

TEST(MutexTest, OneReleaseServesEveryWaiterThatCanGoOn) {
  Mutex mutex;
  int waiting = 0, items = 0;
  std::vector<std::thread> consumers;
  for (int i = 0; i < 8; ++i) {
    consumers.emplace_back([&] {
      const MutexLock lock(&mutex);
      ++waiting;
      mutex.Await([&] { return items > 0; });
      --items;
    });
  }
  {
    const MutexLock lock(&mutex);
    mutex.Await([&] { return waiting == 8; });
    items = 8;
  }
  for (std::thread& consumer : consumers) consumer.join();
  EXPECT_EQ(items, 0);
}

// Each thread changes what the other waits for and then waits at once, without a release in between.
TEST(MutexTest, AWaiterServesOthersByWhatItChangedBefore) {
  Mutex mutex;
  int turn = 0;
  const auto play = [&](int own) {
    for (int round = 0; round < 1'000; ++round) {
      const MutexLock lock(&mutex);
      mutex.Await([&] { return turn == own; });
      turn = 1 - own;
      mutex.Await([&] { return turn == own || round == 999; });
    }
  };
  std::thread other(play, 1);
  play(0);
  other.join();
  EXPECT_EQ(turn, 0);
}

TEST(MutexTest, WaitingEndsInTimeAndSaysWhetherTheConditionHolds) {
  Mutex mutex;
  const MutexLock lock(&mutex);
  EXPECT_FALSE(mutex.AwaitFor([] { return false; }, absl::Milliseconds(1)));
  EXPECT_TRUE(mutex.AwaitFor([] { return true; }, absl::ZeroDuration()));
}

}  // namespace
}  // namespace latticed
