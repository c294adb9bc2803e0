// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/drain_signal.h"

#include <utility>

namespace latticed {

uint64_t DrainSignal::Subscribe(std::function<void()> observer) {
  const MutexLock lock(&mutex_);
  const uint64_t id = next_id_++;
  if (begun_) {
    observer();
    return id;
  }
  observers_.emplace(id, std::move(observer));
  return id;
}

void DrainSignal::Unsubscribe(uint64_t id) {
  std::function<void()> removed;  // destroyed after the lock is released
  const MutexLock lock(&mutex_);
  const auto found = observers_.find(id);
  if (found == observers_.end()) return;
  removed = std::move(found->second);
  observers_.erase(found);
}

// Observers run under the lock: that is what makes Unsubscribe a guarantee.
void DrainSignal::Begin() {
  const MutexLock lock(&mutex_);
  if (begun_) return;
  begun_ = true;
  for (auto& [id, observer] : observers_) observer();
}

bool DrainSignal::begun() const {
  const MutexLock lock(&mutex_);
  return begun_;
}

}  // namespace latticed
