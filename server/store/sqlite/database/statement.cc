// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/sqlite/database/statement.h"

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <string>

#include "core/base/error.h"
#include "fmt/format.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

bool NoRoom(int system_error) {
  return system_error == ENOSPC || system_error == EDQUOT || system_error == EFBIG;
}

}  // namespace

absl::Status SqliteStatus(sqlite3* database, int code) {
  const int kind = code & 0xFF;
  if (kind == SQLITE_OK || kind == SQLITE_ROW || kind == SQLITE_DONE) return absl::OkStatus();
  const char* file = sqlite3_db_filename(database, "main");
  const int system_error = sqlite3_system_errno(database);
  // Without its folder, which is none of a client's business.
  const std::string name = std::filesystem::path(file == nullptr ? "" : file).filename();
  std::string problem = fmt::format("{}: {}", name, sqlite3_errmsg(database));
  if (code == SQLITE_IOERR_DATA || kind == SQLITE_CORRUPT || kind == SQLITE_NOTADB) {
    return error::Damaged(
        name, code == SQLITE_IOERR_DATA ? "a page is not what was written" : sqlite3_errstr(code));
  }
  if (kind == SQLITE_NOMEM) return error::AllocationFailed("a statement of the store");
  if (kind == SQLITE_IOERR && system_error != 0) {
    problem += fmt::format(" ({})", std::strerror(system_error));
  }
  if (kind == SQLITE_FULL || (kind == SQLITE_IOERR && NoRoom(system_error))) {
    return error::StoreFull(problem);
  }
  return error::StoreFailed(problem);
}

void SqliteStatement::Bind(int parameter, int64_t value) {
  sqlite3_bind_int64(statement_.get(), parameter, value);
}

void SqliteStatement::BindBytes(int parameter, std::string_view bytes) {
  // A null pointer would bind NULL.
  sqlite3_bind_blob64(statement_.get(), parameter, bytes.empty() ? "" : bytes.data(), bytes.size(),
                      SQLITE_STATIC);
}

absl::StatusOr<bool> SqliteStatement::Step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  return SqliteStatus(sqlite3_db_handle(statement_.get()), code);
}

absl::Status SqliteStatement::Run() {
  const absl::Status status = Step().status();
  Reset();
  return status;
}

std::string_view SqliteStatement::Bytes(int column) const {
  const void* bytes = sqlite3_column_blob(statement_.get(), column);
  const auto size = static_cast<size_t>(sqlite3_column_bytes(statement_.get(), column));
  return {static_cast<const char*>(bytes), bytes == nullptr ? 0 : size};
}

}  // namespace latticed
