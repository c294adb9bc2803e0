// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What only the store in PostgreSQL has: how it is opened.
#include <cstdlib>
#include <memory>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/store/postgres_store.h"
#include "tests/server/store/postgres_server.h"
#include "tests/support/status_matchers.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

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
  EXPECT_THAT(
      Open("postgresql://user:secret@127.0.0.1:1/database").status(),
      StatusIs(absl::StatusCode::kUnavailable,
               AllOf(HasSubstr("127.0.0.1"), Not(HasSubstr("secret")), Not(HasSubstr("\n")))));
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

}  // namespace
}  // namespace latticed::testing
