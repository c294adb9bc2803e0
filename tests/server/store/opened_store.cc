// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/store/opened_store.h"

#include <cstdlib>
#include <future>
#include <utility>

#include "absl/time/clock.h"
#include "server/store/memory_store.h"
#include "server/store/postgres_store.h"
#include "server/store/shared_memory_store.h"
#include "server/store/sqlite_store.h"
#include "server/store/store_errors.h"
#include "tests/server/store/fault_vfs.h"
#include "tests/server/store/postgres_server.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

// What PostgreSQL answers when its disk is full.
constexpr char kFillPostgres[] = R"sql(
CREATE OR REPLACE FUNCTION public.full() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN RAISE EXCEPTION 'could not extend file: No space left on device' USING ERRCODE = 'disk_full'; END $$;
CREATE TRIGGER full_test BEFORE INSERT ON latticed.record EXECUTE FUNCTION public.full();
CREATE TRIGGER full_test BEFORE INSERT ON latticed.scene EXECUTE FUNCTION public.full();
CREATE TRIGGER full_test BEFORE INSERT ON latticed.snapshot EXECUTE FUNCTION public.full();
)sql";
constexpr char kEmptyPostgres[] =
    "DROP TRIGGER full_test ON latticed.record; DROP TRIGGER full_test ON latticed.scene; "
    "DROP TRIGGER full_test ON latticed.snapshot";

}  // namespace

OpenedStore::OpenedStore(std::string kind) : kind_(std::move(kind)) {
  UseFaultVfs();
  Open();
}

OpenedStore::~OpenedStore() { SetDiskFault(DiskFault::kNone); }

void OpenedStore::Open() {
  if (kind_ == "memory") {
    store_ = std::make_unique<MemoryStore>();
    return;
  }
  if (kind_ == "postgres") return OpenPostgres();
  if (kind_ == "shared_memory") {
    store_ = std::make_unique<SharedMemoryStore>(std::make_shared<SharedMemory>(), "host-1");
    return;
  }
  absl::StatusOr<std::unique_ptr<Store>> opened = OpenSqliteStore({.folder = folder_.Path("data")});
  if (!opened.ok()) throw std::runtime_error(opened.status().ToString());
  store_ = *std::move(opened);
}

void OpenedStore::OpenPostgres() {
  if (url_.empty()) url_ = PostgresServer::Shared().NewDatabase();
  absl::StatusOr<std::unique_ptr<Store>> opened =
      OpenPostgresStore({.url_file = folder_.Write("url", url_),
                         .mesh_store = folder_.Path("meshes"),
                         .name = "host-1:50051"});
  if (!opened.ok()) throw std::runtime_error(opened.status().ToString());
  store_ = *std::move(opened);
}

void OpenedStore::SetFull(bool full) {
  if (auto* memory = dynamic_cast<MemoryStore*>(store_.get())) {
    memory->SetFailure(full ? error::StoreFull("told so") : absl::OkStatus());
  }
  if (kind_ == "postgres") ExecuteSql(url_, full ? kFillPostgres : kEmptyPostgres);
  SetDiskFault(full ? DiskFault::kFull : DiskFault::kNone);
}

void OpenedStore::SetStalled(bool stalled) {
  if (auto* memory = dynamic_cast<MemoryStore*>(store_.get())) {
    stalled ? memory->Pause() : memory->Resume();
  }
  if (kind_ == "postgres" && stalled) {
    locker_ = std::make_unique<PgConnection>(*PgConnection::Open(url_));
    if (!locker_->Execute("BEGIN; LOCK TABLE latticed.record IN EXCLUSIVE MODE").ok()) std::abort();
  } else {
    locker_ = nullptr;
  }
  SetDiskFault(stalled ? DiskFault::kStalls : DiskFault::kNone);
}

absl::Status OpenedStore::Append(std::string_view scene, uint64_t lsn, std::string record) {
  const auto answer = std::make_shared<std::promise<absl::Status>>();
  store_->Append(scene, lsn, std::move(record),
                 [answer](const absl::Status& status) { answer->set_value(status); });
  return answer->get_future().get();
}

bool OpenedStore::AdmitsAgain() {
  const absl::Time end = absl::Now() + absl::Minutes(1);
  while (absl::Now() < end) {
    if (store_->Admit().ok()) return true;
    absl::SleepFor(absl::Milliseconds(10));
  }
  return false;
}

}  // namespace latticed::testing
