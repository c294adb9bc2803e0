// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Rows and files of meshes whose connection is lost.
#include <future>

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "server/store/files/mesh_folder.h"
#include "server/store/postgres/mesh_rows.h"
#include "server/store/postgres/pool.h"
#include "server/store/postgres/schema.h"
#include "tests/server/store/postgres/postgres_store.h"

namespace latticed::testing {
namespace {

constexpr char kMesh[] = "a hash";
constexpr char kEndHolder[] =
    "SELECT pg_terminate_backend(pid)::int::bigint FROM pg_locks WHERE locktype = 'advisory' "
    "AND database = (SELECT oid FROM pg_database WHERE datname = current_database())";

constexpr char kEndCommits[] =
    "SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity "
    "WHERE wait_event = 'SyncRep' AND datname = current_database()";

class PostgresMeshes : public PostgresStore {
 protected:
  void SetUp() override {
    PostgresStore::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    pool_ = std::make_unique<PgPool>(url_);
    ASSERT_OK(pool_->With(PreparePostgresSchema));
  }
  int64_t Rows() {
    int64_t rows = 0;
    EXPECT_OK(pool_->With([&](PgConnection& connection) {
      rows = NumberOf(connection, "SELECT count(*) FROM latticed.mesh");
      return absl::OkStatus();
    }));
    return rows;
  }

  std::unique_ptr<PgPool> pool_;
};

// Two servers share this folder of meshes. The first one loses its connection, and with it the lock, when its file is there.
class PostgresMeshFiles : public PostgresMeshes {
 protected:
  absl::Status PutAndLoseTheLock(absl::FunctionRef<void()> then) {
    LATTICED_RETURN_IF_ERROR(meshes_.Open({}, absl::ZeroDuration()));
    LATTICED_ASSIGN_OR_RETURN(const std::string written, meshes_.Write(id_, "mesh 1"));
    int published = 0;
    return InsertPostgresMesh(*pool_, id_, "header", [&]() -> absl::Status {
      LATTICED_RETURN_IF_ERROR(meshes_.Publish(written, id_, "mesh 1"));
      if (++published > 1) return absl::OkStatus();
      ExecuteSql(url_, kEndHolder);
      then();
      return absl::OkStatus();
    });
  }

  const std::string id_ = Sha256Hex("mesh 1");
  MeshFolder meshes_{folder_.Path("meshes")};
};

TEST_F(PostgresMeshFiles, AFileThatIsStillThereIsKept) {
  EXPECT_OK(PutAndLoseTheLock([] {}));
  EXPECT_EQ(Rows(), 1);
  EXPECT_OK(meshes_.Read(id_).status());
}

// A row without a file would keep servers from starting.
TEST_F(PostgresMeshFiles, AMeshThatAnotherServerDeletesMeanwhileHasNoRow) {
  const absl::Status put = PutAndLoseTheLock([&] {
    ExecuteSql(url_, "INSERT INTO latticed.mesh VALUES('" + id_ + "', 0, '')");
    PgPool other(url_);
    EXPECT_OK(DeletePostgresMesh(other, id_, [&] { EXPECT_OK(meshes_.Remove(id_)); }));
  });

  EXPECT_THAT(put, StatusIs(absl::StatusCode::kUnavailable));
  EXPECT_EQ(error::DetailsOf(put).reason, "STORE");
  EXPECT_EQ(Rows(), 0);
}

TEST_F(PostgresMeshes, AMeshIsDeletedThoughTheAnswerIsLost) {
  ASSERT_OK(InsertPostgresMesh(*pool_, kMesh, "header", [] { return absl::OkStatus(); }));
  int removed = 0;
  {
    // The row is gone, and its commit waits for a standby when the connection is ended.
    const PostgresSetting no_standby(url_, "synchronous_standby_names", "nobody");
    ASSERT_OK_AND_ASSIGN(PgConnection connection, PgConnection::Open(url_));
    ASSERT_OK(connection.Execute("SET synchronous_commit = local"));
    AwaitRow(connection,
             "SELECT 1::bigint WHERE current_setting('synchronous_standby_names') <> ''");
    for (int64_t ended = 0; ended == 0;) {  // at first commits do not wait yet
      ASSERT_OK(connection.Execute(
          "INSERT INTO latticed.mesh VALUES('a hash', 0, '') ON CONFLICT DO NOTHING"));
      removed = 0;
      auto deleted = std::async(std::launch::async, [&] {
        return DeletePostgresMesh(*pool_, kMesh, [&] { ++removed; });
      });
      while (ended == 0 &&
             deleted.wait_for(std::chrono::milliseconds(1)) == std::future_status::timeout) {
        ended = NumberOf(connection, kEndCommits);
      }
      EXPECT_OK(deleted.get());
    }
  }

  EXPECT_EQ(removed, 1);
  EXPECT_EQ(Rows(), 0);
  EXPECT_THAT(DeletePostgresMesh(*pool_, kMesh, [] {}), StatusIs(absl::StatusCode::kNotFound));
}

}  // namespace
}  // namespace latticed::testing
