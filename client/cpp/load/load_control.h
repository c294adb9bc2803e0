// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// State that the threads of a run share: its deadline, its progress, and its first failure, which ends
// the run.
//
// Threads  safe; Begin must be called before the threads start
#ifndef LATTICED_CLIENT_CPP_LOAD_LOAD_CONTROL_H_
#define LATTICED_CLIENT_CPP_LOAD_LOAD_CONTROL_H_

#include <algorithm>
#include <cstdint>
#include <stop_token>
#include <utility>

#include "absl/status/status.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client/cpp/library/latticed_client.h"
#include "core/base/mutex.h"

namespace latticed::client {

class LoadControl {
 public:
  // A request of `stop` ends the run like its deadline. `all_edits` is the total of `progress`.
  LoadControl(std::stop_token stop, Progress progress, uint64_t all_edits)
      : stop_(std::move(stop)), progress_(std::move(progress)), all_edits_(all_edits) {}

  void Begin(absl::Time deadline) { deadline_ = deadline; }

  // Sleeps until `time`. Returns false soon after the run was stopped, and at once if its deadline is
  // not after `time`. An edit that was due before the deadline is sent even if the deadline has passed.
  bool SleepUntil(absl::Time time) const {
    while (!Stopped() && time < deadline_) {
      const absl::Duration left = time - absl::Now();
      if (left <= absl::ZeroDuration()) return true;
      absl::SleepFor(std::min(left, kLongestSleep));
    }
    return false;
  }
  // Whether the deadline has passed, or a request or a failure has ended the run.
  bool Ended() const { return Stopped() || absl::Now() >= deadline_; }

  void Fail(const absl::Status& status) {
    const MutexLock lock(&mutex_);
    status_.Update(status);
  }
  // The first failure.
  absl::Status status() const {
    const MutexLock lock(&mutex_);
    return status_;
  }

  void CountEdits(uint64_t edits) {
    const MutexLock lock(&mutex_);
    edits_ += edits;
    progress_(edits_, all_edits_);
  }

 private:
  static constexpr absl::Duration kLongestSleep = absl::Milliseconds(20);

  bool Stopped() const { return stop_.stop_requested() || !status().ok(); }

  const std::stop_token stop_;
  const Progress progress_;
  const uint64_t all_edits_;
  absl::Time deadline_ = absl::InfiniteFuture();
  mutable Mutex mutex_;
  uint64_t edits_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_LOAD_CONTROL_H_
