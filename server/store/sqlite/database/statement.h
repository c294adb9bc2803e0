// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A prepared statement of SQLite, and its errors as statuses.
//
//   LATTICED_ASSIGN_OR_RETURN(auto rows, connection.Prepare("SELECT lsn FROM record WHERE row = ?"));
//   rows.Bind(1, row);
//   LATTICED_ASSIGN_OR_RETURN(const bool found, rows.Step());
//
// Errors   kResourceExhausted, reason STORE: no room; kDataLoss: the file is damaged; kUnavailable, reason STORE: all
//          others. Messages name the file
// Threads  one at a time, that of the connection
#ifndef LATTICED_SERVER_STORE_SQLITE_DATABASE_STATEMENT_H_
#define LATTICED_SERVER_STORE_SQLITE_DATABASE_STATEMENT_H_

#include <sqlite3.h>

#include <cstdint>
#include <memory>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace latticed {

// The status of SQLite's result code `code`, which a call on `database` has just returned.
[[nodiscard]] absl::Status SqliteStatus(sqlite3* database, int code);

class SqliteStatement {
 public:
  explicit SqliteStatement(sqlite3_stmt* statement) : statement_(statement) {}

  // Parameters count from 1. Bytes must stay alive until Reset.
  void Bind(int parameter, int64_t value);
  void Bind(int parameter, uint64_t value) { Bind(parameter, static_cast<int64_t>(value)); }
  void BindBytes(int parameter, std::string_view bytes);

  // Whether there is another row.
  [[nodiscard]] absl::StatusOr<bool> Step();
  // Executes a statement without rows, and resets it.
  [[nodiscard]] absl::Status Run();
  // Ends the execution. Parameters keep their values.
  void Reset() { sqlite3_reset(statement_.get()); }

  // Columns of the row, from 0. Bytes are valid until the next Step or Reset.
  int64_t Integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }
  uint64_t Unsigned(int column) const { return static_cast<uint64_t>(Integer(column)); }
  std::string_view Bytes(int column) const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_SQLITE_DATABASE_STATEMENT_H_
