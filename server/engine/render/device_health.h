// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Whether the backend that serves still has its device. A process does not get a lost one back: the
// first kUnavailable is for good, and another server must take over.
//
// Threads  safe. The observer runs once, on the thread that notes the loss (or that calls
//          SetObserver, when it is lost already), under the lock: it must not block nor call back
//          here. After SetObserver returns the one before does not run any more.
#ifndef LATTICED_SERVER_ENGINE_RENDER_DEVICE_HEALTH_H_
#define LATTICED_SERVER_ENGINE_RENDER_DEVICE_HEALTH_H_

#include <functional>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "core/base/mutex.h"

namespace latticed {

class DeviceHealth {
 public:
  using Observer = std::function<void(const absl::Status& why)>;

  // OK, or kUnavailable, reason DEVICE_LOST, with the backend's words.
  [[nodiscard]] absl::Status status() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Tells what a call of the backend returned.
  void Note(const absl::Status& answer) ABSL_LOCKS_EXCLUDED(mutex_);
  // With null nobody is told.
  void SetObserver(Observer observer) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  mutable Mutex mutex_;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
  Observer observer_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_DEVICE_HEALTH_H_
