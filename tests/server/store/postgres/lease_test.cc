// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The lease of a server with PostgreSQL, and claims that depend on it.
#include <future>

#include "server/store/postgres/lease.h"
#include "server/store/postgres/pool.h"
#include "server/store/postgres/schema.h"
#include "tests/server/store/postgres/postgres_store.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

class PostgresLease : public PostgresStore {
 protected:
  void PrepareSchema() {
    PgPool pool(url_);
    ASSERT_OK(pool.With(PreparePostgresSchema));
  }
};

TEST_F(PostgresLease, TwoServersWithOneNameAreNamed) {
  ASSERT_OK_AND_ASSIGN(const auto first, Open(url_));
  ASSERT_OK(first->CreateScene("gear", ""));
  ExecuteSql(url_, "UPDATE latticed.session SET lease = '1 hour'");
  ASSERT_OK_AND_ASSIGN(const auto second, Open(url_, absl::Milliseconds(200)));

  EXPECT_THAT(second->ClaimScene("gear").status(),
              StatusIs(absl::StatusCode::kUnavailable,
                       HasSubstr("another server advertises the name 'host-1:50051' too")));
}

TEST_F(PostgresLease, ASessionsNumberIsNotUsedAgainAfterACrash) {
  ASSERT_NO_FATAL_FAILURE(PrepareSchema());
  int64_t before = 0;
  {
    PgLease lease(url_, "a", absl::Seconds(10));
    ASSERT_OK(lease.Start());
    before = lease.session();
    PostgresServer::Shared().Crash();
  }
  PostgresServer::Shared().Start();

  PgLease lease(url_, "b", absl::Seconds(10));
  ASSERT_OK(lease.Start());
  EXPECT_GT(lease.session(), before);
}

TEST_F(PostgresLease, SeveralServersClaimWhatOneHasLeft) {
  ASSERT_OK_AND_ASSIGN(const auto store, Open(url_));
  ASSERT_OK(store->CreateScene("gear", ""));
  ExecuteSql(url_,
             "INSERT INTO latticed.session(name, lease, expires) VALUES('gone', '1 us', now()); "
             "UPDATE latticed.scene SET session = (SELECT session FROM latticed.session "
             "WHERE name = 'gone')");
  // Another one fences it, for another scene, while the claim waits.
  ASSERT_OK_AND_ASSIGN(PgConnection other, PgConnection::Open(url_));
  ASSERT_OK(other.Execute("BEGIN; UPDATE latticed.session SET fenced = true WHERE name = 'gone'"));
  auto claim = std::async(std::launch::async, [&] { return store->ClaimScene("gear"); });
  AwaitRow(other,
           "SELECT pid::bigint FROM pg_stat_activity WHERE wait_event_type = 'Lock' "
           "AND datname = current_database()");
  ASSERT_OK(other.Execute("COMMIT"));

  ASSERT_OK_AND_ASSIGN(const SceneClaim claimed, claim.get());
  EXPECT_EQ(claimed.owner, "");
  EXPECT_OK(store->ReadScene("gear").status());
}

// As a claim does: the append of a connection that was lost would else come after the next owner's.
TEST_F(PostgresLease, TheEndOfASessionWaitsForAnAppendUnderWay) {
  ASSERT_NO_FATAL_FAILURE(PrepareSchema());
  auto lease = std::make_unique<PgLease>(url_, "a", absl::Seconds(10));
  ASSERT_OK(lease->Start());
  ASSERT_OK_AND_ASSIGN(PgConnection append, PgConnection::Open(url_));
  ASSERT_OK(append.Execute("BEGIN; SELECT FROM latticed.session FOR KEY SHARE"));

  auto ended = std::async(std::launch::async, [&] { lease.reset(); });
  EXPECT_EQ(ended.wait_for(std::chrono::milliseconds(300)), std::future_status::timeout);
  EXPECT_EQ(NumberOf(append, "SELECT fenced::int::bigint FROM latticed.session"), 0);
  ASSERT_OK(append.Execute("COMMIT"));
  ended.get();
  EXPECT_EQ(NumberOf(append, "SELECT fenced::int::bigint FROM latticed.session"), 1);
}

}  // namespace
}  // namespace latticed::testing
