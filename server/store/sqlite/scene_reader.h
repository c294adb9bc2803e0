// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reads what is stored, on the caller's thread and a connection of its own, beside the writer.
//
// Errors   kNotFound; kDataLoss naming scene and record, or mesh; else as statement.h
// Threads  safe
#ifndef LATTICED_SERVER_STORE_SQLITE_SCENE_READER_H_
#define LATTICED_SERVER_STORE_SQLITE_SCENE_READER_H_

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "server/store/sqlite/database/connection.h"
#include "server/store/sqlite/scene_rows.h"
#include "server/store/store.h"

namespace latticed {

class SceneReader {
 public:
  // `path` is that of the database.
  SceneReader(std::string path, bool sync) : path_(std::move(path)), sync_(sync) {}
  // Without writing to the file, whether or not a server has it open.
  explicit SceneReader(std::string path) : path_(std::move(path)) {}

  // The scene with its records up to `tail.lsn`.
  [[nodiscard]] absl::StatusOr<SceneLog> Read(std::string_view id, const SceneTail& tail);
  [[nodiscard]] absl::StatusOr<std::vector<StoredEntry>> Scenes();
  [[nodiscard]] absl::StatusOr<std::vector<StoredEntry>> Meshes();
  [[nodiscard]] absl::StatusOr<std::vector<StoredEntry>> Shares();
  [[nodiscard]] absl::StatusOr<std::string> SceneHeader(std::string_view id);
  [[nodiscard]] absl::StatusOr<std::string> MeshHeader(std::string_view id);
  [[nodiscard]] absl::StatusOr<bool> HasMesh(std::string_view id);

 private:
  using Connection = std::unique_ptr<SqliteConnection>;

  // All, or that with `id`.
  [[nodiscard]] absl::StatusOr<std::vector<StoredEntry>> ReadScenes(
      std::optional<std::string_view> id);
  [[nodiscard]] absl::StatusOr<std::vector<StoredEntry>> ReadMeshes(
      std::optional<std::string_view> id);
  // Rows whose sum is of their id and their header.
  [[nodiscard]] absl::StatusOr<std::vector<StoredEntry>> ReadByIdSum(
      const std::string& sql, std::string_view kind, std::optional<std::string_view> id);
  // A connection that nobody uses, or a new one; and gives it back.
  [[nodiscard]] absl::StatusOr<Connection> Take() ABSL_LOCKS_EXCLUDED(mutex_);
  void GiveBack(Connection connection) ABSL_LOCKS_EXCLUDED(mutex_);

  const std::string path_;
  const std::optional<bool> sync_;  // none: it only reads
  Mutex mutex_;
  std::vector<Connection> unused_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_SQLITE_SCENE_READER_H_
