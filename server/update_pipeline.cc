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
    std::optional<ViewWork> work = scene->TakeWork();
    if (!work.has_value()) continue;
    // Another view of the scene may be evaluated beside this one.
    Schedule(scene);
    scene->RunWork(*std::move(work));
  }
}

}  // namespace latticed
