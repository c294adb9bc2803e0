// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The connections that are open: how many may be, and how all of them are told to end. Some above the
// limit are taken to be told why they are not served.
//
// Threads  safe
#ifndef LATTICED_SERVER_WEB_CONNECTION_SET_H_
#define LATTICED_SERVER_WEB_CONNECTION_SET_H_

#include <cstdint>
#include <map>
#include <memory>

#include "absl/base/thread_annotations.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "server/base/connection_counts.h"

namespace latticed::web {

class Connection {
 public:
  virtual ~Connection() = default;
  // No request after the one that is being answered.
  virtual void Drain() = 0;
  // Ends it now; what runs for it is cancelled.
  virtual void Abort() = 0;
};

class ConnectionSet {
 public:
  explicit ConnectionSet(size_t most) : most_(most) {}

  // A place in the set, given back with its last owner.
  class Place {
   public:
    Place(ConnectionSet* set, uint64_t id, bool served) : set_(set), id_(id), served_(served) {}
    ~Place() { set_->Leave(id_, served_); }
    Place(const Place&) = delete;  // one place, one connection
    Place& operator=(const Place&) = delete;
    // Not where the set was full.
    bool served() const { return served_; }
    // Whom to tell; a connection that changes its protocol has another object then.
    void Hold(const std::shared_ptr<Connection>& connection) { set_->Hold(id_, connection); }

   private:
    ConnectionSet* const set_;
    const uint64_t id_;
    const bool served_;
  };

  // Null when there is no room even for words.
  [[nodiscard]] std::shared_ptr<Place> Enter() ABSL_LOCKS_EXCLUDED(mutex_);
  // Also those that enter later.
  void Drain() ABSL_LOCKS_EXCLUDED(mutex_);
  void Abort() ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] ConnectionCounts counts() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Whether all have left by then.
  bool AwaitEmpty(absl::Time deadline) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Leave(uint64_t id, bool served) ABSL_LOCKS_EXCLUDED(mutex_);
  void Hold(uint64_t id, const std::shared_ptr<Connection>& connection) ABSL_LOCKS_EXCLUDED(mutex_);
  void TellAll(void (Connection::*what)()) ABSL_LOCKS_EXCLUDED(mutex_);

  const size_t most_;
  mutable Mutex mutex_;
  size_t served_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t refused_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t next_id_ ABSL_GUARDED_BY(mutex_) = 1;
  std::map<uint64_t, std::weak_ptr<Connection>> connections_ ABSL_GUARDED_BY(mutex_);
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  bool aborting_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_CONNECTION_SET_H_
