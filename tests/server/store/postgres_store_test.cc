// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What only the store in PostgreSQL has: how it is opened.
#include <cstdlib>
#include <future>
#include <memory>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/store/postgres/connection.h"
#include "server/store/postgres_store.h"
#include "tests/server/store/postgres_server.h"
#include "tests/server/store/store_family.h"
#include "tests/support/status_matchers.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// Ends the connections that wait for a lock of the table of records.
constexpr char kEndWaiting[] =
    "SELECT pg_terminate_backend(pid) FROM pg_locks "
    "WHERE relation = 'latticed.record'::regclass AND NOT granted";

class PostgresStore : public ::testing::Test {
 protected:
  void SetUp() override {
    if (PostgresServer::IsInstalled()) return;
    ASSERT_EQ(std::getenv("LATTICED_REQUIRE_POSTGRES"), nullptr) << "PostgreSQL is not installed";
    GTEST_SKIP() << "PostgreSQL is not installed: no store was tested with it";
  }
  absl::StatusOr<std::unique_ptr<Store>> Open(const std::string& url) {
    return OpenPostgresStore({.url_file = folder_.Write("url", url + "\n"),
                              .mesh_folder = folder_.Path("meshes"),
                              .name = "host-1:50051"});
  }

  const TemporaryFolder folder_;
};

TEST_F(PostgresStore, RefusesAWrongUrlWithoutRepeatingIt) {
  EXPECT_THAT(Open("postgres//user:secret@host").status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr(folder_.Path("url")), Not(HasSubstr("secret")))));
  EXPECT_THAT(Open("").status(), StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_THAT(OpenPostgresStore({.url_file = folder_.Path("none")}).status(),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("none")));
}

TEST_F(PostgresStore, NamesADatabaseThatDoesNotAnswer) {
  EXPECT_THAT(Open("postgresql://user:secret@127.0.0.1:1/database").status(),
              StatusIs(absl::StatusCode::kUnavailable,
                       AllOf(HasSubstr("127.0.0.1"), Not(HasSubstr("secret")), Not(HasSubstr("\n")),
                             Not(HasSubstr("?")))));
}

TEST_F(PostgresStore, RefusesANewerSchema) {
  const std::string url = PostgresServer::Shared().NewDatabase();
  ASSERT_OK(Open(url).status());
  ExecuteSql(url, "UPDATE latticed.version SET number = 2");

  EXPECT_THAT(
      Open(url).status(),
      StatusIs(absl::StatusCode::kFailedPrecondition,
               "the database has schema 2, which a newer latticed made; this one reads up to 1"));
}

TEST_F(PostgresStore, RefusesAnothersSchema) {
  const std::string url = PostgresServer::Shared().NewDatabase();
  ExecuteSql(url, "CREATE SCHEMA latticed; CREATE TABLE latticed.scene(id text)");

  EXPECT_THAT(Open(url).status(),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("another program")));
}

TEST_F(PostgresStore, AnAppendWhoseAnswerIsLostIsAborted) {
  const std::string url = PostgresServer::Shared().NewDatabase();
  ASSERT_OK_AND_ASSIGN(const auto store, Open(url));
  ASSERT_OK(store->CreateScene("gear", ""));
  {
    // The append waits for a lock when its connection is ended, and then the next connection waits for one.
    ASSERT_OK_AND_ASSIGN(PgConnection connection, PgConnection::Open(url));
    ASSERT_OK(
        connection.Execute("BEGIN; LOCK TABLE latticed.record IN EXCLUSIVE MODE; "
                           "LOCK TABLE latticed.session IN SHARE MODE"));
    auto append = std::async(std::launch::async, [&] { return AppendTo(*store, "gear", 1, "x"); });
    absl::StatusOr<PgRows> ended = connection.Execute(kEndWaiting, {});
    while (ended.ok() && ended->empty()) ended = connection.Execute(kEndWaiting, {});
    ASSERT_OK(ended.status());

    EXPECT_THAT(append.get(), StatusIs(absl::StatusCode::kAborted, HasSubstr("does not know")));
    EXPECT_THAT(store->Admit(), StatusIs(absl::StatusCode::kUnavailable));
  }
  ASSERT_OK_AND_ASSIGN(const SceneLog log, store->ReadScene("gear"));
  EXPECT_EQ(log.lsn(), 0U);
  EXPECT_OK(AppendTo(*store, "gear", 1, "x"));
}

}  // namespace
}  // namespace latticed::testing
