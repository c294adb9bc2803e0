// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/postgres_store.h"

#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "core/base/error.h"
#include "core/base/read_file.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/telemetry.h"
#include "server/store/files/mesh_folder.h"
#include "server/store/objects/mesh_names.h"
#include "server/store/objects/s3_meshes.h"
#include "server/store/objects/s3_options.h"
#include "server/store/postgres/claim.h"
#include "server/store/postgres/lease.h"
#include "server/store/postgres/mesh_rows.h"
#include "server/store/postgres/pool.h"
#include "server/store/postgres/reader.h"
#include "server/store/postgres/schema.h"
#include "server/store/postgres/share_rows.h"
#include "server/store/postgres/writer.h"

namespace latticed {
namespace {

// Another server may be about to make a file's row. A file of this age has none because its server crashed.
constexpr absl::Duration kStrayAge = absl::Hours(24);

class PostgresStore : public Store {
 public:
  PostgresStore(const std::string& url, const PostgresStoreOptions& options)
      : options_(options),
        pool_(url),
        lease_(url, options.name, options.lease),
        writer_(url, &lease_, options.fence, &counts_) {}

  absl::Status Start();

  absl::Status CreateScene(std::string_view id, std::string header) override {
    return writer_.Create(id, header);
  }
  absl::Status CreateSceneAt(std::string_view id, std::string header, uint64_t lsn,
                             std::string snapshot) override {
    return writer_.CreateAt(id, header, lsn, snapshot);
  }
  absl::Status DeleteScene(std::string_view id) override { return writer_.Delete(id); }
  absl::StatusOr<std::vector<StoredEntry>> Scenes() override {
    return ReadPostgresEntries(pool_, "scene");
  }
  absl::StatusOr<std::string> ReadSceneHeader(std::string_view id) override {
    return ReadPostgresHeader(pool_, "scene", id);
  }
  absl::StatusOr<SceneLog> ReadScene(std::string_view id) override;
  absl::StatusOr<SceneLog> CopyScene(std::string_view id) override {
    LATTICED_ASSIGN_OR_RETURN(PgScene scene, ReadPostgresScene(pool_, std::nullopt, id));
    return std::move(scene.log);
  }
  void Append(std::string_view scene, uint64_t lsn, std::string record, Done done) override;
  absl::Status Admit() override { return writer_.queue().Admit(); }
  void PutSnapshot(std::string_view scene, uint64_t lsn, std::string snapshot) override;
  void Flush() override { writer_.Settle().IgnoreError(); }  // all is answered, whatever it says
  absl::StatusOr<SceneClaim> ClaimScene(std::string_view id) override {
    return ClaimPostgresScene(pool_, lease_, id);
  }
  absl::Status ReleaseScene(std::string_view id) override { return writer_.Release(id); }
  absl::Status ExpireScene(std::string_view id, absl::Duration unused) override {
    return ExpirePostgresScene(pool_, lease_, id, unused);
  }
  void OnFenced(std::function<void()> fenced) override { lease_.OnFenced(std::move(fenced)); }
  bool shared() const override { return true; }
  absl::StatusOr<std::vector<StoredServer>> Servers() override {
    return ReadPostgresServers(pool_);
  }
  void SetFreeBytes(uint64_t bytes) override { lease_.SetFreeBytes(bytes); }
  absl::Status PutMesh(std::string_view id, std::string header, std::string_view bytes) override;
  absl::Status DeleteMesh(std::string_view id) override;
  absl::StatusOr<std::vector<StoredEntry>> Meshes() override {
    return ReadPostgresEntries(pool_, "mesh");
  }
  absl::StatusOr<std::string> ReadMeshHeader(std::string_view id) override {
    return ReadPostgresHeader(pool_, "mesh", id);
  }
  absl::StatusOr<std::string> ReadMesh(std::string_view id) override;
  absl::Status PutShare(std::string_view id, std::string_view scene, std::string header) override {
    return PutPostgresShare(pool_, id, scene, header);
  }
  absl::Status DeleteShare(std::string_view id) override { return DeletePostgresShare(pool_, id); }
  absl::StatusOr<std::vector<StoredEntry>> Shares() override {
    return ReadPostgresEntries(pool_, "share");
  }
  absl::StatusOr<std::string> SharesMark() override { return ReadPostgresSharesMark(pool_); }

 private:
  absl::Status CheckMeshes();

  const PostgresStoreOptions options_;
  std::unique_ptr<MeshObjects> meshes_;
  PgPool pool_;
  PgLease lease_;  // outlives the writer, and ends the session
  PgWriter writer_;
};

absl::Status PostgresStore::Start() {
  if (IsS3Url(options_.mesh_store)) {
    LATTICED_ASSIGN_OR_RETURN(
        S3Options s3, S3OptionsOf(options_.mesh_store, options_.s3_endpoint, options_.s3_region));
    meshes_ = std::make_unique<S3Meshes>(std::move(s3));
  }
  LATTICED_RETURN_IF_ERROR(pool_.With(PreparePostgresSchema));
  LATTICED_RETURN_IF_ERROR(lease_.Start());
  LATTICED_RETURN_IF_ERROR(writer_.Start());
  if (meshes_ == nullptr) {
    meshes_ =
        std::make_unique<MeshFolder>(options_.mesh_store, fmt::format("{}-", lease_.session()));
  }
  const absl::Status status = CheckMeshes();
  // Another server may have deleted a mesh in between.
  return absl::IsDataLoss(status) ? CheckMeshes() : status;
}

absl::Status PostgresStore::CheckMeshes() {
  LATTICED_ASSIGN_OR_RETURN(const std::vector<StoredEntry> meshes, Meshes());
  std::vector<std::string> ids;
  ids.reserve(meshes.size());
  for (const StoredEntry& mesh : meshes) ids.push_back(mesh.id);
  return meshes_->Open(ids, kStrayAge);
}

absl::StatusOr<SceneLog> PostgresStore::ReadScene(std::string_view id) {
  LATTICED_RETURN_IF_ERROR(writer_.Settle());
  const int64_t session = lease_.session();
  LATTICED_ASSIGN_OR_RETURN(PgScene scene, ReadPostgresScene(pool_, session, id));
  writer_.Learn(id, scene.tail, session);
  return std::move(scene.log);
}

void PostgresStore::Append(std::string_view scene, uint64_t lsn, std::string record, Done done) {
  writer_.queue().PutAppend(scene, lsn, std::move(record), std::move(done));
}

void PostgresStore::PutSnapshot(std::string_view scene, uint64_t lsn, std::string snapshot) {
  writer_.queue().PutSnapshot(scene, lsn, std::move(snapshot));
}

absl::Status PostgresStore::PutMesh(std::string_view id, std::string header,
                                    std::string_view bytes) {
  if (!IsMeshId(id)) return error::InvalidField("id", "is not a SHA-256 in hex");
  const absl::StatusOr<std::string> known = ReadMeshHeader(id);
  if (known.ok() && meshes_->Read(id).ok()) return absl::OkStatus();  // else it is written anew
  LATTICED_RETURN_IF_ERROR(writer_.queue().Admit());
  LATTICED_ASSIGN_OR_RETURN(const std::string written, meshes_->Write(id, bytes));
  const absl::Status status =
      InsertPostgresMesh(pool_, id, header, [&] { return meshes_->Publish(written, id, bytes); });
  // A file that has its name already stays: the next PutMesh, or a start after a day, sees to it.
  if (!status.ok()) meshes_->Discard(written);
  return status;
}

absl::Status PostgresStore::DeleteMesh(std::string_view id) {
  return DeletePostgresMesh(pool_, id, [&] {
    // The mesh is gone already. A file that stays is removed at a start.
    if (const absl::Status status = meshes_->Remove(id); !status.ok()) {
      LogEvent(spdlog::level::warn, "file of a deleted mesh not removed",
               {{"error", std::string(status.message())}});
    }
  });
}

absl::StatusOr<std::string> PostgresStore::ReadMesh(std::string_view id) {
  LATTICED_RETURN_IF_ERROR(ReadMeshHeader(id).status());
  return meshes_->Read(id);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Store>> OpenPostgresStore(const PostgresStoreOptions& options) {
  LATTICED_ASSIGN_OR_RETURN(const std::string text, ReadFile(options.url_file));
  const std::string url(absl::StripAsciiWhitespace(text));
  if (const absl::Status status = PgConnection::CheckUrl(url); !status.ok()) {
    return absl::InvalidArgumentError(
        fmt::format("{}: {}", options.url_file, std::string(status.message())));
  }
  auto store = std::make_unique<PostgresStore>(url, options);
  LATTICED_RETURN_IF_ERROR(store->Start());
  return store;
}

}  // namespace latticed
