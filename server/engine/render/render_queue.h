// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Gives scenes their turns to be evaluated and encoded, round robin over those that have work, and owns the
// workers that do it. The queue holds scenes, not work: what is to be done is decided when a worker is
// free, so edits that arrive meanwhile are merged.
//
//   worker kAny     huge ................ | medium ....... | huge ............
//   worker kShort   small | small |       | small |  small | small |
//
// One worker takes only short turns. So a short turn waits only for other short turns, however many long
// ones there are. The other workers take what comes first. That worker wakes after those that are idle: if it woke
// first, a long turn would wait for two threads to wake.
//
// Threads  safe; work runs with no lock held. The destructor finishes what runs and drops the rest.
#ifndef LATTICED_SERVER_ENGINE_RENDER_RENDER_QUEUE_H_
#define LATTICED_SERVER_ENGINE_RENDER_RENDER_QUEUE_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace latticed {

// What takes turns: a scene.
class RenderSource {
 public:
  virtual ~RenderSource() = default;
  // Begins a turn of at most `most_points`, as RenderView::Begin counts them, and returns the function that
  // runs it; null when there is nothing to do.
  [[nodiscard]] virtual std::function<void()> TakeWork(uint64_t most_points) = 0;
};

class RenderQueue {
 public:
  enum class Role { kAny, kShort };
  static constexpr uint64_t kAnyPoints = std::numeric_limits<uint64_t>::max();
  // The most points of a short turn, which takes about 10 ms on two cores.
  static constexpr uint64_t kShortPoints = 1'000'000;

  // `workers` threads; of two or more, the last takes only short turns. With none, a test runs turns by
  // RunNext.
  explicit RenderQueue(int workers);
  ~RenderQueue();
  RenderQueue(const RenderQueue&) = delete;  // its threads hold its address
  RenderQueue& operator=(const RenderQueue&) = delete;

  // Queues the source for a worker. A source is in the queue at most once.
  void Schedule(const std::shared_ptr<RenderSource>& source) ABSL_LOCKS_EXCLUDED(mutex_);
  // Runs the first turn that the role may take. Returns false when there is none.
  bool RunNext(Role role) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  using Waiting = std::deque<std::weak_ptr<RenderSource>>;
  void Work(Role role) ABSL_LOCKS_EXCLUDED(mutex_);
  bool RunFirst() ABSL_LOCKS_EXCLUDED(mutex_);
  bool RunFirstShort() ABSL_LOCKS_EXCLUDED(mutex_);

  Mutex mutex_;
  Waiting waiting_ ABSL_GUARDED_BY(mutex_);
  uint64_t scheduled_ ABSL_GUARDED_BY(mutex_) = 0;  // calls of Schedule
  int idle_ ABSL_GUARDED_BY(mutex_) = 0;            // workers kAny that wait
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_RENDER_QUEUE_H_
