// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/shared_memory_store.h"

#include "absl/time/clock.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/store/store_errors.h"

namespace latticed {

void SharedMemory::Fence(std::string_view server) {
  std::function<void()> fenced;
  {
    MutexLock lock(&mutex_);
    GiveUp([&](const std::string& owner) { return owner == server; });
    if (const auto found = servers_.find(server); found != servers_.end()) {
      found->second.silent = false;
      fenced = found->second.fenced;
    }
  }
  all_.Flush();
  if (fenced) fenced();
}

void SharedMemory::GiveUp(const std::function<bool(const std::string& owner)>& whose) {
  std::erase_if(owners_, [&](const auto& owned) ABSL_NO_THREAD_SAFETY_ANALYSIS {
    if (!whose(owned.second)) return false;
    given_up_[owned.first] = absl::Now();
    return true;
  });
}

void SharedMemory::Silence(std::string_view server) {
  MutexLock lock(&mutex_);
  servers_[std::string(server)].silent = true;
}

void SharedMemory::Renew(std::string_view server) {
  MutexLock lock(&mutex_);
  servers_[std::string(server)].silent = false;
}

SharedMemoryStore::SharedMemoryStore(std::shared_ptr<SharedMemory> memory, std::string name)
    : memory_(std::move(memory)), name_(std::move(name)), all_(memory_->all()) {
  MutexLock lock(&memory_->mutex_);
  memory_->servers_[name_];
}

SharedMemoryStore::~SharedMemoryStore() {
  all_.Flush();
  MutexLock lock(&memory_->mutex_);
  memory_->GiveUp([&](const std::string& owner) { return owner == name_; });
  memory_->servers_.erase(name_);
}

bool SharedMemoryStore::Owns(std::string_view scene) const {
  const auto found = memory_->owners_.find(scene);
  return found != memory_->owners_.end() && found->second == name_;
}

absl::Status SharedMemoryStore::CheckOwned(std::string_view scene) {
  LATTICED_RETURN_IF_ERROR(all_.ReadSceneHeader(scene).status());
  MutexLock lock(&memory_->mutex_);
  return Owns(scene) ? absl::OkStatus() : error::SceneNotOwned(scene);
}

absl::Status SharedMemoryStore::CreateScene(std::string_view id, std::string header) {
  return CreateSceneAt(id, std::move(header), 0, "");
}

absl::Status SharedMemoryStore::CreateSceneAt(std::string_view id, std::string header, uint64_t lsn,
                                              std::string snapshot) {
  LATTICED_RETURN_IF_ERROR(all_.CreateSceneAt(id, std::move(header), lsn, std::move(snapshot)));
  MutexLock lock(&memory_->mutex_);
  memory_->owners_[std::string(id)] = name_;
  return absl::OkStatus();
}

absl::Status SharedMemoryStore::DeleteScene(std::string_view id) {
  LATTICED_RETURN_IF_ERROR(CheckOwned(id));
  LATTICED_RETURN_IF_ERROR(all_.DeleteScene(id));
  MutexLock lock(&memory_->mutex_);
  if (Owns(id)) memory_->owners_.erase(std::string(id));
  return absl::OkStatus();
}

absl::StatusOr<SceneLog> SharedMemoryStore::ReadScene(std::string_view id) {
  LATTICED_RETURN_IF_ERROR(CheckOwned(id));
  return all_.ReadScene(id);
}

// Posted within the lock: whoever takes the scene away waits for all that was posted before.
void SharedMemoryStore::Append(std::string_view scene, uint64_t lsn, std::string record,
                               Done done) {
  MutexLock lock(&memory_->mutex_);
  if (Owns(scene)) return all_.Append(scene, lsn, std::move(record), std::move(done));
  all_.Append(scene, 0, "",
              [id = std::string(scene), done = std::move(done)](const absl::Status& status) {
                if (done) done(absl::IsNotFound(status) ? status : error::SceneNotOwned(id));
              });
}

void SharedMemoryStore::PutSnapshot(std::string_view scene, uint64_t lsn, std::string snapshot) {
  MutexLock lock(&memory_->mutex_);
  if (Owns(scene)) all_.PutSnapshot(scene, lsn, std::move(snapshot));
}

absl::StatusOr<SceneClaim> SharedMemoryStore::ClaimScene(std::string_view id) {
  LATTICED_RETURN_IF_ERROR(all_.ReadSceneHeader(id).status());
  {
    MutexLock lock(&memory_->mutex_);
    memory_->mutex_.Await([&]() ABSL_NO_THREAD_SAFETY_ANALYSIS {
      const auto owner = memory_->owners_.find(id);
      return owner == memory_->owners_.end() || owner->second == name_ ||
             !memory_->servers_[owner->second].silent;
    });
    const auto [owner, claimed] = memory_->owners_.try_emplace(std::string(id), name_);
    if (!claimed) return SceneClaim{owner->second == name_ ? "" : owner->second};
  }
  all_.Flush();
  return SceneClaim();
}

absl::Status SharedMemoryStore::ReleaseScene(std::string_view id) {
  all_.Flush();
  MutexLock lock(&memory_->mutex_);
  if (!Owns(id)) return absl::OkStatus();
  memory_->owners_.erase(std::string(id));
  memory_->given_up_[std::string(id)] = absl::Now();
  return absl::OkStatus();
}

absl::StatusOr<std::vector<StoredEntry>> SharedMemoryStore::Scenes() {
  LATTICED_ASSIGN_OR_RETURN(std::vector<StoredEntry> scenes, all_.Scenes());
  MutexLock lock(&memory_->mutex_);
  for (StoredEntry& scene : scenes) {
    if (memory_->owners_.contains(scene.id)) continue;
    const auto given_up = memory_->given_up_.find(scene.id);
    if (given_up != memory_->given_up_.end()) scene.unused = absl::Now() - given_up->second;
  }
  return scenes;
}

absl::Status SharedMemoryStore::ExpireScene(std::string_view id, absl::Duration unused) {
  if (!all_.ReadSceneHeader(id).ok()) return absl::OkStatus();
  {
    MutexLock lock(&memory_->mutex_);
    const auto given_up = memory_->given_up_.find(id);
    if (memory_->owners_.contains(id) || given_up == memory_->given_up_.end() ||
        absl::Now() - given_up->second < unused) {
      return absl::OkStatus();
    }
    memory_->owners_[std::string(id)] = name_;
  }
  return DeleteScene(id);
}

void SharedMemoryStore::OnFenced(std::function<void()> fenced) {
  MutexLock lock(&memory_->mutex_);
  memory_->servers_[name_].fenced = std::move(fenced);
}

absl::StatusOr<std::vector<StoredServer>> SharedMemoryStore::Servers() {
  std::vector<StoredServer> servers;
  MutexLock lock(&memory_->mutex_);
  for (const auto& [name, server] : memory_->servers_) servers.push_back({name, server.free_bytes});
  return servers;
}

void SharedMemoryStore::SetFreeBytes(uint64_t bytes) {
  MutexLock lock(&memory_->mutex_);
  memory_->servers_[name_].free_bytes = bytes;
}

}  // namespace latticed
