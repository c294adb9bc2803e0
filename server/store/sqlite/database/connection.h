// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A connection to the database, and a transaction of it.
//
// Errors   as statement.h
// Threads  one at a time
#ifndef LATTICED_SERVER_STORE_SQLITE_DATABASE_CONNECTION_H_
#define LATTICED_SERVER_STORE_SQLITE_DATABASE_CONNECTION_H_

#include <sqlite3.h>

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/store/sqlite/database/statement.h"

namespace latticed {

class SqliteConnection {
 public:
  // Opens the file through the checks of checked_vfs.h, and makes it if it is not there. `sync` says whether a commit
  // waits for the medium.
  [[nodiscard]] static absl::StatusOr<SqliteConnection> Open(const std::string& path, bool sync);
  // The same file, which must be there, without writing to it or to its log, whether or not others do.
  [[nodiscard]] static absl::StatusOr<SqliteConnection> OpenToRead(const std::string& path);

  // Executes statements without rows.
  [[nodiscard]] absl::Status Execute(const char* sql);
  [[nodiscard]] absl::StatusOr<SqliteStatement> Prepare(const char* sql);
  // The only column of the only row.
  [[nodiscard]] absl::StatusOr<int64_t> Number(const char* sql);
  [[nodiscard]] absl::Status Status(int code) { return SqliteStatus(database_.get(), code); }
  bool in_transaction() const { return sqlite3_get_autocommit(database_.get()) == 0; }
  sqlite3* get() { return database_.get(); }

 private:
  struct Close {
    void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
  };
  [[nodiscard]] static absl::StatusOr<SqliteConnection> OpenAs(const std::string& path, int flags);
  explicit SqliteConnection(sqlite3* database) : database_(database) {}

  std::unique_ptr<sqlite3, Close> database_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_SQLITE_DATABASE_CONNECTION_H_
