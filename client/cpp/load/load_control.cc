// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/load_control.h"

#include "absl/time/clock.h"

namespace latticed::client {

LoadControl::LoadControl(const std::stop_token& stop)
    : stop_(stop), wake_on_stop_(stop, [this] {
        const std::lock_guard lock(mutex_);
        changed_.notify_all();
      }) {}

void LoadControl::Begin(absl::Time deadline) {
  begun_ = true;
  const std::lock_guard lock(mutex_);
  deadline_ = deadline;
  changed_.notify_all();
}

bool LoadControl::SleepUntil(absl::Time time) {
  std::unique_lock lock(mutex_);
  while (!StoppedLocked() && time < deadline_) {
    if (absl::Now() >= time) return true;
    changed_.wait_until(lock, absl::ToChronoTime(time));
  }
  return false;
}

bool LoadControl::Ended() const {
  const std::lock_guard lock(mutex_);
  return StoppedLocked() || absl::Now() >= deadline_;
}

bool LoadControl::Stopped() const {
  const std::lock_guard lock(mutex_);
  return StoppedLocked();
}

void LoadControl::Fail(const absl::Status& status) {
  const std::lock_guard lock(mutex_);
  if (status_.ok()) status_ = status;
  changed_.notify_all();
}

absl::Status LoadControl::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

}  // namespace latticed::client
