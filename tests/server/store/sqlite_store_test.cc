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
#include "server/store/sqlite/database/database.h"
#include "tests/server/store/fault_vfs.h"
#include "tests/server/store/opened_store.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class SqliteStoreTest : public ::testing::Test {
 protected:
  std::string Data(const std::string& name = "") {
    return store_.folder().Path("data") + "/" + name;
  }
  absl::Status Open() { return OpenSqliteStore({.folder = store_.folder().Path("data")}).status(); }
  // Executes SQL on the database, which no store has open, as another program does, or (with the VFS of
  // checked_vfs.h) so that pages get their checksums. Returns the first column of the last row.
  std::string Sql(const std::string& sql, const char* vfs = nullptr) {
    sqlite3* database = nullptr;
    EXPECT_EQ(sqlite3_open_v2(Data("latticed.sqlite").c_str(), &database,
                              SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, vfs),
              SQLITE_OK);
    std::string answer;
    const auto keep = [](void* to, int, char** values, char**) {
      *static_cast<std::string*>(to) = values[0];
      return 0;
    };
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), keep, &answer, nullptr), SQLITE_OK)
        << sqlite3_errmsg(database);
    sqlite3_close(database);
    return answer;
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
                       HasSubstr("latticed.sqlite has schema 7, and this latticed knows up to 2")));
}

TEST_F(SqliteStoreTest, UpgradesTheFirstSchema) {
  ASSERT_OK(store_->CreateScene("gear", "header"));
  ASSERT_OK(store_.Append("gear", 1, "x"));
  store_.Close();
  Sql("DROP TABLE share; PRAGMA user_version = 1", "latticed-checked");
  EXPECT_THAT(OpenDatabaseToRead(Data("latticed.sqlite")).status(),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("upgrades it to 2")));

  ASSERT_OK(Open());
  store_.Open();
  ASSERT_OK_AND_ASSIGN(const SceneLog log, store_->ReadScene("gear"));
  EXPECT_EQ(log.records, std::vector<std::string>{"x"});
  EXPECT_OK(store_->PutShare("a", "gear", "header"));
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

TEST_F(SqliteStoreTest, TellsClientsNoPaths) {
  const std::string id = Sha256Hex("mesh 1");
  ASSERT_OK(store_->PutMesh(id, "", "mesh 1"));
  std::filesystem::remove(Data("meshes/" + id));
  EXPECT_THAT(store_->ReadMesh(id),
              StatusIs(absl::StatusCode::kDataLoss, AllOf(HasSubstr(id), Not(HasSubstr("/")))));

  std::filesystem::remove(Data("meshes"));
  EXPECT_THAT(store_->PutMesh(id, "", "mesh 1"),
              StatusIs(absl::StatusCode::kUnavailable,
                       AllOf(HasSubstr("No such file"), Not(HasSubstr("/")))));
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
  const std::string hash = Sha256Hex("x");
  for (const std::string& id : {std::string("../lock"), "../" + hash, "/" + hash, "a/b/" + hash,
                                "Acme/" + hash, "new.x/" + hash, hash + "/acme"}) {
    EXPECT_THAT(store_->PutMesh(id, "", "x"), StatusIs(absl::StatusCode::kInvalidArgument)) << id;
  }
}

TEST_F(SqliteStoreTest, KeepsTheMeshesOfTenantsApart) {
  const std::string hash = Sha256Hex("mesh 1"), acme = "acme/" + hash, other = "new-1/" + hash;
  for (const std::string& id : {hash, acme, other}) ASSERT_OK(store_->PutMesh(id, "", "mesh 1"));
  store_.folder().Write("data/meshes/" + hash + ".acme", "mesh 0");
  store_.folder().Write("data/meshes/" + hash + ".unknown", "mesh 1");

  store_.Reopen();
  EXPECT_FALSE(std::filesystem::exists(Data("meshes/" + hash + ".unknown")));
  EXPECT_THAT(store_->ReadMesh(acme), StatusIs(absl::StatusCode::kDataLoss, HasSubstr(acme)));
  ASSERT_OK(store_->DeleteMesh(acme));
  EXPECT_THAT(store_->ReadMesh(acme), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_EQ(store_->ReadMesh(other).value_or(""), "mesh 1");
  EXPECT_EQ(store_->ReadMesh(hash).value_or(""), "mesh 1");
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

TEST_F(SqliteStoreTest, NamesTheRecordThatIsDamaged) {
  for (const std::string id : {"gear", "knot"}) {
    ASSERT_OK(store_->CreateScene(id, "header"));
    for (uint64_t lsn = 1; lsn <= 3; ++lsn) ASSERT_OK(store_.Append(id, lsn, "a record"));
  }
  store_.Close();
  Sql("UPDATE record SET bytes = x'00' WHERE scene = 1 AND lsn = 2", "latticed-checked");
  store_.Open();

  EXPECT_THAT(
      store_->ReadScene("gear"),
      StatusIs(absl::StatusCode::kDataLoss,
               "scene 'gear': record 2 is damaged: its bytes are not those that were written"));
  EXPECT_OK(store_->ReadScene("knot"));
}

TEST_F(SqliteStoreTest, NamesTheRecordThatIsMissing) {
  ASSERT_OK(store_->CreateScene("gear", "header"));
  for (uint64_t lsn = 1; lsn <= 3; ++lsn) ASSERT_OK(store_.Append("gear", lsn, "a record"));
  store_.Close();
  Sql("UPDATE log SET saved_row = 3; UPDATE scene SET saved_lsn = 3, saved_row = 3;"
      "DELETE FROM record WHERE lsn = 1",
      "latticed-checked");
  store_.Open();

  EXPECT_THAT(
      store_->ReadScene("gear"),
      StatusIs(absl::StatusCode::kDataLoss, "scene 'gear': record 1 is damaged: it is missing"));
}

TEST_F(SqliteStoreTest, RefusesADatabaseWhoseLastRecordsContradictEachOther) {
  ASSERT_OK(store_->CreateScene("gear", "header"));
  for (uint64_t lsn = 1; lsn <= 3; ++lsn) ASSERT_OK(store_.Append("gear", lsn, "a record"));
  store_.Close();

  Sql("DELETE FROM record WHERE lsn = 2", "latticed-checked");
  EXPECT_THAT(Open(), StatusIs(absl::StatusCode::kDataLoss,
                               HasSubstr("rows 2 to 2 of records are missing")));
  Sql("UPDATE record SET row = 2 WHERE lsn = 3", "latticed-checked");
  EXPECT_THAT(Open(), StatusIs(absl::StatusCode::kDataLoss,
                               "scene 'gear' is damaged: record 3 follows record 1"));
}

TEST_F(SqliteStoreTest, NamesTheHeaderThatIsDamagedAndListsTheOthers) {
  for (const std::string id : {"gear", "knot"}) ASSERT_OK(store_->CreateScene(id, "header " + id));
  store_.Close();
  Sql("UPDATE scene_header SET bytes = x'00' WHERE scene = 1", "latticed-checked");
  store_.Open();

  ASSERT_OK_AND_ASSIGN(const auto scenes, store_->Scenes());
  ASSERT_EQ(scenes.size(), 2U);
  EXPECT_THAT(scenes[0].damage, StatusIs(absl::StatusCode::kDataLoss, HasSubstr("'gear'")));
  EXPECT_EQ(scenes[0].header, "");
  EXPECT_OK(scenes[1].damage);
  EXPECT_EQ(scenes[1].header, "header knot");
}

TEST_F(SqliteStoreTest, OtherProgramsCanReadIt) {
  ASSERT_OK(store_->CreateScene("gear", "header"));
  for (uint64_t lsn = 1; lsn <= 1'000; ++lsn) store_->Append("gear", lsn, "a record", nullptr);
  store_.Close();

  EXPECT_EQ(Sql("PRAGMA integrity_check"), "ok");
  EXPECT_EQ(Sql("SELECT count(*) FROM record"), "1000");
}

// Whether writing or waiting for the medium fails: nothing that was refused is found later.
class SqliteStoreFault : public SqliteStoreTest, public ::testing::WithParamInterface<DiskFault> {};

TEST_P(SqliteStoreFault, ACommitThatFailedIsNotTriedAgain) {
  ASSERT_OK(store_->CreateScene("gear", "header"));
  ASSERT_OK(store_.Append("gear", 1, "gear 1"));
  SetDiskFault(GetParam());

  EXPECT_THAT(store_.Append("gear", 2, "refused"), StatusIs(absl::StatusCode::kUnavailable));
  EXPECT_THAT(store_->Admit(), StatusIs(absl::StatusCode::kUnavailable));
  ASSERT_OK_AND_ASSIGN(const SceneLog log, store_->ReadScene("gear"));
  EXPECT_THAT(log.records, ElementsAre("gear 1"));
  SetDiskFault(DiskFault::kNone);
  ASSERT_TRUE(store_.AdmitsAgain());
  store_.Reopen();

  ASSERT_OK_AND_ASSIGN(const SceneLog after, store_->ReadScene("gear"));
  EXPECT_THAT(after.records, ElementsAre("gear 1"));
  EXPECT_OK(store_.Append("gear", 2, "gear 2"));
}

INSTANTIATE_TEST_SUITE_P(Faults, SqliteStoreFault,
                         ::testing::Values(DiskFault::kWriteFails, DiskFault::kSyncFails));

}  // namespace
}  // namespace latticed::testing
