// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What only the store in PostgreSQL has: how it is opened.
#include <future>

#include "tests/server/store/postgres/postgres_store.h"

namespace latticed::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(PostgresStore, RefusesAWrongUrlWithoutRepeatingIt) {
  EXPECT_THAT(Open("postgres//user:secret@host").status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr(folder_.Path("url")), Not(HasSubstr("secret")))));
  EXPECT_THAT(Open("").status(), StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_THAT(OpenPostgresStore({.url_file = folder_.Path("none")}).status(),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("none")));
}

TEST_F(PostgresStore, RefusesAPasswordThatLibpqWouldRepeat) {
  for (const std::string url :
       {"postgresql://ann:pre@secret@127.0.0.1:1/db", "postgres://ann:secret/post@127.0.0.1:1/db",
        "postgresql://ann:1/secret@127.0.0.1/db", "postgresql://ann:1?user=secret@127.0.0.1",
        "postgresql://ann:1#secret@127.0.0.1", "postgresql://ann:secret/db"}) {
    EXPECT_THAT(Open(url).status(),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         AllOf(HasSubstr("percent-encode"), Not(HasSubstr("secret")))))
        << url;
  }
  for (const std::string url : {"postgresql://ann:a%40%2F%3F%23%25b@127.0.0.1:1/db",
                                "postgresql://ann@127.0.0.1:1,[::1]:1/db",
                                "host=127.0.0.1 port=1 user=ann password='a@/?#b'"}) {
    EXPECT_OK(PgConnection::CheckUrl(url)) << url;
    EXPECT_THAT(Open(url).status(), StatusIs(absl::StatusCode::kUnavailable, Not(HasSubstr("a@/"))))
        << url;
  }
}

TEST_F(PostgresStore, NamesADatabaseThatDoesNotAnswer) {
  EXPECT_THAT(Open("postgresql://user:secret@127.0.0.1:1/database").status(),
              StatusIs(absl::StatusCode::kUnavailable,
                       AllOf(HasSubstr("127.0.0.1"), Not(HasSubstr("secret")), Not(HasSubstr("\n")),
                             Not(HasSubstr("?")))));
}

TEST_F(PostgresStore, RefusesANewerSchema) {
  ASSERT_OK(Open(url_).status());
  ExecuteSql(url_, "UPDATE latticed.version SET number = 4");

  EXPECT_THAT(
      Open(url_).status(),
      StatusIs(absl::StatusCode::kFailedPrecondition,
               "the database has schema 4, which a newer latticed made; this one reads up to 3"));
}

TEST_F(PostgresStore, UpgradesTheFirstSchema) {
  {
    ASSERT_OK_AND_ASSIGN(const auto store, Open(url_));
    ASSERT_OK(store->CreateScene("gear", "header"));
    ASSERT_OK(AppendTo(*store, "gear", 1, "x"));
  }
  ExecuteSql(url_,
             "DROP TABLE latticed.share; DROP TRIGGER note_use ON latticed.scene; DROP FUNCTION "
             "latticed.note_use, "
             "latticed.expire; ALTER TABLE latticed.scene DROP COLUMN used; "
             "UPDATE latticed.version SET number = 1");

  ASSERT_OK_AND_ASSIGN(const auto store, Open(url_));
  ASSERT_OK(store->ClaimScene("gear").status());
  ASSERT_OK_AND_ASSIGN(const SceneLog log, store->ReadScene("gear"));
  EXPECT_EQ(log.records, std::vector<std::string>{"x"});
  EXPECT_OK(store->PutShare("a", "gear", "header"));
  ASSERT_OK(store->ReleaseScene("gear"));
  EXPECT_OK(store->ExpireScene("gear", absl::ZeroDuration()));
  EXPECT_THAT(store->ReadSceneHeader("gear"), StatusIs(absl::StatusCode::kNotFound));
}

TEST_F(PostgresStore, RefusesAnothersSchema) {
  ExecuteSql(url_, "CREATE SCHEMA latticed; CREATE TABLE latticed.scene(id text)");

  EXPECT_THAT(Open(url_).status(),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("another program")));
}

// Else the locks of a server whose host is gone would last for hours.
TEST_F(PostgresStore, ItsServerNoticesADeadNetworkToo) {
  PostgresServer over_network(PostgresServer::Network::kTcp);
  ASSERT_OK_AND_ASSIGN(PgConnection connection, PgConnection::Open(over_network.NewDatabase()));
  const auto seconds = [&](const std::string& setting) {
    return NumberOf(
        connection,
        fmt::format("SELECT setting::bigint FROM pg_settings WHERE name = '{}'", setting));
  };
  EXPECT_EQ(seconds("tcp_keepalives_idle"), 1);
  EXPECT_EQ(seconds("tcp_keepalives_interval"), 1);
  EXPECT_EQ(seconds("tcp_keepalives_count"), 3);
  EXPECT_EQ(seconds("tcp_user_timeout"), 4'000);
}

}  // namespace
}  // namespace latticed::testing
