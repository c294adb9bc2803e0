// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Stores in a new database of the shared PostgreSQL.
#ifndef LATTICED_TESTS_SERVER_STORE_POSTGRES_POSTGRES_STORE_H_
#define LATTICED_TESTS_SERVER_STORE_POSTGRES_POSTGRES_STORE_H_

#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>

#include "absl/time/clock.h"
#include "fmt/format.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/store/postgres/connection.h"
#include "server/store/postgres_store.h"
#include "tests/server/store/postgres_server.h"
#include "tests/server/store/store_family.h"
#include "tests/support/status_matchers.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {

class PostgresStore : public ::testing::Test {
 protected:
  void SetUp() override {
    if (PostgresServer::IsInstalled()) {
      url_ = PostgresServer::Shared().NewDatabase();
      return;
    }
    ASSERT_EQ(std::getenv("LATTICED_REQUIRE_POSTGRES"), nullptr) << "PostgreSQL is not installed";
    GTEST_SKIP() << "PostgreSQL is not installed: no store was tested with it";
  }
  absl::StatusOr<std::unique_ptr<Store>> Open(const std::string& url,
                                              absl::Duration lease = absl::Seconds(2)) {
    return OpenPostgresStore({.url_file = folder_.Write("url", url + "\n"),
                              .mesh_store = folder_.Path("meshes"),
                              .name = "host-1:50051",
                              .lease = lease});
  }
  // Waits until the statement has a row, and returns that.
  static PgRows AwaitRow(PgConnection& connection, const std::string& sql) {
    const absl::Time end = absl::Now() + absl::Minutes(1);
    while (true) {
      absl::StatusOr<PgRows> rows = connection.Execute(sql, {});
      if (!rows.ok()) throw std::runtime_error(rows.status().ToString());
      if (!rows->empty()) return *std::move(rows);
      if (absl::Now() > end) throw std::runtime_error("no row comes: " + sql);
      absl::SleepFor(absl::Milliseconds(1));
    }
  }

  const TemporaryFolder folder_;
  std::string url_;  // of an empty database
};

// The number in the only row of a statement.
inline int64_t NumberOf(PgConnection& connection, const std::string& sql) {
  absl::StatusOr<PgRows> rows = connection.Execute(sql, {});
  if (!rows.ok()) throw std::runtime_error(rows.status().ToString());
  return rows->Number(0, 0);
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_STORE_POSTGRES_POSTGRES_STORE_H_
