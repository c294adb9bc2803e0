// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A connection to PostgreSQL. A dead network is noticed within some four seconds, by both sides; a slow database never: it
// is waited for.
//
// Errors   kResourceExhausted, reason STORE: no room; kUnavailable, reason STORE: everything else, in one line without the
//          password. After lost() nobody knows whether the statement was executed
// Threads  one at a time
#ifndef LATTICED_SERVER_STORE_POSTGRES_CONNECTION_H_
#define LATTICED_SERVER_STORE_POSTGRES_CONNECTION_H_

#include <libpq-fe.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/store/postgres/parameters.h"

namespace latticed {

// What a statement answered.
class PgRows {
 public:
  int size() const { return PQntuples(result_.get()); }
  bool empty() const { return size() == 0; }
  // Valid as long as this is.
  std::string_view Bytes(int row, int column) const {
    return {PQgetvalue(result_.get(), row, column),
            static_cast<size_t>(PQgetlength(result_.get(), row, column))};
  }
  int64_t Number(int row, int column) const { return PgNumber(Bytes(row, column)); }

 private:
  friend class PgConnection;

  struct Clear {
    void operator()(PGresult* result) const { PQclear(result); }
  };
  explicit PgRows(PGresult* result) : result_(result) {}

  std::unique_ptr<PGresult, Clear> result_;
};

class PgConnection {
 public:
  // `url` as libpq reads it: postgresql://user:password@host:port/database?options, or key = value.
  [[nodiscard]] static absl::StatusOr<PgConnection> Open(const std::string& url);
  // kInvalidArgument if it is none, or libpq would name a part of its password. The message does not repeat it.
  [[nodiscard]] static absl::Status CheckUrl(const std::string& url);

  // One statement, which is prepared when it is executed first.
  [[nodiscard]] absl::StatusOr<PgRows> Execute(const std::string& sql,
                                               const PgParameters& parameters);
  // Statements without parameters and rows, in one transaction unless they say otherwise.
  [[nodiscard]] absl::Status Execute(const char* sql);

  // Or without an answer to a statement: libpq may have had no memory for it.
  bool lost() const { return unanswered_ || PQstatus(connection_.get()) != CONNECTION_OK; }

 private:
  struct Finish {
    void operator()(PGconn* connection) const { PQfinish(connection); }
  };
  explicit PgConnection(PGconn* connection) : connection_(connection) {}

  absl::Status StatusOf(const PGresult* result);

  std::unique_ptr<PGconn, Finish> connection_;
  bool unanswered_ = false;
  std::map<std::string, std::string, std::less<>> prepared_;  // names by SQL
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_POSTGRES_CONNECTION_H_
