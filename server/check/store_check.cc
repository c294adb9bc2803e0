// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/check/store_check.h"

#include <filesystem>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/engine/scene/scene_replay.h"
#include "server/store/files/mesh_folder.h"
#include "server/store/objects/mesh_names.h"
#include "server/store/sqlite/database/database.h"
#include "server/store/sqlite/scene_reader.h"
#include "server/store/sqlite/scene_rows.h"
#include "server/wire/stored_mesh.h"
#include "server/wire/stored_scene.h"

namespace latticed {
namespace {

class StoreCheck {
 public:
  explicit StoreCheck(const std::string& folder)
      : path_(folder + "/latticed.sqlite"),
        meshes_path_(folder + "/meshes"),
        reader_(path_),
        meshes_(meshes_path_) {}

  absl::StatusOr<StoreFindings> Run();

 private:
  // Scenes before meshes: a mesh is stored before the scenes that are made from it.
  absl::Status CheckScenes();
  absl::Status CheckScene(const StoredEntry& entry, const SceneRows& rows);
  absl::Status CheckShares();
  absl::Status CheckMeshes();
  absl::Status CheckMesh(const StoredEntry& entry);
  void CountUnknownFiles(const std::set<std::string>& names);
  // Damage becomes a finding; what was deleted meanwhile is none. Other errors are returned.
  absl::Status Note(const absl::Status& status, std::string_view where = "");

  const std::string path_;
  const std::string meshes_path_;
  SceneReader reader_;
  const MeshFolder meshes_;
  std::map<std::string, std::string> mesh_of_;  // by scene
  StoreFindings findings_;
};

absl::Status StoreCheck::Note(const absl::Status& status, std::string_view where) {
  if (absl::IsNotFound(status)) return absl::OkStatus();
  if (!absl::IsDataLoss(status)) return status;
  findings_.damage.push_back(fmt::format("{}{}", where, std::string(status.message())));
  return absl::OkStatus();
}

absl::Status StoreCheck::CheckScenes() {
  LATTICED_ASSIGN_OR_RETURN(SqliteConnection database, OpenDatabaseToRead(path_));
  LATTICED_RETURN_IF_ERROR(database.Execute("BEGIN"));  // one state of all tails
  LATTICED_ASSIGN_OR_RETURN(const SceneRows rows, SceneRows::Create(&database));
  LATTICED_RETURN_IF_ERROR(database.Execute("ROLLBACK"));
  LATTICED_ASSIGN_OR_RETURN(const std::vector<StoredEntry> scenes, reader_.Scenes());
  for (const StoredEntry& scene : scenes) {
    ++findings_.scenes;
    LATTICED_RETURN_IF_ERROR(Note(CheckScene(scene, rows)));
  }
  return absl::OkStatus();
}

absl::Status StoreCheck::CheckScene(const StoredEntry& entry, const SceneRows& rows) {
  LATTICED_RETURN_IF_ERROR(entry.damage);
  const std::string name = fmt::format("scene '{}': ", entry.id);
  const auto scene = StoredSceneOf(entry.header);
  if (!scene.ok()) return Note(scene.status(), name);
  mesh_of_[entry.id] = scene->mesh_id;
  LATTICED_ASSIGN_OR_RETURN(const SceneTail tail, rows.Find(entry.id));
  LATTICED_ASSIGN_OR_RETURN(const SceneLog log, reader_.Read(entry.id, tail));
  findings_.snapshots += log.snapshot_lsn > 0 ? 1 : 0;
  findings_.records += log.records.size();
  return Note(Replay(log).status(), name);
}

absl::Status StoreCheck::CheckShares() {
  LATTICED_ASSIGN_OR_RETURN(const std::vector<StoredEntry> shares, reader_.Shares());
  for (const StoredEntry& share : shares) LATTICED_RETURN_IF_ERROR(Note(share.damage));
  return absl::OkStatus();
}

absl::Status StoreCheck::CheckMeshes() {
  LATTICED_ASSIGN_OR_RETURN(const std::vector<StoredEntry> meshes, reader_.Meshes());
  std::set<std::string> known, names;
  for (const StoredEntry& mesh : meshes) {
    ++findings_.meshes;
    known.insert(mesh.id);
    names.insert(MeshName(mesh.id));
    LATTICED_RETURN_IF_ERROR(Note(CheckMesh(mesh)));
  }
  for (const auto& [scene, mesh] : mesh_of_) {
    if (known.contains(mesh)) continue;
    if (absl::IsNotFound(reader_.SceneHeader(scene).status())) continue;  // both were deleted
    findings_.damage.push_back(fmt::format("scene '{}': its mesh {} is missing", scene, mesh));
  }
  CountUnknownFiles(names);
  return absl::OkStatus();
}

absl::Status StoreCheck::CheckMesh(const StoredEntry& entry) {
  LATTICED_RETURN_IF_ERROR(Note(entry.damage));
  if (entry.damage.ok()) {
    LATTICED_RETURN_IF_ERROR(Note(ListedFromStored(entry.header).status(),
                                  fmt::format("mesh {}: its header: ", entry.id)));
  }
  const absl::StatusOr<std::string> bytes = meshes_.Read(entry.id);
  if (bytes.ok()) {
    findings_.mesh_bytes += bytes->size();
    return absl::OkStatus();
  }
  LATTICED_ASSIGN_OR_RETURN(const bool still_there, reader_.HasMesh(entry.id));
  return still_there ? bytes.status() : absl::OkStatus();
}

void StoreCheck::CountUnknownFiles(const std::set<std::string>& names) {
  std::error_code failure;  // without the folder, each mesh is missing
  for (const auto& file : std::filesystem::directory_iterator(meshes_path_, failure)) {
    if (!names.contains(file.path().filename().string())) ++findings_.unknown_files;
  }
}

absl::StatusOr<StoreFindings> StoreCheck::Run() {
  LATTICED_RETURN_IF_ERROR(Note(OpenDatabaseToRead(path_).status()));
  if (!findings_.damage.empty()) return std::move(findings_);
  LATTICED_RETURN_IF_ERROR(Note(CheckScenes()));
  LATTICED_RETURN_IF_ERROR(Note(CheckShares()));
  LATTICED_RETURN_IF_ERROR(Note(CheckMeshes()));
  return std::move(findings_);
}

}  // namespace

absl::StatusOr<StoreFindings> CheckStore(const std::string& folder) {
  if (std::error_code failure; !std::filesystem::exists(folder + "/latticed.sqlite", failure)) {
    return absl::NotFoundError(fmt::format("{} has no store: there is no latticed.sqlite", folder));
  }
  return StoreCheck(folder).Run();
}

}  // namespace latticed
