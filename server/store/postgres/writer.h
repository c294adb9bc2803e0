// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The one thread that writes scenes, on a connection of its own. It takes all that waits, appends it by one statement,
// and then answers.
//
//   callers --Put--> WriteQueue --all that waits--> INSERT … (waits for the medium) --> done, done, done
//
// The fence is inside of each statement that writes: it locks this session's row, FOR KEY SHARE, if the session is not
// fenced and the connection is the writer's last one. Who fences, or attaches a new connection, locks the row FOR UPDATE,
// and so waits for the statement; a statement that comes later finds the row changed, and writes nothing.
//
// A statement that fails writes nothing. If the connection was lost in it, nobody knows: its records are answered
// kAborted, and what is stored is read when a new connection is attached. Until then the writer refuses all writes, and
// tries every kRetry.
//
// Threads  safe
#ifndef LATTICED_SERVER_STORE_POSTGRES_WRITER_H_
#define LATTICED_SERVER_STORE_POSTGRES_WRITER_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "server/store/postgres/connection.h"
#include "server/store/postgres/lease.h"
#include "server/store/postgres/tails.h"
#include "server/store/queue/write_queue.h"

namespace latticed {

class PgWriter {
 public:
  static constexpr absl::Duration kRetry = absl::Milliseconds(200);

  // `counts` outlives this. Without `fence`, statements do not lock the session's row: a test shows what would be lost.
  PgWriter(std::string url, PgLease* lease, bool fence, StoreCounts* counts);
  // Call it once, before everything else.
  [[nodiscard]] absl::Status Start();
  // Writes and answers all that waits.
  ~PgWriter();

  // Of what is to be written.
  WriteQueue& queue() { return queue_; }

  // kAlreadyExists.
  [[nodiscard]] absl::Status Create(std::string_view id, std::string_view header);
  // With a snapshot of records 1 to `lsn`. kAlreadyExists.
  [[nodiscard]] absl::Status CreateAt(std::string_view id, std::string_view header, uint64_t lsn,
                                      std::string_view snapshot);
  // kNotFound, kAborted.
  [[nodiscard]] absl::Status Delete(std::string_view id);
  [[nodiscard]] absl::Status Release(std::string_view id);
  // Waits for what was put before. What was sent to the database is decided then, also where its answer was lost.
  [[nodiscard]] absl::Status Settle();
  // The scene was read in `session`: its log goes on after this.
  void Learn(std::string_view id, PgTail tail, int64_t session);

 private:
  void Run();
  // Appends and barriers.
  void AppendGroup(std::span<Write> group);
  absl::Status InsertGroup(std::span<Write> group);
  void Break(const Write& write);
  void ExecuteOne(Write& write);
  absl::Status InsertScene(std::string_view id, std::string_view header);
  absl::Status InsertSceneAt(std::string_view id, std::string_view header, uint64_t lsn,
                             std::string_view snapshot);
  // `rows` are the number of the scene that was created, if it was.
  absl::Status NoteCreated(std::string_view id, uint64_t lsn, const PgRows& rows);
  absl::Status DeleteScene(std::string_view id);
  absl::Status PutSnapshot(const Write& write);
  // Notes failures of the medium.
  absl::Status Noted(absl::Status status);
  // What there is to say of a scene that is not in tails_.
  absl::Status Explain(std::string_view id);
  // A statement of `rest`, which may use `me`, with the fence before it: parameters $1 and $2.
  [[nodiscard]] absl::StatusOr<PgRows> Fenced(std::string_view rest,
                                              const std::function<void(PgParameters&)>& more);
  // There is a connection, and it is the writer of the lease's session.
  absl::Status Attach();
  void Recover();
  absl::Status TryToRecover();

  const std::string url_;
  PgLease* const lease_;
  const bool fence_;
  StoreCounts* const counts_;
  std::unique_ptr<PgConnection> connection_;
  bool attached_ = false;
  bool perhaps_stored_ = false;  // what InsertGroup sent, also if it fails
  bool undecided_ = false;  // a statement whose answer was lost: the database may still execute it
  int64_t session_ = 0;     // that tails_ are of
  int64_t number_ = 0;      // of the connection among the session's
  PgTails tails_;
  absl::Status failure_;  // of the medium; not OK: nothing is written
  WriteQueue queue_;
  std::thread thread_;  // last: it uses the rest
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_POSTGRES_WRITER_H_
