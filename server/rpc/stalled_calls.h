// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Ends calls whose clients take nothing. A write that its client does not take keeps its message in memory, and
// the call its place, for as long as the client likes; after --write-timeout the call is cancelled.
//
// Threads  safe
#ifndef LATTICED_SERVER_RPC_STALLED_CALLS_H_
#define LATTICED_SERVER_RPC_STALLED_CALLS_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <grpcpp/grpcpp.h>

#include "absl/base/thread_annotations.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"

namespace latticed {

// What a call's client is to take.
class PendingWrite {
 public:
  explicit PendingWrite(grpc::CallbackServerContext* context) : context_(context) {}

  // A write begins, or the end of the call.
  void Begin(absl::Time now) { since_ns_ = absl::ToUnixNanos(now); }
  // The client has taken it.
  void End() { since_ns_ = kNothing; }
  // The call is done, and its context ends.
  void Close() ABSL_LOCKS_EXCLUDED(mutex_);
  // Cancels the call if its client has taken nothing since `time`. Returns whether it did.
  bool CancelSince(absl::Time time) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  static constexpr int64_t kNothing = INT64_MAX;
  std::atomic<int64_t> since_ns_ = kNothing;
  Mutex mutex_;
  grpc::CallbackServerContext* context_ ABSL_GUARDED_BY(mutex_);  // null once closed
};

class StalledCalls {
 public:
  [[nodiscard]] std::shared_ptr<PendingWrite> Add(grpc::CallbackServerContext* context)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Cancels the calls whose clients have taken nothing since `time`, and logs how many. Called once a second.
  void CancelSince(absl::Time time) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  Mutex mutex_;
  std::vector<std::weak_ptr<PendingWrite>> calls_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_STALLED_CALLS_H_
