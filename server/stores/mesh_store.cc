// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/stores/mesh_store.h"

#include <utility>

#include "absl/time/clock.h"
#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/base/auth/tenant.h"

namespace latticed {

absl::StatusOr<std::shared_ptr<const StoredMesh>> MeshStore::Add(StoredMesh mesh,
                                                                 MemoryReservation reservation,
                                                                 const Admission& admit) {
  const auto stored_before =
      [&](const auto& stored) -> absl::StatusOr<std::shared_ptr<const StoredMesh>> {
    if (stored->format == mesh.format && stored->layout == mesh.layout) return stored;
    return error::AlreadyExists("mesh in another format or layout", IdOf(mesh.id));
  };
  const auto found = Find(mesh.id);
  if (found.ok()) return stored_before(*found);
  // Bytes that were damaged are written anew.
  if (!absl::IsNotFound(found.status()) && !absl::IsDataLoss(found.status())) return found;
  // Without the lock: it may evict scenes, and the registry's lock comes before this one.
  LATTICED_RETURN_IF_ERROR(reservation.Resize("the mesh", mesh.MemoryBytes()));
  if (mesh.create_time == absl::Time()) mesh.create_time = absl::Now();
  const Work work(this, mesh.id);
  if (const auto meanwhile = InMemory(mesh.id)) return stored_before(meanwhile);
  if (admit != nullptr) LATTICED_RETURN_IF_ERROR(Admit(mesh, admit));
  if (keeping_.store != nullptr) {
    LATTICED_RETURN_IF_ERROR(
        keeping_.store->PutMesh(mesh.id, keeping_.header_of(mesh), *mesh.bytes));
  }
  mesh.memory = std::move(reservation);
  const MutexLock lock(&mutex_);
  return Keep(std::move(mesh));
}

absl::Status MeshStore::Admit(const StoredMesh& mesh, const Admission& admit) {
  const MutexLock admission_lock(&admission_mutex_);
  Arriving arriving;
  {
    const MutexLock lock(&mutex_);
    arriving = arriving_;  // before the store is asked: none is missed that it gets meanwhile
  }
  LATTICED_RETURN_IF_ERROR(admit(arriving));
  const MutexLock lock(&mutex_);
  arriving_[mesh.id] = mesh.bytes->size();
  return absl::OkStatus();
}

std::shared_ptr<const StoredMesh> MeshStore::Keep(StoredMesh mesh) {
  auto kept = std::make_shared<const StoredMesh>(std::move(mesh));
  meshes_[kept->id] = {kept, absl::Now()};
  return kept;
}

absl::StatusOr<std::shared_ptr<const StoredMesh>> MeshStore::Find(std::string_view id) {
  const std::string key(id);
  // Destroyed after the lock is released.
  const std::shared_ptr<const StoredMesh> deleted = TakeDeletedElsewhere(key);
  {
    const MutexLock lock(&mutex_);
    AwaitFree(key);
    if (const auto found = meshes_.find(key); found != meshes_.end()) {
      found->second.last_use = absl::Now();
      return found->second.mesh;
    }
    if (keeping_.store == nullptr) return error::NotFound("mesh", IdOf(id));
  }
  const Work work(this, key);
  if (auto meanwhile = InMemory(key)) return meanwhile;
  return Read(key);
}

std::shared_ptr<const StoredMesh> MeshStore::TakeDeletedElsewhere(const std::string& id) {
  if (keeping_.store == nullptr || !keeping_.store->shared()) return nullptr;
  std::shared_ptr<const StoredMesh> mesh = InMemory(id);
  if (mesh == nullptr || !absl::IsNotFound(keeping_.store->ReadMeshHeader(id).status()))
    return nullptr;
  const MutexLock lock(&mutex_);
  const auto found = meshes_.find(id);
  if (found != meshes_.end() && found->second.mesh == mesh) meshes_.erase(found);
  return mesh;
}

void MeshStore::AwaitFree(const std::string& id) {
  const auto free = [&]() ABSL_NO_THREAD_SAFETY_ANALYSIS { return !busy_.contains(id); };
  mutex_.Await(free);
}

MeshStore::Work::Work(MeshStore* store, std::string id) : store_(store), id_(std::move(id)) {
  const MutexLock lock(&store_->mutex_);
  store_->AwaitFree(id_);
  store_->busy_.insert(id_);
}

MeshStore::Work::~Work() {
  const MutexLock lock(&store_->mutex_);
  store_->busy_.erase(id_);
  store_->arriving_.erase(id_);
}

absl::StatusOr<std::shared_ptr<const StoredMesh>> MeshStore::Read(const std::string& id) {
  auto mesh = CatchBadAlloc("the mesh", [&] { return keeping_.read(id); });
  LATTICED_RETURN_IF_ERROR(mesh.status());
  const MutexLock lock(&mutex_);
  return Keep(*std::move(mesh));
}

bool MeshStore::IsAsleep(std::string_view id) const {
  const MutexLock lock(&mutex_);
  return keeping_.store != nullptr && (busy_.contains(id) || !meshes_.contains(id));
}

std::shared_ptr<const StoredMesh> MeshStore::InMemory(std::string_view id) const {
  const MutexLock lock(&mutex_);
  const auto found = meshes_.find(id);
  return found == meshes_.end() ? nullptr : found->second.mesh;
}

std::vector<std::shared_ptr<const StoredMesh>> MeshStore::All() const {
  std::vector<std::shared_ptr<const StoredMesh>> all;
  const MutexLock lock(&mutex_);
  for (const auto& [id, entry] : meshes_) all.push_back(entry.mesh);
  return all;
}

absl::StatusOr<std::vector<ListedMesh>> MeshStore::List() const {
  std::vector<ListedMesh> list;
  if (keeping_.store == nullptr) {
    for (const auto& mesh : All()) list.push_back({mesh->id, "", mesh});
    return list;
  }
  LATTICED_ASSIGN_OR_RETURN(auto stored, keeping_.store->Meshes());
  for (StoredEntry& entry : stored) {
    auto mesh = InMemory(entry.id);
    list.push_back({std::move(entry.id), std::move(entry.header), std::move(mesh)});
  }
  return list;
}

absl::Status MeshStore::Remove(std::string_view id) {
  const std::string key(id);
  std::shared_ptr<const StoredMesh> removed;  // destroyed after the lock is released
  const Work work(this, key);
  if (keeping_.store != nullptr) LATTICED_RETURN_IF_ERROR(keeping_.store->DeleteMesh(id));
  const MutexLock lock(&mutex_);
  const auto found = meshes_.find(key);
  if (found == meshes_.end()) {
    return keeping_.store != nullptr ? absl::OkStatus() : error::NotFound("mesh", IdOf(id));
  }
  removed = std::move(found->second.mesh);
  meshes_.erase(found);
  return absl::OkStatus();
}

void MeshStore::DropUnusedSince(absl::Time time) {
  if (keeping_.store == nullptr) return;
  std::vector<std::shared_ptr<const StoredMesh>> dropped;  // destroyed after the lock is released
  const MutexLock lock(&mutex_);
  for (auto at = meshes_.begin(); at != meshes_.end();) {
    auto& [mesh, last_use] = at->second;
    // Scenes keep what was read, not the upload.
    if (mesh.use_count() > 1 || mesh->mesh.use_count() > 1) last_use = absl::Now();
    if (last_use >= time) {
      ++at;
      continue;
    }
    dropped.push_back(std::move(mesh));
    at = meshes_.erase(at);
  }
}

}  // namespace latticed
