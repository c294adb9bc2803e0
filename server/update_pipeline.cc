// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/update_pipeline.h"

#include <algorithm>
#include <utility>

#include "server/scene.h"

namespace latticed {

UpdatePipeline::UpdatePipeline(int workers) {
  for (int i = 0; i < std::max(workers, 1); ++i) threads_.emplace_back([this] { Run(); });
}

UpdatePipeline::~UpdatePipeline() {
  {
    const MutexLock lock(&mutex_);
    stopping_ = true;
  }
  for (std::thread& thread : threads_) thread.join();
}

void UpdatePipeline::Schedule(const std::shared_ptr<Scene>& scene) {
  const MutexLock lock(&mutex_);
  const bool waits = std::ranges::any_of(waiting_, [&scene](const std::weak_ptr<Scene>& other) {
    return !other.owner_before(scene) && !scene.owner_before(other);
  });
  if (!waits) waiting_.push_back(scene);
}

std::shared_ptr<Scene> UpdatePipeline::PopLocked() {
  if (waiting_.empty()) return nullptr;
  auto scene = waiting_.front().lock();
  waiting_.pop_front();
  return scene;
}

size_t UpdatePipeline::waiting() {
  const MutexLock lock(&mutex_);
  return stopping_ ? 0 : waiting_.size();
}

void UpdatePipeline::Run() {
  while (true) {
    std::shared_ptr<Scene> scene;
    {
      const MutexLock lock(&mutex_);
      const auto ready = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
        return stopping_ || !waiting_.empty();
      };
      mutex_.Await(ready);
      if (stopping_) return;
      scene = PopLocked();
    }
    if (scene == nullptr) continue;
    bool longer = false;
    if (auto work = scene->TakeWork(kAnyPoints, &longer)) RunWork(scene, *std::move(work));
  }
}

void UpdatePipeline::RunWork(const std::shared_ptr<Scene>& scene, ViewWork work) {
  // Another view of the scene may be evaluated beside this one.
  Schedule(scene);
  Turn turn{.scene = scene.get(), .points = work.points};
  scene->RunWork(std::move(work), [this, &turn](uint64_t points) {
    turn.credit += points;
    LetOthersAhead(turn);
  });
}

void UpdatePipeline::LetOthersAhead(Turn& turn) {
  // All that wait go around once, so that those who stay keep their order.
  for (size_t left = waiting(); left > 0; --left) {
    std::shared_ptr<Scene> scene;
    {
      const MutexLock lock(&mutex_);
      scene = PopLocked();
    }
    if (scene == nullptr) continue;
    // Its own scene's next evaluation is for a worker that has time. Half: those that are let ahead
    // may do so too, and the stack must not grow with that.
    bool longer = scene.get() == turn.scene;
    const uint64_t most_points = std::min(turn.credit, turn.points / 2);
    std::optional<ViewWork> work;
    if (!longer) work = scene->TakeWork(most_points, &longer);
    if (longer) Schedule(scene);
    if (!work.has_value()) continue;
    turn.credit -= work->points;
    RunWork(scene, *std::move(work));
  }
}

}  // namespace latticed
