// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Moves commits from the write-ahead log to the database, on a thread and a connection of its own, so that the writer
// does not wait for it. A checkpoint that fails is tried again with the next: until then its commits stay in the log.
//
// Threads  safe
#ifndef LATTICED_SERVER_STORE_SQLITE_CHECKPOINTER_H_
#define LATTICED_SERVER_STORE_SQLITE_CHECKPOINTER_H_

#include <thread>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "server/store/sqlite/database/connection.h"

namespace latticed {

class Checkpointer {
 public:
  explicit Checkpointer(SqliteConnection database);
  ~Checkpointer();

  // A checkpoint is due.
  void Wake() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Run() ABSL_LOCKS_EXCLUDED(mutex_);

  SqliteConnection database_;
  Mutex mutex_;
  bool due_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;  // last: it uses the rest
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_SQLITE_CHECKPOINTER_H_
