// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The one thread that writes the database. It takes all that waits, commits it in one transaction, and then answers.
//
//   callers --Put--> WriteQueue --all that waits--> BEGIN, rows, COMMIT (waits for the medium) --> done, done, done
//
// When the medium fails, the transaction is rolled back, and the scenes with records in it are broken. A commit that
// failed is never tried again: the writer reads anew what is stored, and refuses all writes until a small transaction of
// its own succeeds, which it tries every kRetry. A transaction without memory fails alike.
//
// Threads  safe
#ifndef LATTICED_SERVER_STORE_SQLITE_WRITER_H_
#define LATTICED_SERVER_STORE_SQLITE_WRITER_H_

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <utility>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "server/store/queue/write_queue.h"
#include "server/store/sqlite/checkpointer.h"
#include "server/store/sqlite/database/connection.h"
#include "server/store/sqlite/scene_rows.h"

namespace latticed {

class SqliteWriter {
 public:
  static constexpr absl::Duration kRetry = absl::Milliseconds(200);

  // `folder` is where the database is. `counts` outlives this.
  SqliteWriter(std::string folder, SqliteConnection database, SqliteConnection checkpoints,
               StoreCounts* counts);
  // Reads what is stored. Call it once, before everything else.
  [[nodiscard]] absl::Status Start();
  // Writes and answers all that waits.
  ~SqliteWriter();

  // Of what is to be written.
  WriteQueue& queue() { return queue_; }
  // Executes `change` in its turn, in a transaction of its own, and waits for it.
  [[nodiscard]] absl::Status Change(std::function<absl::Status(SceneRows&)> change) {
    return queue_.Call(Write::Kind::kChange,
                       [this, change = std::move(change)] { return change(*rows_); });
  }
  // The same without a transaction.
  [[nodiscard]] absl::Status Ask(std::function<absl::Status(SceneRows&)> question) {
    return queue_.Call(Write::Kind::kQuestion,
                       [this, question = std::move(question)] { return question(*rows_); });
  }
  SqliteConnection& database() { return database_; }  // for changes

 private:
  void Run();
  // Appends and barriers, in one transaction.
  void CommitGroup(std::span<Write> group);
  absl::Status InsertGroup(std::span<Write> group);
  void ExecuteOne(Write& write);
  // `work` in a transaction.
  absl::Status Transact(const std::function<absl::Status()>& work);
  // The same, whether the medium failed before or not.
  absl::Status TryTransaction(const std::function<absl::Status()>& work);
  void Break(const Write& write, const absl::Status& why);
  // After a commit: so many pages are in the log.
  void NoteLogPages(int pages);
  void NoteFailure(const absl::Status& failure);
  void Recover();
  absl::Status TryToRecover();
  void Idle();
  absl::Duration Patience() const;
  void CheckpointIfDue();

  const std::string folder_;
  StoreCounts* const counts_;
  SqliteConnection database_;
  Checkpointer checkpointer_;
  std::unique_ptr<SceneRows> rows_;
  absl::Status failure_;  // of the medium; not OK: nothing is written
  absl::Time next_commit_ = absl::InfinitePast();
  int log_pages_ = 0;  // of the write-ahead log after the last commit
  WriteQueue queue_;
  std::thread thread_;  // last: it uses the rest
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_SQLITE_WRITER_H_
