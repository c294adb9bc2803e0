// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The open connections: limits their number, and ends all of them. A few connections above the limit
// are accepted, so that they can be answered with the reason.
//
// Threads  safe
#ifndef LATTICED_SERVER_WEB_CONNECTION_SET_H_
#define LATTICED_SERVER_WEB_CONNECTION_SET_H_

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "server/base/connection_counts.h"

namespace latticed::web {

class Connection {
 public:
  virtual ~Connection() = default;
  // The connection takes no request after the present one.
  virtual void Drain() = 0;
  // The connection ends now, and its calls are cancelled.
  virtual void Abort() = 0;
};

class ConnectionSet {
 public:
  enum WhenFull { kReplaceOldest };  // whoever holds connections cannot keep others out

  // One address gets at most `most_of_address` places.
  ConnectionSet(size_t most, size_t most_of_address)
      : most_(most), most_of_address_(most_of_address) {}
  ConnectionSet(size_t most, WhenFull) : most_(most), most_of_address_(most), replaces_(true) {}

  // A connection's place in the set, which is free when its last owner destroys it.
  class Place {
   public:
    Place(ConnectionSet* set, uint64_t id, bool served) : set_(set), id_(id), served_(served) {}
    ~Place() { set_->Leave(id_, served_); }
    Place(const Place&) = delete;  // one place, one connection
    Place& operator=(const Place&) = delete;
    // False when the set was full.
    bool served() const { return served_; }
    // Sets who is told to drain or abort. A connection calls it again when its protocol changes.
    void Hold(const std::shared_ptr<Connection>& connection) { set_->Hold(id_, connection); }

   private:
    ConnectionSet* const set_;
    const uint64_t id_;
    const bool served_;
  };

  // Null when there is no room even for an answer. An empty address is not counted.
  [[nodiscard]] std::shared_ptr<Place> Enter(const std::string& address)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Both also apply to connections that enter later.
  void Drain() ABSL_LOCKS_EXCLUDED(mutex_);
  void Abort() ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] ConnectionCounts counts() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Waits until all have left; false if the deadline came first.
  bool AwaitEmpty(absl::Time deadline) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Leave(uint64_t id, bool served) ABSL_LOCKS_EXCLUDED(mutex_);
  void Hold(uint64_t id, const std::shared_ptr<Connection>& connection) ABSL_LOCKS_EXCLUDED(mutex_);
  void TellAll(void (Connection::*what)()) ABSL_LOCKS_EXCLUDED(mutex_);

  struct Entry {
    std::string address;  // empty: not counted
    std::weak_ptr<Connection> connection;
  };
  const size_t most_, most_of_address_;
  const bool replaces_ = false;
  mutable Mutex mutex_;
  size_t served_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t refused_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t next_id_ ABSL_GUARDED_BY(mutex_) = 1;
  std::map<uint64_t, Entry> connections_ ABSL_GUARDED_BY(mutex_);
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  bool aborting_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_CONNECTION_SET_H_
