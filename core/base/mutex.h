// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The one mutex of this tree: absl::Mutex's annotations and conditional waiting, over std::mutex.
// ThreadSanitizer sees std::mutex. It does not see the absl::Mutex of a packaged libabsl, which is not
// instrumented, and would report every access that one guards as a race.
//
// Threads  safe
#ifndef LATTICED_CORE_BASE_MUTEX_H_
#define LATTICED_CORE_BASE_MUTEX_H_

#include <mutex>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/function_ref.h"
#include "absl/time/time.h"

namespace latticed {

class ABSL_LOCKABLE Mutex {
 public:
  Mutex() = default;
  Mutex(const Mutex&) = delete;  // threads wait at its address
  Mutex& operator=(const Mutex&) = delete;

  void Lock() ABSL_EXCLUSIVE_LOCK_FUNCTION() { mutex_.lock(); }
  bool TryLock() ABSL_EXCLUSIVE_TRYLOCK_FUNCTION(true) { return mutex_.try_lock(); }
  void Unlock() ABSL_UNLOCK_FUNCTION() {
    if (!waiters_.empty()) WakeNext();
    mutex_.unlock();
  }

  // Waits until `condition` holds. The caller holds the lock before and after; other threads may hold
  // it in between. Conditions are evaluated under the lock, by whoever releases it.
  void Await(absl::FunctionRef<bool()> condition);
  // As Await, but waits no longer than `most`. Returns whether the condition holds.
  bool AwaitFor(absl::FunctionRef<bool()> condition, absl::Duration most);

 private:
  struct Waiter;

  // Wakes the thread that has waited longest of those whose condition holds. One is enough: it releases
  // the lock too.
  void WakeNext();

  std::mutex mutex_;
  std::vector<Waiter*> waiters_;
};

class ABSL_SCOPED_LOCKABLE MutexLock {
 public:
  explicit MutexLock(Mutex* mutex) ABSL_EXCLUSIVE_LOCK_FUNCTION(mutex) : mutex_(mutex) {
    mutex_->Lock();
  }
  ~MutexLock() ABSL_UNLOCK_FUNCTION() { mutex_->Unlock(); }
  MutexLock(const MutexLock&) = delete;  // one unlock for one lock
  MutexLock& operator=(const MutexLock&) = delete;

 private:
  Mutex* const mutex_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_BASE_MUTEX_H_
