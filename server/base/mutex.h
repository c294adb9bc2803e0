// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The lock of the scene engine: absl::Mutex's conditional waiting and annotations over std::mutex.
// A packaged libabsl is not instrumented, so that ThreadSanitizer does not see its Mutex and takes
// all that it guards for races; std::mutex it sees.
//
// Threads  safe
#ifndef LATTICED_SERVER_BASE_MUTEX_H_
#define LATTICED_SERVER_BASE_MUTEX_H_

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

  // Called with the lock held, and holds it again when `condition` does; others may hold it
  // meanwhile. Whoever unlocks has the condition looked at again.
  template <typename Condition>
  void Await(Condition condition) {
    std::unique_lock lock(mutex_, std::adopt_lock);
    ++waiting_;
    changed_.wait(lock, condition);
    --waiting_;
    lock.release();
  }
  // The same for at most `most`; returns whether the condition holds.
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

#endif  // LATTICED_SERVER_BASE_MUTEX_H_
