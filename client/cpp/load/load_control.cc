// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/load_control.h"

#include "absl/time/clock.h"

namespace latticed::client {

LoadControl::LoadControl(const std::stop_token& stop)
    : stop_(stop), wake_on_stop_(stop, [this] {
        const MutexLock lock(&mutex_);  // its release wakes who sleeps
      }) {}

void LoadControl::Begin(absl::Time deadline) {
  begun_ = true;
  const MutexLock lock(&mutex_);
  deadline_ = deadline;
}

bool LoadControl::SleepUntil(absl::Time time) {
  const MutexLock lock(&mutex_);
  const auto ended = [&] { return StoppedLocked() || time >= deadline_; };
  while (!ended()) {
    const absl::Duration left = time - absl::Now();
    if (left <= absl::ZeroDuration()) return true;
    mutex_.AwaitFor(ended, left);
  }
  return false;
}

bool LoadControl::Ended() const {
  const MutexLock lock(&mutex_);
  return StoppedLocked() || absl::Now() >= deadline_;
}

bool LoadControl::Stopped() const {
  const MutexLock lock(&mutex_);
  return StoppedLocked();
}

void LoadControl::Fail(const absl::Status& status) {
  const MutexLock lock(&mutex_);
  if (status_.ok()) status_ = status;
}

absl::Status LoadControl::status() const {
  const MutexLock lock(&mutex_);
  return status_;
}

}  // namespace latticed::client
