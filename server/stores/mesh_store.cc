// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/stores/mesh_store.h"

#include <utility>

#include "absl/time/clock.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace latticed {

absl::StatusOr<std::shared_ptr<const StoredMesh>> MeshStore::Add(StoredMesh mesh,
                                                                 MemoryReservation reservation) {
  const auto stored_before =
      [&](const auto& stored) -> absl::StatusOr<std::shared_ptr<const StoredMesh>> {
    if (stored->format == mesh.format && stored->layout == mesh.layout) return stored;
    return error::AlreadyExists("mesh in another format or layout", mesh.id);
  };
  if (const auto found = Find(mesh.id); found.ok()) return stored_before(*found);
  // Without the lock: it may evict scenes, and the registry's lock comes before this one.
  LATTICED_RETURN_IF_ERROR(reservation.Resize("the mesh", mesh.MemoryBytes()));
  mesh.create_time = absl::Now();
  const MutexLock store_lock(&store_mutex_);
  if (store_ != nullptr) {
    LATTICED_RETURN_IF_ERROR(store_->PutMesh(mesh.id, header_of_(mesh), *mesh.bytes));
  }
  const MutexLock lock(&mutex_);
  const auto found = meshes_.find(mesh.id);  // another upload may have come first
  if (found != meshes_.end()) return stored_before(found->second);
  mesh.memory = std::move(reservation);
  auto stored = std::make_shared<const StoredMesh>(std::move(mesh));
  meshes_.emplace(stored->id, stored);
  return stored;
}

absl::Status MeshStore::Restore(StoredMesh mesh, MemoryReservation reservation) {
  LATTICED_RETURN_IF_ERROR(reservation.Resize("the mesh", mesh.MemoryBytes()));
  mesh.memory = std::move(reservation);
  const MutexLock lock(&mutex_);
  const std::string id = mesh.id;
  meshes_.emplace(id, std::make_shared<const StoredMesh>(std::move(mesh)));
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<const StoredMesh>> MeshStore::Find(std::string_view id) const {
  const MutexLock lock(&mutex_);
  const auto found = meshes_.find(id);
  if (found == meshes_.end()) return error::NotFound("mesh", id);
  return found->second;
}

std::vector<std::shared_ptr<const StoredMesh>> MeshStore::All() const {
  std::vector<std::shared_ptr<const StoredMesh>> all;
  const MutexLock lock(&mutex_);
  for (const auto& [id, mesh] : meshes_) all.push_back(mesh);
  return all;
}

absl::Status MeshStore::Remove(std::string_view id) {
  const MutexLock store_lock(&store_mutex_);
  if (store_ != nullptr) {
    LATTICED_RETURN_IF_ERROR(Find(id).status());
    LATTICED_RETURN_IF_ERROR(store_->DeleteMesh(id));
  }
  std::shared_ptr<const StoredMesh> removed;  // destroyed after the lock is released
  const MutexLock lock(&mutex_);
  const auto found = meshes_.find(id);
  if (found == meshes_.end()) return error::NotFound("mesh", id);
  removed = std::move(found->second);
  meshes_.erase(found);
  return absl::OkStatus();
}

size_t MeshStore::size() const {
  const MutexLock lock(&mutex_);
  return meshes_.size();
}

}  // namespace latticed
