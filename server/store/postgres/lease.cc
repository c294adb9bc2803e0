// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/postgres/lease.h"

#include <utility>

#include "core/base/status_macros.h"
#include "server/base/telemetry.h"

namespace latticed {
namespace {

constexpr int kRenewals = 4;
constexpr absl::Duration kPatience = absl::Seconds(3);

// Sessions that nobody needs to know of any more. Whose session is not there counts as fenced.
constexpr char kForget[] =
    "WITH gone AS (DELETE FROM latticed.session "
    "WHERE expires < clock_timestamp() - interval '1 day' RETURNING session) "
    "UPDATE latticed.scene SET session = NULL FROM gone WHERE scene.session = gone.session";
constexpr char kJoin[] =
    "INSERT INTO latticed.session(name, lease, expires, free_bytes) "
    "VALUES($1, $2 * interval '1 us', clock_timestamp() + $2 * interval '1 us', $3) "
    "RETURNING session";
constexpr char kRenew[] =
    "UPDATE latticed.session SET expires = clock_timestamp() + lease, free_bytes = $2 "
    "WHERE session = $1 AND NOT fenced RETURNING session";
// As claim() it waits for an append under way, which a lost connection of the writer may have left. The lease runs out
// where that takes long.
constexpr char kEndSoon[] = "SET lock_timeout = '2s'";
constexpr char kEnd[] =
    "WITH me AS MATERIALIZED (SELECT session FROM latticed.session WHERE session = $1 FOR UPDATE) "
    "UPDATE latticed.session SET fenced = true, expires = clock_timestamp() FROM me "
    "WHERE latticed.session.session = me.session";

}  // namespace

PgLease::PgLease(std::string url, std::string name, absl::Duration length)
    : url_(std::move(url)), name_(std::move(name)), length_(length) {}

absl::Status PgLease::Start() {
  LATTICED_RETURN_IF_ERROR(Connect());
  LATTICED_RETURN_IF_ERROR(Join());
  thread_ = std::thread([this] { Run(); });
  return absl::OkStatus();
}

PgLease::~PgLease() {
  {
    MutexLock lock(&mutex_);
    stopped_ = true;
  }
  if (thread_.joinable()) thread_.join();
  if (connection_ == nullptr || session() == 0) return;
  if (!connection_->Execute(kEndSoon).ok()) return;
  connection_->Execute(kEnd, PgParameters().Number(session())).status().IgnoreError();
}

int64_t PgLease::session() const {
  MutexLock lock(&mutex_);
  return session_;
}

int64_t PgLease::WaitForNext(int64_t session) {
  MutexLock lock(&mutex_);
  doubted_ = true;
  mutex_.AwaitFor([&] { return session_ != session || stopped_; }, kPatience);
  return session_;
}

void PgLease::OnFenced(std::function<void()> fenced) {
  MutexLock lock(&callback_mutex_);
  fenced_ = std::move(fenced);
}

void PgLease::SetFreeBytes(uint64_t bytes) {
  MutexLock lock(&mutex_);
  free_bytes_ = bytes;
}

void PgLease::Run() {
  absl::Time next = absl::Now();
  while (true) {
    {
      MutexLock lock(&mutex_);
      mutex_.AwaitFor([this] { return stopped_ || doubted_; }, next - absl::Now());
      if (stopped_) return;
      doubted_ = false;
    }
    next = absl::Now() + length_ / kRenewals;
    Note(Renew());
  }
}

absl::Status PgLease::Connect() {
  if (connection_ != nullptr && !connection_->lost()) return absl::OkStatus();
  connection_.reset();
  LATTICED_ASSIGN_OR_RETURN(PgConnection connection, PgConnection::Open(url_));
  connection_ = std::make_unique<PgConnection>(std::move(connection));
  return absl::OkStatus();
}

absl::Status PgLease::Join() {
  uint64_t free_bytes = 0;
  {
    MutexLock lock(&mutex_);
    free_bytes = free_bytes_;
  }
  // The number of a session must outlive a crash of the database: it is never used again.
  LATTICED_RETURN_IF_ERROR(connection_->Execute("SET synchronous_commit = on"));
  LATTICED_RETURN_IF_ERROR(connection_->Execute(kForget, {}).status());
  LATTICED_ASSIGN_OR_RETURN(
      const PgRows joined,
      connection_->Execute(
          kJoin,
          PgParameters().Text(name_).Number(length_ / absl::Microseconds(1)).Number(free_bytes)));
  // After a crash of the database all leases are good anew, so a renewal need not wait for the disk.
  LATTICED_RETURN_IF_ERROR(connection_->Execute("SET synchronous_commit = off"));
  MutexLock lock(&mutex_);
  session_ = joined.Number(0, 0);
  return absl::OkStatus();
}

absl::Status PgLease::Renew() {
  LATTICED_RETURN_IF_ERROR(Connect());
  PgParameters parameters;
  {
    MutexLock lock(&mutex_);
    parameters.Number(session_).Number(free_bytes_);
  }
  LATTICED_ASSIGN_OR_RETURN(const PgRows renewed, connection_->Execute(kRenew, parameters));
  if (!renewed.empty()) return absl::OkStatus();
  LATTICED_RETURN_IF_ERROR(Join());
  LogEvent(spdlog::level::warn, "another server took over: this one's lease had run out",
           {{"lease", absl::FormatDuration(length_)}});
  MutexLock lock(&callback_mutex_);
  if (fenced_) fenced_();
  return absl::OkStatus();
}

void PgLease::Note(const absl::Status& status) {
  if (failing_ == !status.ok()) return;
  failing_ = !status.ok();
  if (failing_) {
    LogEvent(spdlog::level::err, "the lease is not renewed",
             {{"error", std::string(status.message())}});
  } else {
    LogEvent(spdlog::level::info, "the lease is renewed again", {});
  }
}

}  // namespace latticed
