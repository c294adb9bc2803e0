// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/update_pipeline.h"

#include <algorithm>
#include <utility>

#include "server/engine/scene.h"

namespace latticed {
namespace {

bool Is(const std::weak_ptr<Scene>& one, const std::shared_ptr<Scene>& other) {
  return !one.owner_before(other) && !other.owner_before(one);
}

}  // namespace

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
  const bool waits = std::ranges::any_of(
      waiting_, [&scene](const std::weak_ptr<Scene>& other) { return Is(other, scene); });
  if (!waits) waiting_.push_back(scene);
}

std::vector<std::weak_ptr<Scene>> UpdatePipeline::Waiting() {
  const MutexLock lock(&mutex_);
  if (stopping_) return {};
  return {waiting_.begin(), waiting_.end()};
}

void UpdatePipeline::TakeOut(const std::shared_ptr<Scene>& scene) {
  const MutexLock lock(&mutex_);
  std::erase_if(waiting_, [&scene](const std::weak_ptr<Scene>& other) { return Is(other, scene); });
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
      scene = waiting_.front().lock();
      waiting_.pop_front();
    }
    if (scene == nullptr) continue;
    if (auto work = scene->TakeWork(kAnyPoints)) RunWork(scene, *std::move(work));
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
  for (const std::weak_ptr<Scene>& waiting : Waiting()) {
    const std::shared_ptr<Scene> scene = waiting.lock();
    // Its own scene's next evaluation is for a worker that has time.
    if (scene == nullptr || scene.get() == turn.scene) continue;
    // Half: those that are let ahead may do so too, and the stack must not grow with that.
    auto work = scene->TakeWork(std::min(turn.credit, turn.points / 2));
    if (!work.has_value()) continue;
    turn.credit -= work->points;
    TakeOut(scene);
    RunWork(scene, *std::move(work));
  }
}

}  // namespace latticed
