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

#include <condition_variable>
#include <mutex>

#include "absl/base/thread_annotations.h"
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
    if (waiting_ > 0) changed_.notify_all();
    mutex_.unlock();
  }

  // Waits until `condition` holds. The caller holds the lock before and after; other threads may hold
  // it in between. Every Unlock makes waiters evaluate their condition again.
  template <typename Condition>
  void Await(Condition condition) {
    std::unique_lock lock(mutex_, std::adopt_lock);
    ++waiting_;
    changed_.wait(lock, condition);
    --waiting_;
    lock.release();
  }
  // As Await, but waits no longer than `most`. Returns whether the condition holds.
  template <typename Condition>
  bool AwaitFor(Condition condition, absl::Duration most) {
    std::unique_lock lock(mutex_, std::adopt_lock);
    ++waiting_;
    const bool holds = changed_.wait_for(lock, absl::ToChronoMicroseconds(most), condition);
    --waiting_;
    lock.release();
    return holds;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int waiting_ = 0;  // guarded by mutex_
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
