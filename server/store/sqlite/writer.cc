// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/sqlite/writer.h"

#include <sqlite3.h>
#include <sys/statvfs.h>

#include <memory>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "core/base/catch_bad_alloc.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/telemetry.h"
#include "server/store/sqlite/database/checked_vfs.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

// The checkpointer begins at this length of the log, 4 MB.
constexpr int kCheckpointPages = 1'000;
// Commits that come without a pause would let the log grow for ever: at 64 MB the writer itself ends the checkpoint,
// and the next commit begins the log anew.
constexpr int kMostLogPages = 16'384;
// A page in the log, with its header.
constexpr uint64_t kLogPageBytes = kDatabasePageBytes + 24;
// After a full disk, writing goes on when this is free: less would be full again at once.
constexpr uint64_t kRoomBytes = uint64_t{8} << 20;
// A commit writes whole pages. After one of many records the next begins no sooner than this: a disk that commits in
// 0.2 ms would write each page of the log several times.
constexpr size_t kManyRecords = 4;
constexpr absl::Duration kBetweenCommits = absl::Milliseconds(1);
// A pause of this length is used to sweep.
constexpr absl::Duration kIdle = absl::Milliseconds(250);

uint64_t RoomIn(const std::string& folder) {
  struct statvfs found = {};
  if (statvfs(folder.c_str(), &found) != 0) return 0;
  return uint64_t{found.f_bavail} * found.f_frsize;
}

}  // namespace

SqliteWriter::SqliteWriter(std::string folder, SqliteConnection database,
                           SqliteConnection checkpoints, StoreCounts* counts)
    : folder_(std::move(folder)),
      counts_(counts),
      database_(std::move(database)),
      checkpointer_(std::move(checkpoints)),
      queue_(counts) {}

absl::Status SqliteWriter::Start() {
  LATTICED_ASSIGN_OR_RETURN(SceneRows rows, SceneRows::Create(&database_));
  rows_ = std::make_unique<SceneRows>(std::move(rows));
  const auto note_log_pages = [](void* writer, sqlite3*, const char*, int pages) {
    static_cast<SqliteWriter*>(writer)->NoteLogPages(pages);
    return SQLITE_OK;
  };
  sqlite3_wal_hook(database_.get(), note_log_pages, this);
  thread_ = std::thread([this] { Run(); });
  return absl::OkStatus();
}

void SqliteWriter::NoteLogPages(int pages) {
  const int before = pages < log_pages_ ? 0 : log_pages_;  // fewer: the log began anew
  counts_->log_bytes += static_cast<uint64_t>(pages - before) * kLogPageBytes;
  log_pages_ = pages;
}

SqliteWriter::~SqliteWriter() {
  queue_.Stop();
  if (thread_.joinable()) thread_.join();
}

void SqliteWriter::Run() {
  while (true) {
    absl::SleepFor(next_commit_ - absl::Now());
    std::vector<Write> writes = queue_.Take(Patience());
    if (writes.empty() && queue_.Ended()) return;
    if (!failure_.ok()) Recover();
    if (writes.empty()) Idle();
    queue_.Execute(
        writes, [this](std::span<Write> group) { CommitGroup(group); },
        [this](Write& write) { ExecuteOne(write); });
    CheckpointIfDue();
  }
}

absl::Duration SqliteWriter::Patience() const {
  if (!failure_.ok()) return kRetry;
  return rows_->WorthSweeping() ? kIdle : absl::Hours(1);
}

void SqliteWriter::CommitGroup(std::span<Write> group) {
  if (group.size() >= kManyRecords) next_commit_ = absl::Now() + kBetweenCommits;
  const absl::Status failure = Transact([&] { return InsertGroup(group); });
  for (Write& write : group) {
    if (write.kind == Write::Kind::kBarrier) {
      write.answer = rows_->CheckSound(write.scene);
    } else if (write.answer.ok() && !failure.ok()) {
      write.answer = failure;
      Break(write, failure);
    }
  }
  for (Write& write : group) queue_.Answer(write);
}

absl::Status SqliteWriter::InsertGroup(std::span<Write> group) {
  for (Write& write : group) {
    if (write.kind != Write::Kind::kAppend) continue;
    write.answer = rows_->CheckAppend(write.scene, write.lsn);
    if (!write.answer.ok()) continue;
    LATTICED_RETURN_IF_ERROR(rows_->Append(write.scene, write.lsn, write.bytes));
  }
  return rows_->Maintain();
}

void SqliteWriter::Break(const Write& write, const absl::Status& why) {
  if (rows_->CheckSound(write.scene).ok()) ++counts_->scenes_broken;
  rows_->Break(write.scene, why);
}

void SqliteWriter::ExecuteOne(Write& write) {
  if (write.kind == Write::Kind::kQuestion) {
    write.answer = CatchBadAlloc("a question to the store", write.change);
  } else if (write.kind == Write::Kind::kChange) {
    write.answer = Transact(write.change);
  } else {
    write.answer =
        Transact([&] { return rows_->PutSnapshot(write.scene, write.lsn, write.bytes); });
  }
  queue_.Answer(write);
}

absl::Status SqliteWriter::Transact(const std::function<absl::Status()>& work) {
  LATTICED_RETURN_IF_ERROR(failure_);
  const absl::Status status = TryTransaction(work);
  if (error::IsOfMedium(status)) NoteFailure(status);
  return status;
}

absl::Status SqliteWriter::TryTransaction(const std::function<absl::Status()>& work) {
  const absl::Time start = absl::Now();
  absl::Status status = database_.Execute("BEGIN IMMEDIATE");
  if (status.ok()) status = CatchBadAlloc("a transaction of the store", work);
  if (status.ok()) status = database_.Execute("COMMIT");
  if (status.ok()) {
    rows_->Committed();
    counts_->commits.Observe(absl::Now() - start);
    return status;
  }
  // SQLite may have rolled back by itself. A rollback that fails leaves the transaction to TryToRecover.
  if (database_.in_transaction() && !database_.Execute("ROLLBACK").ok()) NoteFailure(status);
  rows_->RolledBack();
  return status;
}

void SqliteWriter::NoteFailure(const absl::Status& failure) {
  failure_ = failure;
  queue_.SetRefusal(failure);
  LogEvent(spdlog::level::err, "the store refuses writes",
           {{"error", std::string(failure.message())}});
}

void SqliteWriter::Recover() {
  const absl::Status status =
      CatchBadAlloc("the store's recovery", [this] { return TryToRecover(); });
  if (!status.ok()) {
    failure_ = status;
    queue_.SetRefusal(status);
    return;
  }
  failure_ = absl::OkStatus();
  queue_.SetRefusal(failure_);
  LogEvent(spdlog::level::info, "the store accepts writes again", {});
}

absl::Status SqliteWriter::TryToRecover() {
  if (database_.in_transaction()) LATTICED_RETURN_IF_ERROR(database_.Execute("ROLLBACK"));
  if (absl::IsResourceExhausted(failure_) && RoomIn(folder_) < kRoomBytes) return failure_;
  // What the failed commit left in the log is behind the new log's first frames then, with another salt.
  const int code = sqlite3_wal_checkpoint_v2(database_.get(), nullptr, SQLITE_CHECKPOINT_TRUNCATE,
                                             nullptr, nullptr);
  if (code != SQLITE_BUSY) LATTICED_RETURN_IF_ERROR(database_.Status(code));
  LATTICED_RETURN_IF_ERROR(rows_->Load());
  return TryTransaction([this] { return rows_->SaveHeads(); });
}

void SqliteWriter::Idle() {
  if (!failure_.ok() || !rows_->WorthSweeping()) return;
  Transact([this]() -> absl::Status {
    LATTICED_RETURN_IF_ERROR(rows_->SaveHeads());
    return rows_->Sweep();
  }).IgnoreError();  // it is noted
}

void SqliteWriter::CheckpointIfDue() {
  if (log_pages_ >= kCheckpointPages) checkpointer_.Wake();
  if (log_pages_ < kMostLogPages) return;
  sqlite3_wal_checkpoint_v2(database_.get(), nullptr, SQLITE_CHECKPOINT_PASSIVE, nullptr, nullptr);
}

}  // namespace latticed
