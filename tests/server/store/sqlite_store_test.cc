// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What only a store in a folder has: its files, and who uses them.
#include "server/store/sqlite_store.h"

#include <filesystem>
#include <memory>
#include <string>

#include <sqlite3.h>

#include "core/base/sha256.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/server/store/opened_store.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class SqliteStoreTest : public ::testing::Test {
 protected:
  std::string Data(const std::string& name = "") {
    return store_.folder().Path("data") + "/" + name;
  }
  absl::Status Open() { return OpenSqliteStore({.folder = store_.folder().Path("data")}).status(); }
  // Executes SQL on the database, which no store has open. Its pages get no checksums.
  void Sql(const std::string& sql) {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(Data("latticed.sqlite").c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(database);
    sqlite3_close(database);
  }

  OpenedStore store_{"sqlite"};
};

TEST_F(SqliteStoreTest, RefusesAFolderThatAnotherStoreUses) {
  EXPECT_THAT(Open(), StatusIs(absl::StatusCode::kFailedPrecondition,
                               HasSubstr("data is in use by another server")));

  store_.Close();
  EXPECT_OK(Open());
}

TEST_F(SqliteStoreTest, RefusesADatabaseOfAnotherProgram) {
  store_.Close();
  std::filesystem::remove(Data("latticed.sqlite"));
  Sql("CREATE TABLE theirs(a); INSERT INTO theirs VALUES(1)");

  EXPECT_THAT(Open(), StatusIs(absl::StatusCode::kFailedPrecondition,
                               HasSubstr("latticed.sqlite is not a database of latticed")));
  EXPECT_FALSE(std::filesystem::exists(Data("latticed.sqlite-wal")));
}

TEST_F(SqliteStoreTest, RefusesAFileThatIsNoDatabase) {
  store_.Close();
  store_.folder().Write("data/latticed.sqlite", "a text");

  EXPECT_THAT(Open(), StatusIs(absl::StatusCode::kFailedPrecondition,
                               HasSubstr("latticed.sqlite is not a database of latticed")));
}

TEST_F(SqliteStoreTest, RefusesANewerSchema) {
  store_.Close();
  Sql("PRAGMA user_version = 7");

  EXPECT_THAT(Open(),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("latticed.sqlite has schema 7, and this latticed knows up to 1")));
}

TEST_F(SqliteStoreTest, RefusesAFolderWhoseDatabaseIsGone) {
  store_.Close();
  std::filesystem::remove(Data("latticed.sqlite"));

  EXPECT_THAT(Open(), StatusIs(absl::StatusCode::kDataLoss, HasSubstr("missing or empty")));
}

TEST_F(SqliteStoreTest, NamesAFolderThatCannotBeMade) {
  store_.folder().Write("file", "");

  EXPECT_THAT(OpenSqliteStore({.folder = store_.folder().Path("file/data")}).status(),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("file/data")));
}

TEST_F(SqliteStoreTest, FindsAMeshWithAFlippedBitAndGoesOn) {
  const std::string damaged = Sha256Hex("mesh 1");
  const std::string sound = Sha256Hex("mesh 2");
  ASSERT_OK(store_->PutMesh(damaged, "", "mesh 1"));
  ASSERT_OK(store_->PutMesh(sound, "", "mesh 2"));
  store_.folder().Write("data/meshes/" + damaged, "mesh 0");

  EXPECT_THAT(store_->ReadMesh(damaged), StatusIs(absl::StatusCode::kDataLoss, HasSubstr(damaged)));
  EXPECT_OK(store_->ReadMesh(sound));
  store_.Reopen();
  EXPECT_THAT(store_->ReadMesh(damaged), StatusIs(absl::StatusCode::kDataLoss, HasSubstr(damaged)));
}

TEST_F(SqliteStoreTest, RefusesToStartWithoutAMesh) {
  const std::string id = Sha256Hex("mesh 1");
  ASSERT_OK(store_->PutMesh(id, "", "mesh 1"));
  store_.Close();
  std::filesystem::remove(Data("meshes/" + id));

  EXPECT_THAT(Open(), StatusIs(absl::StatusCode::kDataLoss, HasSubstr(id)));
}

TEST_F(SqliteStoreTest, RemovesMeshFilesThatACrashLeftAndNoOthers) {
  const std::string known = Sha256Hex("known");
  ASSERT_OK(store_->PutMesh(known, "", "known"));
  store_.Close();
  const std::string unknown = Sha256Hex("unknown");
  for (const std::string& name : {unknown, std::string("new-3"), std::string("notes.txt")}) {
    store_.folder().Write("data/meshes/" + name, "x");
  }

  store_.Open();

  EXPECT_FALSE(std::filesystem::exists(Data("meshes/" + unknown)));
  EXPECT_FALSE(std::filesystem::exists(Data("meshes/new-3")));
  EXPECT_TRUE(std::filesystem::exists(Data("meshes/notes.txt")));
  EXPECT_OK(store_->ReadMesh(known));
}

TEST_F(SqliteStoreTest, RefusesAMeshIdThatIsAPath) {
  EXPECT_THAT(store_->PutMesh("../lock", "", "x"), StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST_F(SqliteStoreTest, ReusesTheRoomOfRecordsThatSnapshotsCover) {
  ASSERT_OK(store_->CreateScene("gear", ""));
  ASSERT_OK(store_->CreateScene("quiet", ""));
  ASSERT_OK(store_.Append("quiet", 1, "quiet 1"));
  const std::string record(100, 'x');
  uint64_t lsn = 0;
  for (int round = 0; round < 20; ++round) {
    for (int i = 0; i < 20'000; ++i) store_->Append("gear", ++lsn, record, nullptr);
    store_->PutSnapshot("gear", lsn, "state");
    store_->Flush();
  }
  ASSERT_OK_AND_ASSIGN(const SceneLog gear, store_->ReadScene("gear"));
  EXPECT_EQ(gear.lsn(), 400'000U);
  store_.Reopen();

  // All records are 48 MB.
  EXPECT_LT(std::filesystem::file_size(Data("latticed.sqlite")), 24'000'000U);
  ASSERT_OK(store_.Append("gear", 400'001, "gear"));
  ASSERT_OK_AND_ASSIGN(const SceneLog quiet, store_->ReadScene("quiet"));
  EXPECT_THAT(quiet.records, ElementsAre("quiet 1"));
}

}  // namespace
}  // namespace latticed::testing
