// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The threads that run the work of calls, in two lanes, and fairly by caller.
//
//   quick workers   a | b | a | b | …         never wait for long work
//   long workers    A ............ | B ....   at lower priority
//
// Within a lane the callers have turns. One caller never has all long workers, so another's work begins at
// once, however much of the first one's waits.
//
// Threads  safe. The destructor runs all work that is waiting.
#ifndef LATTICED_SERVER_BASE_WORKER_LANES_H_
#define LATTICED_SERVER_BASE_WORKER_LANES_H_

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"

namespace latticed {

class WorkerLanes {
 public:
  enum class Lane { kQuick, kLong };
  using Caller = const void*;  // compared only; null: one that may have all long workers

  // So many threads for each lane: at least 1 for quick work, at least 2 for long.
  WorkerLanes(size_t quick_workers, size_t long_workers);
  ~WorkerLanes();
  WorkerLanes(const WorkerLanes&) = delete;  // its threads hold its address
  WorkerLanes& operator=(const WorkerLanes&) = delete;

  void Post(Lane lane, Caller caller, std::function<void()> work) ABSL_LOCKS_EXCLUDED(mutex_);

  // For how long no quick work has been taken although some waits; zero when none does.
  [[nodiscard]] absl::Duration QuickStill(absl::Time now) const ABSL_LOCKS_EXCLUDED(mutex_);
  // How much quick work has been taken from the queue.
  uint64_t quick_taken() const { return quick_taken_.load(); }

 private:
  struct Work {
    std::function<void()> run;
    absl::Time posted;
  };
  // The work of one caller in one lane.
  struct Queue {
    Caller caller;
    std::deque<Work> waiting;
  };
  struct Turn {
    Lane lane;
    Caller caller;
    std::function<void()> run;
  };

  void RunLane(Lane lane) ABSL_LOCKS_EXCLUDED(mutex_);
  bool HasWork(Lane lane) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool MayRun(Lane lane, Caller caller) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  Turn Take(Lane lane) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Run(Turn turn) ABSL_LOCKS_EXCLUDED(mutex_);

  std::atomic<uint64_t> quick_taken_ = 0;
  const size_t most_of_caller_;  // long work that runs at a time
  mutable Mutex mutex_;
  std::array<std::deque<Queue>, 2> lanes_ ABSL_GUARDED_BY(mutex_);        // in order of their turns
  absl::Time last_quick_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();  // when it was taken
  std::map<Caller, size_t> running_ ABSL_GUARDED_BY(mutex_);              // long work
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;  // last: they use the rest
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_WORKER_LANES_H_
