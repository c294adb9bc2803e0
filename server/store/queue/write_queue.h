// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What waits for the thread that writes, in the order of the calls.
//
// Threads  Take, Execute and Answer: the one that writes, which Call must not be on; the rest: any
#ifndef LATTICED_SERVER_STORE_QUEUE_WRITE_QUEUE_H_
#define LATTICED_SERVER_STORE_QUEUE_WRITE_QUEUE_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <span>
#include <string>
#include <string_view>
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
  // As Store::Append and Store::PutSnapshot.
  void PutAppend(std::string_view scene, uint64_t lsn, std::string record, Store::Done done)
      ABSL_LOCKS_EXCLUDED(mutex_);
  void PutSnapshot(std::string_view scene, uint64_t lsn, std::string snapshot)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Puts a kChange or kQuestion, and waits for its answer.
  [[nodiscard]] absl::Status Call(Write::Kind kind, std::function<absl::Status()> change)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Waits for work, but not longer than `patience`: then the answer is empty, as it is after Stop when all was taken.
  // Without memory for the answer it waits for that too.
  [[nodiscard]] std::vector<Write> Take(absl::Duration patience) ABSL_LOCKS_EXCLUDED(mutex_);
  // Executes writes that were taken, in their order: `group` has appends and barriers that follow each other, `one` any
  // other write. Both call Answer for each.
  void Execute(std::span<Write> writes, const std::function<void(std::span<Write>)>& group,
               const std::function<void(Write&)>& one) ABSL_LOCKS_EXCLUDED(mutex_);
  // Counts a write, and calls its `done`. The log names a snapshot that failed, and a `done` without memory.
  void Answer(Write& write);
  void Stop() ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] bool Ended() const ABSL_LOCKS_EXCLUDED(mutex_);

  // Store::Admit. `refusal`, unless OK, is its answer from now on.
  [[nodiscard]] absl::Status Admit() const ABSL_LOCKS_EXCLUDED(mutex_);
  void SetRefusal(absl::Status refusal) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Answered(std::span<const Write> writes) ABSL_LOCKS_EXCLUDED(mutex_);
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
