// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/backup/backup_source.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"
#include "server/engine/scene/scene_replay.h"
#include "server/rpc/server_env.h"
#include "server/store/records/scene_codec.h"
#include "server/stores/scene_registry.h"
#include "server/wire/stored_mesh.h"
#include "server/wire/stored_scene.h"

namespace latticed {
namespace {

constexpr char kPurpose[] = "the backup";
// A log takes so many times its bytes while it becomes one snapshot: as messages, as a history, as bytes.
constexpr uint64_t kReplayTimes = 6;

uint64_t BytesOf(const SceneLog& log) {
  uint64_t bytes = log.header.size() + log.snapshot.size();
  for (const std::string& record : log.records) bytes += record.size();
  return bytes;
}

// Its records become part of the snapshot.
absl::Status Compact(SceneLog& log) {
  if (log.records.empty()) return absl::OkStatus();
  LATTICED_ASSIGN_OR_RETURN(const SceneLife life, Replay(log));
  if (!life.box.has_value()) return absl::DataLossError("no record has a quantisation box");
  log.snapshot_lsn = log.lsn();
  log.records.clear();
  log.snapshot = EncodeImage({.histories = life.history.images(),
                              .box = *life.box,
                              .now = life.now,
                              .commit_time = life.commit_time});
  return absl::OkStatus();
}

}  // namespace

std::string BackupSum(const v1::BackupItem& item, std::string_view header,
                      std::string_view content) {
  constexpr std::string_view kZero("\0", 1);
  Sha256 sum;
  sum.Update(item.has_mesh() ? item.mesh() : item.scene());
  sum.Update(kZero);
  sum.Update(fmt::to_string(item.records()));
  sum.Update(kZero);
  sum.Update(header);
  sum.Update(content);
  return sum.FinishHex();
}

absl::StatusOr<std::vector<BackupSource::Place>> BackupSource::Scenes() {
  std::vector<Place> places;
  if (env_.store == nullptr) {
    for (const auto& scene : env_.scenes->All()) {
      if (TenantOf(scene->id()) != tenant_) continue;
      places.push_back({scene->config().mesh_id, scene->id(), {}});
    }
    return places;
  }
  LATTICED_ASSIGN_OR_RETURN(const auto stored, env_.store->Scenes());
  for (const StoredEntry& entry : stored) {
    if (TenantOf(entry.id) != tenant_) continue;
    Place place{"", entry.id, entry.damage};
    if (place.damage.ok()) {
      const auto scene = StoredSceneOf(entry.header);
      place.damage = scene.status();
      if (scene.ok()) place.mesh = scene->mesh_id;
    }
    places.push_back(std::move(place));
  }
  return places;
}

absl::Status BackupSource::Open(const std::vector<std::string>& named) {
  LATTICED_ASSIGN_OR_RETURN(std::vector<Place> scenes, Scenes());
  std::set<std::string> meshes;
  if (named.empty()) {
    LATTICED_ASSIGN_OR_RETURN(const auto all, env_.meshes.List());
    for (const ListedMesh& mesh : all) {
      if (TenantOf(mesh.id) == tenant_) meshes.insert(mesh.id);
    }
  } else {
    std::set<std::string> wanted;
    for (const std::string& id : named) wanted.insert(TenantKey(tenant_, id));
    if (wanted.size() != named.size()) return error::InvalidField("scenes", "names one twice");
    std::erase_if(scenes, [&](const Place& place) { return !wanted.contains(place.scene); });
    for (const std::string& id : wanted) {
      if (std::ranges::find(scenes, id, &Place::scene) == scenes.end()) {
        return error::NotFound("scene", IdOf(id));
      }
    }
  }
  for (const Place& place : scenes) {
    if (!place.mesh.empty()) meshes.insert(place.mesh);
  }
  places_ = std::move(scenes);
  for (const std::string& mesh : meshes) places_.push_back({mesh, "", {}});
  // Each mesh before its scenes.
  std::ranges::sort(places_, [](const Place& a, const Place& b) {
    return std::tie(a.mesh, a.scene) < std::tie(b.mesh, b.scene);
  });
  return absl::OkStatus();
}

absl::StatusOr<std::optional<BackupCopy>> BackupSource::Next() {
  while (next_ < places_.size()) {
    const Place& place = places_[next_++];
    auto copy = Copy(place);
    if (copy.ok()) return std::optional(*std::move(copy));
    if (absl::IsNotFound(copy.status()) && !place.scene.empty()) continue;
    if (place.scene.empty()) lost_meshes_.insert(place.mesh);
    if (absl::IsNotFound(copy.status())) continue;
    if (!absl::IsDataLoss(copy.status())) return copy.status();
    BackupCopy damaged;
    place.scene.empty() ? damaged.item.set_mesh(std::string(IdOf(place.mesh)))
                        : damaged.item.set_scene(std::string(IdOf(place.scene)));
    damaged.item.set_damage(std::string(copy.status().message()));
    return std::optional(std::move(damaged));
  }
  return std::optional<BackupCopy>();
}

absl::StatusOr<BackupCopy> BackupSource::Copy(const Place& place) {
  LATTICED_RETURN_IF_ERROR(place.damage);
  BackupCopy copy;
  if (place.scene.empty()) {
    LATTICED_RETURN_IF_ERROR(CopyMesh(place.mesh, copy));
  } else if (lost_meshes_.contains(place.mesh)) {
    return absl::DataLossError(fmt::format("its mesh {} cannot be copied", IdOf(place.mesh)));
  } else {
    LATTICED_RETURN_IF_ERROR(CopyScene(place.scene, copy));
  }
  copy.item.set_header_bytes(copy.header.size());
  copy.item.set_content_bytes(copy.content->size());
  copy.item.set_sha256(BackupSum(copy.item, copy.header, *copy.content));
  return copy;
}

absl::Status BackupSource::CopyMesh(const std::string& id, BackupCopy& copy) {
  copy.item.set_mesh(std::string(IdOf(id)));
  if (const auto mesh = env_.meshes.InMemory(id); mesh != nullptr) {
    LATTICED_ASSIGN_OR_RETURN(copy.header, HeaderForTenant(StoredHeaderOf(*mesh), ""));
    copy.content = {mesh, mesh->bytes.get()};
    return absl::OkStatus();
  }
  if (env_.store == nullptr) return error::NotFound("mesh", IdOf(id));
  LATTICED_ASSIGN_OR_RETURN(const std::string header, env_.store->ReadMeshHeader(id));
  LATTICED_ASSIGN_OR_RETURN(copy.header, HeaderForTenant(header, ""));
  const auto listed = ListedFromStored(copy.header);
  LATTICED_ASSIGN_OR_RETURN(
      copy.room, env_.memory->Reserve(kPurpose, listed.ok() ? listed->total_bytes() : 0, account_));
  LATTICED_ASSIGN_OR_RETURN(auto bytes, env_.store->ReadMesh(id));
  LATTICED_RETURN_IF_ERROR(copy.room.Resize(kPurpose, bytes.size()));
  copy.content = std::make_shared<const std::string>(std::move(bytes));
  return absl::OkStatus();
}

absl::Status BackupSource::CopyScene(const std::string& id, BackupCopy& copy) {
  copy.item.set_scene(std::string(IdOf(id)));
  LATTICED_ASSIGN_OR_RETURN(copy.room, env_.memory->Reserve(kPurpose, 0, account_));
  LATTICED_ASSIGN_OR_RETURN(SceneLog log, ReadLog(id, copy.room));
  copy.item.set_records(log.snapshot_lsn);
  LATTICED_ASSIGN_OR_RETURN(copy.header, HeaderForCopy(log.header));
  copy.content = std::make_shared<const std::string>(std::move(log.snapshot));
  return copy.room.Resize(kPurpose, copy.header.size() + copy.content->size());
}

absl::StatusOr<SceneLog> BackupSource::ReadLog(const std::string& id, MemoryReservation& room) {
  if (env_.store == nullptr) {
    LATTICED_ASSIGN_OR_RETURN(const auto scene, env_.scenes->Find(id));
    const MemoryUse use = scene->memory();
    const auto history = use.find("history");
    const uint64_t bytes = history == use.end() ? 0 : history->second;
    LATTICED_RETURN_IF_ERROR(room.Resize(kPurpose, kReplayTimes * bytes));
    return scene->Copy();
  }
  LATTICED_ASSIGN_OR_RETURN(SceneLog log, env_.store->CopyScene(id));
  LATTICED_RETURN_IF_ERROR(room.Resize(kPurpose, kReplayTimes * BytesOf(log)));
  LATTICED_RETURN_IF_ERROR(Compact(log));
  return log;
}

}  // namespace latticed
