// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The lease of this run of the server: a row of table `session`, with a number that is never used again. A thread with a
// connection of its own renews it four times in its length, by the database's clock. Who owns a scene is a session; so
// one renewal keeps all scenes.
//
// When another server has fenced the session, this one begins a new one, which owns nothing, and then says so.
//
// Threads  safe
#ifndef LATTICED_SERVER_STORE_POSTGRES_LEASE_H_
#define LATTICED_SERVER_STORE_POSTGRES_LEASE_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "server/store/postgres/connection.h"

namespace latticed {

class PgLease {
 public:
  PgLease(std::string url, std::string name, absl::Duration length);
  // Begins the first session. Call it once, before everything else.
  [[nodiscard]] absl::Status Start();
  // Ends the session: all its scenes are anyone's.
  ~PgLease();

  const std::string& name() const { return name_; }
  absl::Duration length() const { return length_; }
  int64_t session() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Somebody saw that `session` is fenced. Waits for the next one, for up to three seconds. Returns the current one.
  int64_t WaitForNext(int64_t session) ABSL_LOCKS_EXCLUDED(mutex_);
  // Called on the thread that renews: it must not wait.
  void OnFenced(std::function<void()> fenced) ABSL_LOCKS_EXCLUDED(mutex_);
  void SetFreeBytes(uint64_t bytes) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Run() ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status Connect();
  // Begins a session.
  absl::Status Join() ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status Renew() ABSL_LOCKS_EXCLUDED(mutex_);
  void Note(const absl::Status& status);

  const std::string url_;
  const std::string name_;
  const absl::Duration length_;
  std::unique_ptr<PgConnection> connection_;  // of the thread; null: there is none
  bool failing_ = false;                      // of the thread
  mutable Mutex mutex_;
  int64_t session_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t free_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  bool doubted_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  Mutex callback_mutex_;  // held while fenced_ is called
  std::function<void()> fenced_ ABSL_GUARDED_BY(callback_mutex_);
  std::thread thread_;  // last: it uses the rest
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_POSTGRES_LEASE_H_
