// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Parallel loops on the threads of one backend, by oneTBB.
//
// Threads  safe; a loop returns when all of its parts are done
#ifndef LATTICED_CORE_VIEW_CPU_ARENA_H_
#define LATTICED_CORE_VIEW_CPU_ARENA_H_

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cstddef>

#include "absl/status/status.h"
#include "core/base/mutex.h"

namespace latticed {

class CpuArena {
 public:
  explicit CpuArena(int threads)
      : threads_(static_cast<size_t>(threads)),
        arena_(threads + kCallers - 1, kCallers),
        few_(kFewThreads + kCallers - 1, kCallers) {}

  // The most threads that one loop runs on.
  size_t threads() const { return threads_; }
  // The number of threads that a loop of `parts` parts runs on. Waking more takes longer than they
  // save: 26 chunks were written in 0.26 ms on 64 threads, and in 0.19 ms on 32.
  size_t ThreadsFor(size_t parts) const {
    return parts <= kFewParts ? std::min<size_t>(threads_, kFewThreads) : threads_;
  }
  // The most threads that run when several loops do.
  size_t most_threads() const {
    return threads_ + kCallers - 1 + (threads_ > kFewThreads ? kFewThreads + kCallers - 1 : 0);
  }

  // Calls body(begin, end) for parts of [0, count) of about `grain` items.
  template <class Body>
  void ForRanges(size_t count, size_t grain, const Body& body) {
    // oneTBB orders the caller, the parts and the return, but a packaged libtbb is not
    // instrumented, so ThreadSanitizer would report every loop. It sees the order of this atomic,
    // and so only real races.
    std::atomic<size_t> order;
    order.store(1, std::memory_order_release);
    ArenaOf((count + grain - 1) / grain).execute([&] {
      tbb::parallel_for(tbb::blocked_range<size_t>(0, count, grain),
                        [&](const tbb::blocked_range<size_t>& part) {
                          (void)order.load(std::memory_order_acquire);
                          body(part.begin(), part.end());
                          order.fetch_add(1, std::memory_order_acq_rel);
                        });
    });
    (void)order.load(std::memory_order_acquire);
  }

  // Calls body(i) for every i in [0, count).
  template <class Body>
  void ForEach(size_t count, const Body& body, size_t grain = 1) {
    ForRanges(count, grain, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) body(i);
    });
  }

  // As ForEach, with a body that returns a status: the status of the first that failed.
  template <class Body>
  absl::Status TryEach(size_t count, const Body& body) {
    Mutex mutex;
    absl::Status first_error;
    ForEach(count, [&](size_t i) {
      const absl::Status status = body(i);
      if (status.ok()) return;
      const MutexLock lock(&mutex);
      first_error.Update(status);
    });
    return first_error;
  }

 private:
  // Callers that may begin a loop without waiting for another caller's loop: the server's render
  // workers. The system shares the cores among them.
  static constexpr int kCallers = 3;
  // A loop wakes all threads of its arena, however few parts it has.
  static constexpr int kFewThreads = 32, kFewParts = 64;

  tbb::task_arena& ArenaOf(size_t parts) { return ThreadsFor(parts) < threads_ ? few_ : arena_; }

  const size_t threads_;
  tbb::task_arena arena_, few_;  // their threads are made when one first runs a loop
};

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_CPU_ARENA_H_
