// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Shared by the threads of a run: its deadline, its progress, and its first failure, which ends it.
//
// Threads  safe
#ifndef LATTICED_CLIENT_CPP_LOAD_LOAD_CONTROL_H_
#define LATTICED_CLIENT_CPP_LOAD_LOAD_CONTROL_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <stop_token>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"

namespace latticed::client {

class LoadControl {
 public:
  // A request of `stop` ends the run like its deadline.
  explicit LoadControl(const std::stop_token& stop);
  LoadControl(const LoadControl&) = delete;
  LoadControl& operator=(const LoadControl&) = delete;

  // Updates are measured from here on.
  void Begin(absl::Time deadline);
  bool begun() const { return begun_; }
  // Sleeps until `time`. Returns false at once when the run was stopped, or when its deadline is
  // not after `time`. An edit that was due before the deadline is still made after it.
  bool SleepUntil(absl::Time time);
  // Whether the deadline has passed, or the run was stopped.
  bool Ended() const;
  // Whether a request or a failure has ended the run.
  bool Stopped() const;

  void Fail(const absl::Status& status);
  // The first failure.
  absl::Status status() const;

  void CountEdits(uint64_t edits) { edits_ += edits; }
  uint64_t edits() const { return edits_; }

 private:
  bool StoppedLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return stop_.stop_requested() || !status_.ok();
  }

  const std::stop_token stop_;
  std::atomic<uint64_t> edits_ = 0;
  std::atomic<bool> begun_ = false;
  mutable Mutex mutex_;
  absl::Time deadline_ ABSL_GUARDED_BY(mutex_) = absl::InfiniteFuture();
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
  const std::stop_callback<std::function<void()>> wake_on_stop_;  // last: uses all
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_LOAD_CONTROL_H_
