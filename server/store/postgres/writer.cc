// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/postgres/writer.h"

#include <set>
#include <vector>

#include "absl/time/clock.h"
#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/telemetry.h"
#include "server/store/row_sum.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

constexpr char kFence[] =
    "WITH me AS MATERIALIZED (SELECT session FROM latticed.session "
    "WHERE session = $1 AND writer = $2 AND NOT fenced {}) {}";

constexpr char kCreate[] =
    "INSERT INTO latticed.scene(id, session, sum, header) SELECT $3, session, $4, $5 FROM me "
    "ON CONFLICT(id) DO NOTHING RETURNING number";
// The number comes first, since the snapshot's checksum is of it.
constexpr char kNextNumber[] = "SELECT nextval(pg_get_serial_sequence('latticed.scene', 'number'))";
constexpr char kCreateAt[] =
    ", made AS (INSERT INTO latticed.scene(number, id, session, sum, header, snapshot_lsn) "
    "OVERRIDING SYSTEM VALUE SELECT $6, $3, session, $4, $5, $7 FROM me "
    "ON CONFLICT(id) DO NOTHING RETURNING number), "
    "stored AS (INSERT INTO latticed.snapshot(scene, lsn, sum, bytes) "
    "SELECT number, $7, $8, $9 FROM made) "
    "SELECT number FROM made";
// How many were stored; and which, only if it was not $7, all of them: a client that stands still reads no long answers,
// and the statement would hold its locks meanwhile.
constexpr char kAppend[] =
    ", stored AS (INSERT INTO latticed.record(scene, lsn, sum, bytes) "
    "SELECT r.scene, r.lsn, r.sum, r.bytes "
    "FROM unnest($3::bigint[], $4::bigint[], $5::bigint[], $6::bytea[]) r(scene, lsn, sum, bytes) "
    "JOIN latticed.scene s ON s.number = r.scene JOIN me ON me.session = s.session "
    "ON CONFLICT(scene, lsn) DO NOTHING RETURNING scene, lsn) "
    "SELECT 0::bigint, count(*) FROM stored UNION ALL "
    "SELECT scene, lsn FROM stored WHERE (SELECT count(*) FROM stored) < $7";
constexpr char kReplaceSnapshot[] =
    ", put AS (UPDATE latticed.scene SET snapshot_lsn = $4 FROM me "
    "WHERE number = $3 AND scene.session = me.session AND snapshot_lsn < $4 RETURNING number), "
    "stored AS (INSERT INTO latticed.snapshot(scene, lsn, sum, bytes) "
    "SELECT number, $4, $5, $6 FROM put ON CONFLICT(scene) DO UPDATE "
    "SET lsn = EXCLUDED.lsn, sum = EXCLUDED.sum, bytes = EXCLUDED.bytes), "
    "covered AS (DELETE FROM latticed.record USING put WHERE scene = put.number AND lsn <= $4) "
    "SELECT number FROM put";
constexpr char kDeleteScene[] =
    ", gone AS (DELETE FROM latticed.scene USING me "
    "WHERE id = $3 AND scene.session = me.session RETURNING number), "
    "state AS (DELETE FROM latticed.snapshot USING gone WHERE scene = gone.number), "
    "log AS (DELETE FROM latticed.record USING gone WHERE scene = gone.number) "
    "SELECT number FROM gone";
constexpr char kRelease[] =
    "UPDATE latticed.scene SET session = NULL WHERE id = $1 AND session = $2";
// After a full disk, writing goes on when there is room for this: less would be full again at once.
constexpr char kRoom[] =
    "BEGIN; INSERT INTO latticed.record(scene, lsn, sum, bytes) "
    "SELECT 0, n, 0, convert_to(repeat('room', 16384), 'UTF8') FROM generate_series(1, 64) n; "
    "ROLLBACK";

}  // namespace

PgWriter::PgWriter(std::string url, PgLease* lease, bool fence, StoreCounts* counts)
    : url_(std::move(url)), lease_(lease), fence_(fence), counts_(counts), queue_(counts) {}

absl::Status PgWriter::Start() {
  LATTICED_RETURN_IF_ERROR(Attach());
  thread_ = std::thread([this] { Run(); });
  return absl::OkStatus();
}

PgWriter::~PgWriter() {
  queue_.Stop();
  if (thread_.joinable()) thread_.join();
}

absl::Status PgWriter::Create(std::string_view id, std::string_view header) {
  return queue_.Call(Write::Kind::kChange, [this, id, header] { return InsertScene(id, header); });
}

absl::Status PgWriter::CreateAt(std::string_view id, std::string_view header, uint64_t lsn,
                                std::string_view snapshot) {
  return queue_.Call(Write::Kind::kChange, [this, id, header, lsn, snapshot] {
    return InsertSceneAt(id, header, lsn, snapshot);
  });
}

absl::Status PgWriter::Delete(std::string_view id) {
  return queue_.Call(Write::Kind::kChange, [this, id] { return DeleteScene(id); });
}

absl::Status PgWriter::Release(std::string_view id) {
  return queue_.Call(Write::Kind::kChange, [this, id]() -> absl::Status {
    LATTICED_RETURN_IF_ERROR(Attach());
    tails_.Forget(id);
    return connection_->Execute(kRelease, PgParameters().Bytes(id).Number(session_)).status();
  });
}

absl::Status PgWriter::Settle() {
  return queue_.Call(Write::Kind::kQuestion, [this] {
    const absl::Status status = Attach();
    // A database that only refuses writes can be read.
    const bool readable = connection_ != nullptr && !connection_->lost();
    return readable && !undecided_ ? absl::OkStatus() : status;
  });
}

void PgWriter::Learn(std::string_view id, PgTail tail, int64_t session) {
  queue_
      .Call(Write::Kind::kQuestion,
            [this, id, tail, session] {
              if (session == session_) tails_.Set(id, tail);
              return absl::OkStatus();
            })
      .IgnoreError();  // it is OK
}

void PgWriter::Run() {
  while (true) {
    std::vector<Write> writes = queue_.Take(failure_.ok() ? absl::Hours(1) : kRetry);
    if (writes.empty() && queue_.Ended()) return;
    if (!failure_.ok()) Recover();
    queue_.Execute(
        writes, [this](std::span<Write> group) { AppendGroup(group); },
        [this](Write& write) { ExecuteOne(write); });
  }
}

void PgWriter::AppendGroup(std::span<Write> group) {
  absl::Status failure = failure_;
  bool in_doubt = false;
  if (failure.ok()) {
    perhaps_stored_ = false;
    failure = Noted(CatchBadAlloc("records of the store", [&] { return InsertGroup(group); }));
    in_doubt = perhaps_stored_ && !failure.ok();
  }
  for (Write& write : group) {
    if (write.kind == Write::Kind::kBarrier) {
      write.answer = tails_.CheckSound(write.scene);
    } else if (write.answer.ok()) {
      write.answer = in_doubt ? error::RecordInDoubt(write.scene) : failure;
    }
    if (!write.answer.ok()) Break(write);
    if (absl::IsAborted(write.answer) && !in_doubt) write.answer = Explain(write.scene);
  }
  for (Write& write : group) queue_.Answer(write);
}

void PgWriter::Break(const Write& write) {
  if (tails_.CheckSound(write.scene).ok()) ++counts_->scenes_broken;
  tails_.Break(write.scene, write.answer);
}

absl::Status PgWriter::InsertGroup(std::span<Write> group) {
  LATTICED_RETURN_IF_ERROR(Attach());
  std::vector<int64_t> numbers, lsns, sums;
  std::vector<std::string_view> records;
  std::vector<size_t> writes;
  for (size_t i = 0; i < group.size(); ++i) {
    Write& write = group[i];
    if (write.kind != Write::Kind::kAppend) continue;
    const absl::StatusOr<int64_t> number = tails_.Append(write.scene, write.lsn);
    write.answer = number.status();
    if (!number.ok()) continue;
    numbers.push_back(*number);
    lsns.push_back(static_cast<int64_t>(write.lsn));
    sums.push_back(RowSum(write.bytes, *number, write.lsn));
    records.push_back(write.bytes);
    writes.push_back(i);
  }
  if (writes.empty()) return absl::OkStatus();
  const absl::Time start = absl::Now();
  const auto sent = Fenced(kAppend, [&](PgParameters& parameters) {
    parameters.Numbers(numbers).Numbers(lsns).Numbers(sums).ByteStrings(records).Number(
        writes.size());
  });
  perhaps_stored_ = sent.ok() || connection_->lost();
  LATTICED_RETURN_IF_ERROR(sent.status());
  const PgRows& rows = *sent;
  counts_->commits.Observe(absl::Now() - start);
  if (rows.size() == 1 && rows.Number(0, 1) == static_cast<int64_t>(writes.size())) {
    return absl::OkStatus();
  }
  attached_ = false;  // the session may be fenced
  std::set<std::pair<int64_t, int64_t>> stored;
  for (int i = 0; i < rows.size(); ++i) stored.emplace(rows.Number(i, 0), rows.Number(i, 1));
  for (size_t i = 0; i < writes.size(); ++i) {
    if (stored.contains({numbers[i], lsns[i]})) continue;
    group[writes[i]].answer = error::SceneNotOwned(group[writes[i]].scene);
  }
  return absl::OkStatus();
}

void PgWriter::ExecuteOne(Write& write) {
  const auto execute = [&] {
    return write.kind == Write::Kind::kSnapshot ? PutSnapshot(write) : write.change();
  };
  if (write.kind == Write::Kind::kQuestion) {
    write.answer = CatchBadAlloc("a question to the store", write.change);
  } else {
    write.answer = failure_;
    if (failure_.ok()) write.answer = Noted(CatchBadAlloc("a change of the store", execute));
  }
  queue_.Answer(write);
}

absl::Status PgWriter::InsertScene(std::string_view id, std::string_view header) {
  LATTICED_RETURN_IF_ERROR(Attach());
  LATTICED_ASSIGN_OR_RETURN(const PgRows rows, Fenced(kCreate, [&](PgParameters& parameters) {
                              parameters.Bytes(id).Number(IdRowSum(id, header)).Bytes(header);
                            }));
  return NoteCreated(id, 0, rows);
}

absl::Status PgWriter::InsertSceneAt(std::string_view id, std::string_view header, uint64_t lsn,
                                     std::string_view snapshot) {
  LATTICED_RETURN_IF_ERROR(Attach());
  LATTICED_ASSIGN_OR_RETURN(const PgRows next, connection_->Execute(kNextNumber, PgParameters()));
  const int64_t number = next.Number(0, 0);
  LATTICED_ASSIGN_OR_RETURN(const PgRows rows, Fenced(kCreateAt, [&](PgParameters& parameters) {
                              parameters.Bytes(id)
                                  .Number(IdRowSum(id, header))
                                  .Bytes(header)
                                  .Number(number)
                                  .Number(lsn)
                                  .Number(RowSum(snapshot, number, lsn))
                                  .Bytes(snapshot);
                            }));
  return NoteCreated(id, lsn, rows);
}

absl::Status PgWriter::NoteCreated(std::string_view id, uint64_t lsn, const PgRows& rows) {
  if (!rows.empty()) {
    tails_.Set(id, {rows.Number(0, 0), lsn});
    return absl::OkStatus();
  }
  attached_ = false;
  // Of a fenced session nothing is created; the next try has the next session.
  const absl::Status status = Explain(id);
  return absl::IsNotFound(status) ? status : error::AlreadyExists("scene", id);
}

absl::Status PgWriter::DeleteScene(std::string_view id) {
  LATTICED_RETURN_IF_ERROR(Attach());
  tails_.Forget(id);
  LATTICED_ASSIGN_OR_RETURN(const PgRows rows, Fenced(kDeleteScene, [&](PgParameters& parameters) {
                              parameters.Bytes(id);
                            }));
  if (!rows.empty()) return absl::OkStatus();
  attached_ = false;
  return Explain(id);
}

absl::Status PgWriter::PutSnapshot(const Write& write) {
  LATTICED_RETURN_IF_ERROR(Attach());
  // It may have a record that was refused.
  LATTICED_RETURN_IF_ERROR(tails_.CheckSound(write.scene));
  const PgTail* tail = tails_.Find(write.scene);
  if (tail == nullptr) return Explain(write.scene);
  if (write.lsn == 0 || write.lsn > tail->lsn) {
    return error::NotNextRecord(write.scene, tail->lsn, write.lsn);
  }
  LATTICED_ASSIGN_OR_RETURN(const PgRows rows,
                            Fenced(kReplaceSnapshot, [&](PgParameters& parameters) {
                              parameters.Number(tail->number)
                                  .Number(write.lsn)
                                  .Number(RowSum(write.bytes, tail->number, write.lsn))
                                  .Bytes(write.bytes);
                            }));
  if (!rows.empty()) return absl::OkStatus();
  attached_ = false;
  return absl::FailedPreconditionError(
      fmt::format("scene '{}': it has a later snapshot, or is another server's", write.scene));
}

absl::Status PgWriter::Noted(absl::Status status) {
  if (!error::IsOfMedium(status)) return status;
  failure_ = status;
  queue_.SetRefusal(status);
  LogEvent(spdlog::level::err, "the store refuses writes",
           {{"error", std::string(status.message())}});
  return status;
}

absl::Status PgWriter::Explain(std::string_view id) {
  if (connection_ == nullptr || connection_->lost()) return error::SceneNotOwned(id);
  LATTICED_ASSIGN_OR_RETURN(const PgRows rows,
                            connection_->Execute("SELECT number FROM latticed.scene WHERE id = $1",
                                                 PgParameters().Bytes(id)));
  return rows.empty() ? error::NotFound("scene", id) : error::SceneNotOwned(id);
}

absl::StatusOr<PgRows> PgWriter::Fenced(std::string_view rest,
                                        const std::function<void(PgParameters&)>& more) {
  PgParameters parameters;
  parameters.Number(session_).Number(number_);
  more(parameters);
  auto rows =
      connection_->Execute(fmt::format(kFence, fence_ ? "FOR KEY SHARE" : "", rest), parameters);
  if (connection_->lost()) undecided_ = true;
  return rows;
}

absl::Status PgWriter::Attach() {
  if (connection_ == nullptr || connection_->lost()) {
    attached_ = false;
    connection_.reset();
    LATTICED_ASSIGN_OR_RETURN(PgConnection connection, PgConnection::Open(url_));
    connection_ = std::make_unique<PgConnection>(std::move(connection));
  }
  int64_t session = lease_->session();
  while (!attached_ || session != session_) {
    LATTICED_ASSIGN_OR_RETURN(const PgRows rows,
                              connection_->Execute("SELECT coalesce(latticed.attach($1), 0)",
                                                   PgParameters().Number(session)));
    const int64_t number = rows.Number(0, 0);
    if (number == 0) {
      const int64_t next = lease_->WaitForNext(session);
      if (next == session) return error::StoreFailed("PostgreSQL: this server lost its lease");
      session = next;
      continue;
    }
    if (session != session_) tails_.Clear();
    session_ = session;
    number_ = number;
    attached_ = true;
    undecided_ = false;  // attach() has waited for it
  }
  return absl::OkStatus();
}

void PgWriter::Recover() {
  const absl::Status status =
      CatchBadAlloc("the store's recovery", [this] { return TryToRecover(); });
  failure_ = status;
  queue_.SetRefusal(status);
  if (status.ok()) LogEvent(spdlog::level::info, "the store accepts writes again", {});
}

absl::Status PgWriter::TryToRecover() {
  const bool full = absl::IsResourceExhausted(failure_);
  attached_ = false;  // to attach is to write
  LATTICED_RETURN_IF_ERROR(Attach());
  if (!full) return absl::OkStatus();
  const absl::Status room = connection_->Execute(kRoom);
  if (!room.ok()) connection_->Execute("ROLLBACK").IgnoreError();  // of a connection that is lost
  return room;
}

}  // namespace latticed
