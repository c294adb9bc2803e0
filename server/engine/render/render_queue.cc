// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/render_queue.h"

#include <algorithm>

namespace latticed {
namespace {

auto Is(const std::shared_ptr<RenderSource>& source) {
  return [&source](const std::weak_ptr<RenderSource>& other) {
    return !source.owner_before(other) && !other.owner_before(source);
  };
}

}  // namespace

RenderQueue::RenderQueue(int workers) {
  for (int i = 0; i < workers; ++i) {
    const Role role = i > 0 && i == workers - 1 ? Role::kShort : Role::kAny;
    threads_.emplace_back([this, role] { Work(role); });
  }
}

RenderQueue::~RenderQueue() {
  {
    const MutexLock lock(&mutex_);
    stopping_ = true;
  }
  for (std::thread& thread : threads_) thread.join();
}

void RenderQueue::Schedule(const std::shared_ptr<RenderSource>& source) {
  const MutexLock lock(&mutex_);
  ++scheduled_;
  if (std::ranges::none_of(waiting_, Is(source))) waiting_.push_back(source);
}

void RenderQueue::Work(Role role) {
  uint64_t seen = 0;
  while (true) {
    {
      const MutexLock lock(&mutex_);
      const bool is_any = role == Role::kAny;
      idle_ += is_any ? 1 : 0;
      mutex_.Await([&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
        return stopping_ || (seen != scheduled_ && (is_any || idle_ == 0));
      });
      idle_ -= is_any ? 1 : 0;
      if (stopping_) return;
      seen = scheduled_;
    }
    while (RunNext(role)) {
      const MutexLock lock(&mutex_);
      if (stopping_) return;
    }
  }
}

bool RenderQueue::RunNext(Role role) { return role == Role::kAny ? RunFirst() : RunFirstShort(); }

bool RenderQueue::RunFirst() {
  while (true) {
    std::shared_ptr<RenderSource> source;
    {
      const MutexLock lock(&mutex_);
      if (waiting_.empty()) return false;
      source = waiting_.front().lock();
      waiting_.pop_front();
    }
    if (source == nullptr) continue;
    const auto run = source->TakeWork(kAnyPoints);
    if (run == nullptr) continue;
    // Another worker may run another view of the source meanwhile.
    Schedule(source);
    run();
    return true;
  }
}

bool RenderQueue::RunFirstShort() {
  Waiting waiting;
  {
    const MutexLock lock(&mutex_);
    waiting = waiting_;
  }
  for (const std::weak_ptr<RenderSource>& candidate : waiting) {
    const std::shared_ptr<RenderSource> source = candidate.lock();
    const auto run = source == nullptr ? nullptr : source->TakeWork(kShortPoints);
    if (run == nullptr) continue;
    {
      // Schedule then puts the source at the end, so that others come first next time.
      const MutexLock lock(&mutex_);
      std::erase_if(waiting_, Is(source));
    }
    Schedule(source);
    run();
    return true;
  }
  return false;
}

}  // namespace latticed
