// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Tells long-lived streams that the server is about to stop, so that they can send goaway and end
// OK.
//
// Threads  safe. An observer runs once, on the thread that calls Begin (or Subscribe, when draining
// has
//          begun already), under the lock: it must not block nor call back here. After Unsubscribe
//          returns it does not run any more.
#ifndef LATTICED_SERVER_BASE_DRAIN_SIGNAL_H_
#define LATTICED_SERVER_BASE_DRAIN_SIGNAL_H_

#include <cstdint>
#include <functional>
#include <map>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace latticed {

class DrainSignal {
 public:
  // Returns the id for Unsubscribe.
  uint64_t Subscribe(std::function<void()> observer) ABSL_LOCKS_EXCLUDED(mutex_);
  void Unsubscribe(uint64_t id) ABSL_LOCKS_EXCLUDED(mutex_);
  void Begin() ABSL_LOCKS_EXCLUDED(mutex_);
  bool begun() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  mutable Mutex mutex_;
  bool begun_ ABSL_GUARDED_BY(mutex_) = false;
  uint64_t next_id_ ABSL_GUARDED_BY(mutex_) = 1;
  std::map<uint64_t, std::function<void()>> observers_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_DRAIN_SIGNAL_H_
