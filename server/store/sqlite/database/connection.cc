// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/sqlite/database/connection.h"

#include <utility>

#include "core/base/status_macros.h"
#include "server/store/sqlite/database/checked_vfs.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

// How long a connection waits for another: only recovery after a crash and the ends of checkpoints exclude others.
constexpr int kBusyMs = 10'000;

}  // namespace

absl::StatusOr<SqliteConnection> SqliteConnection::OpenAs(const std::string& path, int flags) {
  LATTICED_ASSIGN_OR_RETURN(const char* vfs, CheckedVfs());
  sqlite3* database = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &database, flags | SQLITE_OPEN_NOMUTEX, vfs);
  SqliteConnection connection(database);
  if (database == nullptr) return error::StoreFailed(path + ": no memory");
  LATTICED_RETURN_IF_ERROR(connection.Status(code));
  sqlite3_extended_result_codes(database, 1);
  sqlite3_busy_timeout(database, kBusyMs);
  // Checkpoints are for another thread than the writer's. A mapped file would turn a cut one into SIGBUS.
  LATTICED_RETURN_IF_ERROR(connection.Execute(
      "PRAGMA wal_autocheckpoint = 0; PRAGMA mmap_size = 0; PRAGMA trusted_schema = OFF;"
      "PRAGMA cell_size_check = ON; PRAGMA temp_store = MEMORY"));
  return connection;
}

absl::StatusOr<SqliteConnection> SqliteConnection::Open(const std::string& path, bool sync) {
  LATTICED_ASSIGN_OR_RETURN(SqliteConnection connection,
                            OpenAs(path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE));
  LATTICED_RETURN_IF_ERROR(
      connection.Execute(sync ? "PRAGMA synchronous = FULL" : "PRAGMA synchronous = NORMAL"));
  return connection;
}

absl::StatusOr<SqliteConnection> SqliteConnection::OpenToRead(const std::string& path) {
  LATTICED_ASSIGN_OR_RETURN(SqliteConnection connection, OpenAs(path, SQLITE_OPEN_READONLY));
  // The last connection that closes would copy the log into the file.
  LATTICED_RETURN_IF_ERROR(connection.Status(sqlite3_db_config(
      connection.get(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, static_cast<int*>(nullptr))));
  return connection;
}

absl::Status SqliteConnection::Execute(const char* sql) {
  return Status(sqlite3_exec(database_.get(), sql, nullptr, nullptr, nullptr));
}

absl::StatusOr<SqliteStatement> SqliteConnection::Prepare(const char* sql) {
  sqlite3_stmt* statement = nullptr;
  LATTICED_RETURN_IF_ERROR(Status(sqlite3_prepare_v3(
      database_.get(), sql, -1, SQLITE_PREPARE_PERSISTENT, &statement, nullptr)));
  return SqliteStatement(statement);
}

absl::StatusOr<int64_t> SqliteConnection::Number(const char* sql) {
  LATTICED_ASSIGN_OR_RETURN(SqliteStatement statement, Prepare(sql));
  LATTICED_RETURN_IF_ERROR(statement.Step().status());
  return statement.Integer(0);
}

}  // namespace latticed
