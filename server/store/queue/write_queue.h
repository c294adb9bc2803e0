// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What waits for the thread that writes, in the order of the calls.
//
// Threads  safe
#ifndef LATTICED_SERVER_STORE_QUEUE_WRITE_QUEUE_H_
#define LATTICED_SERVER_STORE_QUEUE_WRITE_QUEUE_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "server/store/store.h"

namespace latticed {

struct Write {
  enum class Kind {
    kAppend,    // a record
    kBarrier,   // nothing, in the scene's turn
    kSnapshot,  // of a scene
    kChange,    // `change`, which writes
    kQuestion,  // `change`, which only looks
  };

  Kind kind;
  std::string scene;
  uint64_t lsn = 0;
  std::string bytes;
  std::function<absl::Status()> change;
  Store::Done done;     // may be null
  absl::Status answer;  // what `done` will be given
};

class WriteQueue {
 public:
  // `counts` outlives this.
  explicit WriteQueue(StoreCounts* counts) : counts_(counts) {}

  // So much may wait, and one transaction takes so much at most: 64 MiB are written in less than a second by most disks,
  // and a transaction of 4 MiB in less than 0.1 s.
  static constexpr uint64_t kMostWaitingBytes = uint64_t{64} << 20;
  static constexpr uint64_t kMostTakenBytes = uint64_t{4} << 20;

  void Put(Write write) ABSL_LOCKS_EXCLUDED(mutex_);
  // Waits for work, but not longer than `patience`: then the answer is empty, as it is after Stop when all was taken.
  // Without memory for the answer it waits for that too.
  [[nodiscard]] std::vector<Write> Take(absl::Duration patience) ABSL_LOCKS_EXCLUDED(mutex_);
  // Counts a write that was taken, and calls its `done`. If that throws for want of memory, the log says so.
  void Answer(Write& write);
  // All of these, which were taken, are answered.
  void Answered(std::span<const Write> writes) ABSL_LOCKS_EXCLUDED(mutex_);
  void Stop() ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] bool Ended() const ABSL_LOCKS_EXCLUDED(mutex_);

  // Store::Admit. `refusal`, unless OK, is its answer from now on.
  [[nodiscard]] absl::Status Admit() const ABSL_LOCKS_EXCLUDED(mutex_);
  void SetRefusal(absl::Status refusal) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  std::vector<Write> TryToTake(absl::Duration patience) ABSL_LOCKS_EXCLUDED(mutex_);
  void Count(const Write& write);

  StoreCounts* const counts_;
  mutable Mutex mutex_;
  std::deque<Write> waiting_ ABSL_GUARDED_BY(mutex_);
  uint64_t unanswered_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status refusal_ ABSL_GUARDED_BY(mutex_);
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_QUEUE_WRITE_QUEUE_H_
