// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Statements of the store in PostgreSQL whose answers are lost, and records that it refuses.
#include <future>
#include <string>
#include <utility>
#include <vector>

#include "absl/synchronization/notification.h"
#include "tests/server/store/postgres/postgres_store.h"

namespace latticed::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Ends the connections that wait for a lock of the table of records.
constexpr char kEndWaiting[] =
    "SELECT pg_terminate_backend(pid)::int::bigint FROM pg_locks "
    "WHERE relation = 'latticed.record'::regclass AND NOT granted";

class PostgresAnswers : public PostgresStore {
 protected:
  void SetUp() override {
    PostgresStore::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    ASSERT_OK_AND_ASSIGN(store_, Open(url_));
    ASSERT_OK(store_->CreateScene("gear", ""));
    ASSERT_OK_AND_ASSIGN(PgConnection connection, PgConnection::Open(url_));
    connection_ = std::make_unique<PgConnection>(std::move(connection));
  }
  // An append is under way when its connection is ended. In between, executes `sql`, which may lock more.
  absl::Status LoseAnAppend(const char* sql) {
    EXPECT_OK(connection_->Execute("BEGIN; LOCK TABLE latticed.record IN EXCLUSIVE MODE"));
    EXPECT_OK(connection_->Execute(sql));
    auto append = std::async(std::launch::async, [&] { return AppendTo(*store_, "gear", 1, "x"); });
    AwaitRow(*connection_, kEndWaiting);
    return append.get();
  }

  std::unique_ptr<Store> store_;
  std::unique_ptr<PgConnection> connection_;
};

TEST_F(PostgresAnswers, AnAppendWhoseAnswerIsLostIsAborted) {
  // The next connection waits for a lock.
  EXPECT_THAT(LoseAnAppend("LOCK TABLE latticed.session IN SHARE MODE"),
              StatusIs(absl::StatusCode::kAborted, HasSubstr("does not know")));
  EXPECT_THAT(store_->Admit(), StatusIs(absl::StatusCode::kUnavailable));

  ASSERT_OK(connection_->Execute("ROLLBACK"));
  ASSERT_OK_AND_ASSIGN(const SceneLog log, store_->ReadScene("gear"));
  EXPECT_EQ(log.lsn(), 0U);
  EXPECT_OK(AppendTo(*store_, "gear", 1, "x"));
}

// The lost connection's statement may still come to its end: only a connection that is attached has waited for it.
TEST_F(PostgresAnswers, WhatIsStoredIsNotToldWhileAnAppendIsInDoubt) {
  ASSERT_OK(
      connection_->Execute(fmt::format("ALTER DATABASE {} SET default_transaction_read_only = on",
                                       url_.substr(url_.rfind('=') + 1))
                               .c_str()));
  EXPECT_THAT(LoseAnAppend("SELECT"),
              StatusIs(absl::StatusCode::kAborted, HasSubstr("does not know")));
  ASSERT_OK(connection_->Execute("ROLLBACK"));

  EXPECT_THAT(store_->ReadScene("gear").status(),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("read-only")));

  ASSERT_OK(
      connection_->Execute(fmt::format("ALTER DATABASE {} RESET default_transaction_read_only",
                                       url_.substr(url_.rfind('=') + 1))
                               .c_str()));
  // The writer's connection was opened before.
  AwaitRow(*connection_,
           "SELECT pg_terminate_backend(pid)::int::bigint FROM pg_stat_activity "
           "WHERE datname = current_database() AND query LIKE '%attach(%' AND pid <> "
           "pg_backend_pid()");
  const absl::Time end = absl::Now() + absl::Minutes(1);
  while (!store_->Admit().ok() && absl::Now() < end) absl::SleepFor(absl::Milliseconds(1));
  EXPECT_OK(store_->ReadScene("gear").status());
  EXPECT_OK(AppendTo(*store_, "gear", 1, "x"));
}

TEST_F(PostgresAnswers, ASnapshotWithARefusedRecordIsNotStored) {
  ASSERT_OK(AppendTo(*store_, "gear", 1, "one"));
  ASSERT_OK(
      connection_->Execute("CREATE FUNCTION refuse() RETURNS trigger LANGUAGE plpgsql AS "
                           "$$ BEGIN RAISE EXCEPTION 'no room' USING ERRCODE = '53100'; END $$; "
                           "CREATE TRIGGER refuse BEFORE INSERT ON latticed.record FOR EACH ROW "
                           "WHEN (NEW.bytes = 'two'::bytea) EXECUTE FUNCTION refuse()"));

  // The snapshot is put after the record was refused, and before the scene is read again.
  std::promise<absl::Status> answer;
  store_->Append("gear", 2, "two", [&](const absl::Status& status) {
    store_->PutSnapshot("gear", 2, "one, two");
    answer.set_value(status);
  });
  EXPECT_THAT(answer.get_future().get(), StatusIs(absl::StatusCode::kResourceExhausted));
  store_->Flush();

  ASSERT_OK_AND_ASSIGN(const SceneLog log, store_->ReadScene("gear"));
  EXPECT_EQ(log.snapshot_lsn, 0U);
  EXPECT_THAT(log.records, ElementsAre("one"));
  EXPECT_OK(AppendTo(*store_, "gear", 2, "another"));
}

TEST_F(PostgresAnswers, OfAGroupThatIsStoredInPartTheRestIsRefused) {
  ASSERT_OK(store_->CreateScene("knot", ""));
  ASSERT_OK(connection_->Execute(
      "INSERT INTO latticed.record SELECT number, 2, 0, '' FROM latticed.scene WHERE id = 'gear'"));
  // One statement takes all that waits for the lock.
  ASSERT_OK(connection_->Execute("BEGIN; LOCK TABLE latticed.record IN EXCLUSIVE MODE"));
  std::vector<std::future<absl::Status>> answers;
  const auto append = [&](const std::string& scene, uint64_t lsn) {
    const auto answer = std::make_shared<std::promise<absl::Status>>();
    answers.push_back(answer->get_future());
    store_->Append(scene, lsn, "x", [answer](const absl::Status& s) { answer->set_value(s); });
  };
  append("gear", 1);
  AwaitRow(*connection_,
           "SELECT pid::bigint FROM pg_locks WHERE relation = 'latticed.record'::regclass AND NOT "
           "granted");
  append("gear", 2);
  append("knot", 1);
  ASSERT_OK(connection_->Execute("COMMIT"));

  EXPECT_OK(answers[0].get());
  EXPECT_THAT(answers[1].get(), StatusIs(absl::StatusCode::kAborted));
  EXPECT_OK(answers[2].get());
}

}  // namespace
}  // namespace latticed::testing
