// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Shares in PostgreSQL, where several servers make and revoke them at a time.
#include "server/store/store.h"
#include "tests/server/store/postgres/postgres_store.h"

namespace latticed::testing {
namespace {

class PostgresShares : public PostgresStore {};

TEST_F(PostgresShares, AShareThatAppearsLateIsNoticedThoughAnotherIsGone) {
  ASSERT_OK_AND_ASSIGN(const auto store, Open(url_));
  ASSERT_OK(store->CreateScene("gear", ""));
  ASSERT_OK(store->PutShare("first", "gear", ""));
  ASSERT_OK_AND_ASSIGN(PgConnection other, PgConnection::Open(url_));
  ASSERT_OK(
      other.Execute("BEGIN; INSERT INTO latticed.share(id, scene, sum, header) "
                    "SELECT 'late', number, 0, '' FROM latticed.scene"));
  ASSERT_OK(store->PutShare("last", "gear", ""));
  ASSERT_OK_AND_ASSIGN(const std::string mark, store->SharesMark());

  ASSERT_OK(store->DeleteShare("first"));
  ASSERT_OK(other.Execute("COMMIT"));
  EXPECT_NE(*store->SharesMark(), mark);
}

}  // namespace
}  // namespace latticed::testing
