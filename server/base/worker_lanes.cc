// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/worker_lanes.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "absl/time/clock.h"

namespace latticed {
namespace {

// Quick work and updates get nine tenths of a core that long work wants too.
constexpr int kLongNice = 10;

}  // namespace

WorkerLanes::WorkerLanes(size_t quick_workers, size_t long_workers)
    : most_of_caller_(long_workers - 1) {
  for (size_t i = 0; i < quick_workers; ++i)
    threads_.emplace_back([this] { RunLane(Lane::kQuick); });
  for (size_t i = 0; i < long_workers; ++i) threads_.emplace_back([this] { RunLane(Lane::kLong); });
}

WorkerLanes::~WorkerLanes() {
  {
    const MutexLock lock(&mutex_);
    stopping_ = true;
  }
  for (std::thread& thread : threads_) thread.join();
}

void WorkerLanes::Post(Lane lane, Caller caller, std::function<void()> work) {
  const MutexLock lock(&mutex_);
  std::deque<Queue>& queues = lanes_[static_cast<size_t>(lane)];
  auto queue = std::ranges::find(queues, caller, &Queue::caller);
  if (queue == queues.end()) queue = queues.insert(queues.end(), {caller, {}});
  queue->waiting.push_back({std::move(work), absl::Now()});
}

absl::Duration WorkerLanes::QuickStill(absl::Time now) const {
  const MutexLock lock(&mutex_);
  absl::Time oldest = now;
  for (const Queue& queue : lanes_[static_cast<size_t>(Lane::kQuick)]) {
    oldest = std::min(oldest, queue.waiting.front().posted);
  }
  return now - std::max(oldest, std::min(last_quick_, now));
}

bool WorkerLanes::MayRun(Lane lane, Caller caller) const {
  if (lane == Lane::kQuick || caller == nullptr || stopping_) return true;
  const auto running = running_.find(caller);
  return running == running_.end() || running->second < most_of_caller_;
}

bool WorkerLanes::HasWork(Lane lane) const {
  return std::ranges::any_of(lanes_[static_cast<size_t>(lane)],
                             [&](const Queue& queue) ABSL_NO_THREAD_SAFETY_ANALYSIS {
                               return MayRun(lane, queue.caller);
                             });
}

// Called only if HasWork. The caller's next work waits behind the other callers'.
WorkerLanes::Turn WorkerLanes::Take(Lane lane) {
  std::deque<Queue>& queues = lanes_[static_cast<size_t>(lane)];
  const auto first =
      std::ranges::find_if(queues, [&](const Queue& queue) ABSL_NO_THREAD_SAFETY_ANALYSIS {
        return MayRun(lane, queue.caller);
      });
  Queue queue = std::move(*first);
  queues.erase(first);
  Turn turn{lane, queue.caller, std::move(queue.waiting.front().run)};
  queue.waiting.pop_front();
  if (!queue.waiting.empty()) queues.push_back(std::move(queue));
  if (lane == Lane::kLong) {
    ++running_[turn.caller];
  } else {
    ++quick_taken_;
    last_quick_ = absl::Now();
  }
  return turn;
}

void WorkerLanes::Run(Turn turn) {
  turn.run();
  turn.run = nullptr;  // what it holds is freed before the lane counts it as done
  if (turn.lane == Lane::kQuick) return;
  const MutexLock lock(&mutex_);
  const auto running = running_.find(turn.caller);
  if (--running->second == 0) running_.erase(running);
}

void WorkerLanes::RunLane(Lane lane) {
  if (lane == Lane::kLong) {  // on Linux, of this thread alone
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kLongNice);
  }
  while (true) {
    Turn turn;
    {
      const MutexLock lock(&mutex_);
      mutex_.Await([&]() ABSL_NO_THREAD_SAFETY_ANALYSIS { return stopping_ || HasWork(lane); });
      if (!HasWork(lane)) return;
      turn = Take(lane);
    }
    Run(std::move(turn));
  }
}

}  // namespace latticed
