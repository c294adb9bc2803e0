// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/base/mutex.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>

namespace latticed {

struct Mutex::Waiter {
  absl::FunctionRef<bool()> condition;
  bool woken = false;
  std::condition_variable wake;
};

void Mutex::Await(absl::FunctionRef<bool()> condition) {
  while (!AwaitFor(condition, absl::Hours(1))) {
  }
}

bool Mutex::AwaitFor(absl::FunctionRef<bool()> condition, absl::Duration most) {
  const auto deadline = std::chrono::steady_clock::now() + absl::ToChronoMicroseconds(most);
  std::unique_lock lock(mutex_, std::adopt_lock);
  Waiter self{.condition = condition};
  bool holds = condition();
  for (bool in_time = true; !holds && in_time; holds = condition()) {
    WakeNext();  // waiting releases the lock too
    self.woken = false;
    waiters_.push_back(&self);
    in_time = self.wake.wait_until(lock, deadline, [&self] { return self.woken; });
    std::erase(waiters_, &self);
  }
  lock.release();
  return holds;
}

void Mutex::WakeNext() {
  const auto next = std::ranges::find_if(
      waiters_, [](const Waiter* waiter) { return !waiter->woken && waiter->condition(); });
  if (next == waiters_.end()) return;
  (*next)->woken = true;
  (*next)->wake.notify_one();
}

}  // namespace latticed
