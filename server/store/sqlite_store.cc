// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/sqlite_store.h"

#include <sqlite3.h>

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/mutex.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/telemetry.h"
#include "server/store/files/folder_lock.h"
#include "server/store/files/mesh_folder.h"
#include "server/store/objects/mesh_names.h"
#include "server/store/row_sum.h"
#include "server/store/sqlite/database/database.h"
#include "server/store/sqlite/scene_reader.h"
#include "server/store/sqlite/writer.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

class SqliteStore : public Store {
 public:
  SqliteStore(FolderLock lock, std::string folder, std::string database_path, bool sync,
              SqliteConnection database, SqliteConnection checkpoints)
      : lock_(std::move(lock)),
        meshes_(folder + "/meshes"),
        reader_(std::move(database_path), sync),
        writer_(std::move(folder), std::move(database), std::move(checkpoints), &counts_) {}

  absl::Status Start();

  absl::Status CreateScene(std::string_view id, std::string header) override {
    return CreateSceneAt(id, std::move(header), 0, "");
  }
  absl::Status CreateSceneAt(std::string_view id, std::string header, uint64_t lsn,
                             std::string snapshot) override;
  absl::Status DeleteScene(std::string_view id) override;
  absl::StatusOr<std::vector<StoredEntry>> Scenes() override { return reader_.Scenes(); }
  absl::StatusOr<std::string> ReadSceneHeader(std::string_view id) override {
    return reader_.SceneHeader(id);
  }
  absl::StatusOr<SceneLog> ReadScene(std::string_view id) override { return Read(id, true); }
  absl::StatusOr<SceneLog> CopyScene(std::string_view id) override { return Read(id, false); }
  void Append(std::string_view scene, uint64_t lsn, std::string record, Done done) override;
  absl::Status Admit() override { return writer_.queue().Admit(); }
  void PutSnapshot(std::string_view scene, uint64_t lsn, std::string snapshot) override;
  void Flush() override;
  absl::Status PutMesh(std::string_view id, std::string header, std::string_view bytes) override;
  absl::Status DeleteMesh(std::string_view id) override;
  absl::StatusOr<std::vector<StoredEntry>> Meshes() override { return reader_.Meshes(); }
  absl::StatusOr<std::string> ReadMeshHeader(std::string_view id) override {
    return reader_.MeshHeader(id);
  }
  absl::StatusOr<std::string> ReadMesh(std::string_view id) override;
  absl::Status PutShare(std::string_view id, std::string_view scene, std::string header) override;
  absl::Status DeleteShare(std::string_view id) override;
  absl::StatusOr<std::vector<StoredEntry>> Shares() override { return reader_.Shares(); }

 private:
  absl::StatusOr<SceneLog> Read(std::string_view id, bool mend);
  absl::Status InsertMesh(std::string_view id, std::string_view header);

  FolderLock lock_;  // first: it is released last
  MeshFolder meshes_;
  Mutex meshes_mutex_;  // held where files get or lose their names, so that rows and files agree
  SceneReader reader_;
  SqliteWriter writer_;
};

absl::Status SqliteStore::Start() {
  LATTICED_RETURN_IF_ERROR(lock_.MarkUsed());
  LATTICED_RETURN_IF_ERROR(writer_.Start());
  LATTICED_ASSIGN_OR_RETURN(const std::vector<StoredEntry> meshes, reader_.Meshes());
  std::vector<std::string> ids;
  ids.reserve(meshes.size());
  for (const StoredEntry& mesh : meshes) ids.push_back(mesh.id);
  return meshes_.Open(ids, absl::ZeroDuration());
}

absl::Status SqliteStore::CreateSceneAt(std::string_view id, std::string header, uint64_t lsn,
                                        std::string snapshot) {
  return writer_.Change([&](SceneRows& rows) { return rows.Create(id, header, lsn, snapshot); });
}

absl::Status SqliteStore::DeleteScene(std::string_view id) {
  return writer_.Change([&](SceneRows& rows) { return rows.Delete(id); });
}

absl::StatusOr<SceneLog> SqliteStore::Read(std::string_view id, bool mend) {
  SceneTail tail;
  LATTICED_RETURN_IF_ERROR(writer_.Ask([&](SceneRows& rows) -> absl::Status {
    LATTICED_ASSIGN_OR_RETURN(tail, rows.Find(id));
    if (mend) rows.Mend(id);
    return absl::OkStatus();
  }));
  return reader_.Read(id, tail);
}

void SqliteStore::Append(std::string_view scene, uint64_t lsn, std::string record, Done done) {
  writer_.queue().PutAppend(scene, lsn, std::move(record), std::move(done));
}

void SqliteStore::PutSnapshot(std::string_view scene, uint64_t lsn, std::string snapshot) {
  writer_.queue().PutSnapshot(scene, lsn, std::move(snapshot));
}

void SqliteStore::Flush() {
  writer_.Ask([](SceneRows&) { return absl::OkStatus(); }).IgnoreError();  // it is OK
}

absl::Status SqliteStore::PutMesh(std::string_view id, std::string header, std::string_view bytes) {
  if (!IsMeshId(id)) return error::InvalidField("id", "is not a SHA-256 in hex");
  LATTICED_ASSIGN_OR_RETURN(const bool known, reader_.HasMesh(id));
  if (known && ReadMesh(id).ok()) return absl::OkStatus();  // else it is damaged, and written anew
  LATTICED_RETURN_IF_ERROR(writer_.queue().Admit());
  LATTICED_ASSIGN_OR_RETURN(const std::string written, meshes_.Write(id, bytes));
  MutexLock lock(&meshes_mutex_);
  absl::Status status = meshes_.Publish(written, id, bytes);
  if (!status.ok()) {
    meshes_.Discard(written);
    return status;
  }
  // If this fails, the file stays, as after a crash: the next PutMesh or the next start sees to it.
  return InsertMesh(id, header);
}

absl::Status SqliteStore::InsertMesh(std::string_view id, std::string_view header) {
  return writer_.Change([&](SceneRows&) -> absl::Status {
    LATTICED_ASSIGN_OR_RETURN(
        SqliteStatement row,
        writer_.database().Prepare("INSERT OR REPLACE INTO mesh(id, sum, header) VALUES(?, ?, ?)"));
    row.BindBytes(1, id);
    row.Bind(2, IdRowSum(id, header));
    row.BindBytes(3, header);
    return row.Run();
  });
}

absl::Status SqliteStore::DeleteMesh(std::string_view id) {
  MutexLock lock(&meshes_mutex_);
  LATTICED_RETURN_IF_ERROR(writer_.Change([&](SceneRows&) -> absl::Status {
    LATTICED_ASSIGN_OR_RETURN(SqliteStatement row,
                              writer_.database().Prepare("DELETE FROM mesh WHERE id = ?"));
    row.BindBytes(1, id);
    LATTICED_RETURN_IF_ERROR(row.Run());
    if (sqlite3_changes(writer_.database().get()) == 0) return error::NotFound("mesh", id);
    return absl::OkStatus();
  }));
  // The mesh is gone already. A file that stays is removed at the next start.
  if (const absl::Status status = meshes_.Remove(id); !status.ok()) {
    LogEvent(spdlog::level::warn, "file of a deleted mesh not removed",
             {{"error", std::string(status.message())}});
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> SqliteStore::ReadMesh(std::string_view id) {
  LATTICED_ASSIGN_OR_RETURN(const bool known, reader_.HasMesh(id));
  if (!known) return error::NotFound("mesh", id);
  return meshes_.Read(id);
}

absl::Status SqliteStore::PutShare(std::string_view id, std::string_view scene,
                                   std::string header) {
  return writer_.Change([&](SceneRows& rows) -> absl::Status {
    LATTICED_ASSIGN_OR_RETURN(const SceneTail tail, rows.Find(scene));
    LATTICED_ASSIGN_OR_RETURN(
        SqliteStatement row,
        writer_.database().Prepare(
            "INSERT OR REPLACE INTO share(id, scene, sum, header) VALUES(?, ?, ?, ?)"));
    row.BindBytes(1, id);
    row.Bind(2, tail.number);
    row.Bind(3, IdRowSum(id, header));
    row.BindBytes(4, header);
    return row.Run();
  });
}

absl::Status SqliteStore::DeleteShare(std::string_view id) {
  return writer_.Change([&](SceneRows&) -> absl::Status {
    LATTICED_ASSIGN_OR_RETURN(SqliteStatement row,
                              writer_.database().Prepare("DELETE FROM share WHERE id = ?"));
    row.BindBytes(1, id);
    return row.Run();
  });
}

absl::Status CheckNotLost(const FolderLock& lock, const std::string& path) {
  std::error_code failure;
  const bool empty = std::filesystem::file_size(path, failure) == 0 || failure;
  if (lock.used() && empty) return error::Damaged(path, "it is missing or empty");
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<Store>> OpenSqliteStore(const SqliteStoreOptions& options) {
  const bool sync = options.durability == Durability::kFull;
  const std::string path = options.folder + "/latticed.sqlite";
  LATTICED_ASSIGN_OR_RETURN(FolderLock lock, FolderLock::Take(options.folder));
  LATTICED_RETURN_IF_ERROR(CheckNotLost(lock, path));
  LATTICED_ASSIGN_OR_RETURN(SqliteConnection database, OpenDatabase(path, sync));
  LATTICED_ASSIGN_OR_RETURN(SqliteConnection checkpoints, SqliteConnection::Open(path, sync));
  auto store = std::make_unique<SqliteStore>(std::move(lock), options.folder, path, sync,
                                             std::move(database), std::move(checkpoints));
  LATTICED_RETURN_IF_ERROR(store->Start());
  return store;
}

}  // namespace latticed
