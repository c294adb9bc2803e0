// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/backup/restorer.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "absl/strings/cord.h"
#include "absl/time/clock.h"
#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"
#include "server/engine/memory/allocation_limit.h"
#include "server/engine/scene/copied_history.h"
#include "server/rpc/access/audit.h"
#include "server/rpc/access/quota_access.h"
#include "server/rpc/access/tenant_access.h"
#include "server/rpc/backup/backup_source.h"
#include "server/rpc/call.h"
#include "server/rpc/server_env.h"
#include "server/stores/callers.h"
#include "server/stores/scene_registry.h"
#include "server/wire/stored_mesh.h"
#include "server/wire/stored_scene.h"

namespace latticed {
namespace {

constexpr char kRoomName[] = "the restore";
constexpr size_t kMostIdBytes = 256;
// The request that made a scene, with the largest lattice twice and its labels, is below this.
constexpr uint64_t kMostHeaderBytes = uint64_t{4} << 20;
// The undo steps of a scene are below this as bytes.
constexpr uint64_t kMostHistoryBytes = 4 * limits::kMaxUndoBytes;
// The bytes of a scene take so many times their size while they are checked: often, and at most. Beside it libraries take
// some, and a plan takes what it reserves itself.
constexpr uint64_t kCheckTimes[] = {6, 32};
constexpr uint64_t kLibrariesBytes = uint64_t{1} << 20;

absl::Status Malformed(std::string_view problem) {
  return error::InvalidField("part", problem, "MALFORMED_FILE");
}

// Of bytes that a store would call damaged.
absl::Status AsRefusal(const absl::Status& status) {
  return absl::IsDataLoss(status) ? Malformed(std::string(status.message())) : status;
}

std::string NameOf(const v1::BackupItem& item) {
  return item.has_mesh() ? fmt::format("mesh {}", item.mesh())
                         : fmt::format("scene '{}'", item.scene());
}

}  // namespace

absl::Status Restorer::Named(const absl::Status& status) const {
  if (status.ok()) return status;
  const std::string before = done_.meshes() + done_.scenes() == 0
                                 ? ""
                                 : fmt::format("; {} meshes and {} scenes before it are restored",
                                               done_.meshes(), done_.scenes());
  absl::Status named(status.code(),
                     fmt::format("{}: {}{}", NameOf(item_), std::string(status.message()), before));
  status.ForEachPayload(
      [&](absl::string_view url, const absl::Cord& payload) { named.SetPayload(url, payload); });
  return named;
}

std::optional<std::string> Restorer::NewOwner() const {
  if (call_.caller.role >= Role::kAdmin) return std::nullopt;
  return call_.caller.name;
}

absl::Status Restorer::Take(const v1::BackupPart& part) {
  if (is_ended_) return Malformed("came after the end");
  if (!is_started_ && !part.has_start()) return Malformed("the first one must be the start");
  LATTICED_RETURN_IF_ERROR([&]() -> absl::Status {
    switch (part.part_case()) {
      case v1::BackupPart::kStart:
        return TakeStart(part.start());
      case v1::BackupPart::kItem:
        return TakeItem(part.item());
      case v1::BackupPart::kData:
        return is_open_ ? Named(TakeData(part.data())) : Malformed("these data are of no item");
      case v1::BackupPart::kEnd:
        return TakeEnd(part.end());
      case v1::BackupPart::PART_NOT_SET:
        break;
    }
    return Malformed("is not known to this server");
  }());
  ++parts_;
  return absl::OkStatus();
}

absl::Status Restorer::TakeStart(const v1::BackupStart& start) {
  if (is_started_) return Malformed("the start came twice");
  if (start.format() != kBackupFormat) {
    return error::FailedPrecondition(
        "UNSUPPORTED",
        fmt::format("the backup has format {}, and this server reads {}; take a newer server",
                    start.format(), kBackupFormat));
  }
  is_started_ = true;
  return absl::OkStatus();
}

absl::Status Restorer::TakeItem(const v1::BackupItem& item) {
  if (is_open_) return Named(Malformed("the next item came before all of its data"));
  if (item.id_case() == v1::BackupItem::ID_NOT_SET) return Malformed("an item without an id");
  if (!item.damage().empty()) {
    done_.set_damaged(done_.damaged() + 1);
    return absl::OkStatus();
  }
  if (std::max(item.mesh().size(), item.scene().size()) > kMostIdBytes) {
    return Malformed("an id is too long");
  }
  item_ = item;
  const uint64_t most = item.has_mesh() ? env_.options.max_mesh_bytes : kMostHistoryBytes;
  if (item.header_bytes() == 0 || item.header_bytes() > kMostHeaderBytes ||
      item.content_bytes() > most) {
    return Named(
        Malformed(fmt::format("a header of {} bytes and a content of {}: at most {} and {}",
                              item.header_bytes(), item.content_bytes(), kMostHeaderBytes, most)));
  }
  // Room for it: meshes that nobody uses are read again when they are needed.
  if (item.content_bytes() > env_.memory->free_bytes() / 4) {
    env_.meshes.DropUnusedSince(absl::Now());
  }
  header_.clear();
  LATTICED_ASSIGN_OR_RETURN(header_room_,
                            env_.memory->Reserve(kRoomName, 0, call_.account->memory));
  content_ = nullptr;
  if (item.content_bytes() > 0) {
    auto admitted = env_.uploads->Admit(
        {.mesh = {}, .total_bytes = item.content_bytes(), .sha256 = ""}, *call_.account);
    if (!admitted.ok()) return Named(admitted.status());
    content_ = *std::move(admitted);
  }
  missing_ = item.header_bytes() + item.content_bytes();
  is_open_ = true;
  return absl::OkStatus();
}

absl::Status Restorer::TakeData(std::string_view data) {
  if (data.empty() || data.size() > limits::kMaxPartBytes || data.size() > missing_) {
    return Malformed(
        fmt::format("a part of {} bytes, where {} are missing", data.size(), missing_));
  }
  missing_ -= data.size();
  const size_t of_header = std::min(data.size(), item_.header_bytes() - header_.size());
  if (of_header > 0) {
    LATTICED_RETURN_IF_ERROR(header_room_.Resize(kRoomName, header_.size() + of_header));
    header_.append(data.substr(0, of_header));
    data.remove_prefix(of_header);
  }
  return data.empty() ? absl::OkStatus() : content_->Append(data);
}

absl::Status Restorer::TakeEnd(const v1::BackupEnd& end) {
  if (is_open_) return Named(Malformed("the end came before all of its data"));
  if (end.parts() != parts_) {
    return Malformed(
        fmt::format("{} parts came before the end, and it says {}", parts_, end.parts()));
  }
  is_ended_ = true;
  return absl::OkStatus();
}

absl::StatusOr<v1::RestoreResponse> Restorer::Finish() const {
  if (is_ended_) return done_;
  return is_open_ ? Named(Malformed("the backup ends in it")) : Malformed("the backup has no end");
}

absl::Status Restorer::Store() {
  const absl::Status status = Named(AsRefusal(StoreItem()));
  is_open_ = false;
  content_ = nullptr;
  std::string().swap(header_);
  header_room_.Release();
  return status;
}

absl::Status Restorer::StoreItem() {
  CompleteUpload upload{
      .header = {}, .bytes = std::make_shared<const std::string>(), .reservation = {}};
  if (content_ != nullptr) {
    LATTICED_ASSIGN_OR_RETURN(upload, content_->Take());
  }
  if (BackupSum(item_, header_, *upload.bytes) != item_.sha256()) {
    return error::InvalidField("part", "these are not the bytes that were backed up",
                               "HASH_MISMATCH");
  }
  return item_.has_mesh() ? StoreMesh(std::move(upload)) : StoreScene(std::move(upload));
}

absl::Status Restorer::StoreMesh(CompleteUpload upload) {
  if (content_ == nullptr) return Malformed("has no bytes");
  const std::string& tenant = call_.caller.tenant;
  const std::string key = KeyFor(call_, item_.mesh());
  if (const auto found = env_.meshes.Find(key); found.ok()) {
    if (*(*found)->bytes != *upload.bytes) return Malformed("has another id");
    done_.set_present_meshes(done_.present_meshes() + 1);
    return absl::OkStatus();
  }
  LATTICED_ASSIGN_OR_RETURN(const std::string header, HeaderForTenant(header_, tenant));
  LATTICED_ASSIGN_OR_RETURN(StoredMesh mesh,
                            MeshFromStored(header, std::move(upload.bytes), upload.reservation));
  if (mesh.id != key) return Malformed("has another id");
  LATTICED_RETURN_IF_ERROR(CheckCancelled(call_));
  if (const auto owner = NewOwner(); owner.has_value()) mesh.owner = *owner;
  const auto admit = [&, bytes = mesh.bytes->size()](const MeshStore::Arriving& arriving) {
    return CheckMeshQuota(env_, tenant, arriving, bytes);
  };
  LATTICED_RETURN_IF_ERROR(
      env_.meshes.Add(std::move(mesh), std::move(upload.reservation), admit).status());
  Audit(env_, call_, "mesh_restored", {{"mesh", item_.mesh()}});
  done_.set_meshes(done_.meshes() + 1);
  return absl::OkStatus();
}

absl::Status Restorer::WithinMemory(const std::function<absl::Status()>& check) const {
  absl::Status status;
  for (const uint64_t times : kCheckTimes) {
    const uint64_t most = times * (item_.header_bytes() + item_.content_bytes()) + kLibrariesBytes;
    LATTICED_ASSIGN_OR_RETURN(const auto room,
                              env_.memory->Reserve(kRoomName, most, call_.account->memory));
    const AllocationLimit limit(most);
    status = CatchBadAlloc("the scene", check);
    if (!absl::IsResourceExhausted(status)) break;
  }
  return status;
}

absl::Status Restorer::StoreScene(CompleteUpload upload) {
  SceneLog log{
      .header = std::move(header_), .snapshot_lsn = item_.records(), .snapshot = *upload.bytes};
  std::string mesh_id;
  LATTICED_RETURN_IF_ERROR(WithinMemory([&]() -> absl::Status {
    LATTICED_ASSIGN_OR_RETURN(const StoredScene scene, StoredSceneOf(log.header));
    mesh_id = IdOf(scene.mesh_id);
    return absl::OkStatus();
  }));
  LATTICED_ASSIGN_OR_RETURN(const auto mesh, FindMesh(env_, call_, mesh_id));
  SceneConfig config;
  LATTICED_RETURN_IF_ERROR(WithinMemory([&]() -> absl::Status {
    LATTICED_ASSIGN_OR_RETURN(config, SceneConfigFromCopy(log.header, *mesh, NewOwner()));
    return CheckCopied(log);
  }));
  if (config.id != KeyFor(call_, item_.scene())) return Malformed("has another id");
  log.header = config.stored_header;
  if (env_.store != nullptr) config.stored_header.clear();
  config.account = call_.account->memory;
  const auto has_mesh = [&] {
    return env_.meshes.InMemory(mesh->id) != nullptr ? absl::OkStatus()
                                                     : error::NotFound("mesh", mesh_id);
  };
  LATTICED_ASSIGN_OR_RETURN(auto check_quota, SceneQuotaCheck(env_, call_.caller.tenant));
  const absl::Status made = env_.scenes->Restore(
      std::move(config), std::move(log), has_mesh, [&] { return CheckCancelled(call_); },
      {.of_account = call_.account->ShareOf(static_cast<size_t>(env_.options.max_scenes)),
       .of_tenant = std::move(check_quota)});
  if (absl::IsAlreadyExists(made) && skip_existing_) {
    done_.set_skipped_scenes(done_.skipped_scenes() + 1);
    return absl::OkStatus();
  }
  LATTICED_RETURN_IF_ERROR(made);
  Audit(env_, call_, "scene_restored", {{"scene", item_.scene()}, {"mesh", mesh_id}});
  done_.set_scenes(done_.scenes() + 1);
  return absl::OkStatus();
}

}  // namespace latticed
