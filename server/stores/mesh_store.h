// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Uploaded meshes by id, within the memory budget, and in the server's store if it has one. A mesh in use stays
// alive through its shared_ptr after Remove, and counts against the budget as long.
//
// Threads  safe; no lock is held while a mesh is parsed, hashed or destroyed
#ifndef LATTICED_SERVER_STORES_MESH_STORE_H_
#define LATTICED_SERVER_STORES_MESH_STORE_H_

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/base/bounds.h"
#include "core/base/mutex.h"
#include "core/mesh/mesh_units.h"
#include "core/mesh/polygon_mesh.h"
#include "server/engine/memory/memory_budget.h"
#include "server/store/store.h"

namespace latticed {

// How the bytes of an upload are to be read; RAW is described by its own header.
enum class UploadFormat { kObj, kPly, kStl, kGlb, kDraco, kRaw };

// What is known of a mesh before its bytes come.
struct MeshDescription {
  std::string name;
  UploadFormat format = UploadFormat::kObj;
  std::string layout;  // for RAW its RawLayout as bytes; else empty
  std::string owner;   // name of the caller's token, empty without tokens
  std::map<std::string, std::string> labels;
  MeshUnits units;  // as announced; for a GLB the rest is glTF's
};

struct StoredMesh : MeshDescription {
  std::string id;  // SHA-256 of `bytes`, 64 lower-case hex digits
  std::shared_ptr<const PolygonMesh> mesh;
  Bounds bounds;                             // of mesh
  std::shared_ptr<const std::string> bytes;  // the upload as it came
  absl::Time create_time;                    // set by MeshStore::Add
  MemoryReservation memory;                  // MemoryBytes(), by MeshStore::Add

  // What the budget counts: the upload and its mesh.
  uint64_t MemoryBytes() const { return bytes->size() + mesh->MemoryBytes(); }
};

class MeshStore {
 public:
  // What a store keeps of a mesh beside its bytes.
  using HeaderOf = std::function<std::string(const StoredMesh&)>;
  // `store` may be null, else it outlives this.
  explicit MeshStore(Store* store = nullptr, HeaderOf header_of = nullptr)
      : store_(store), header_of_(std::move(header_of)) {}

  // Keeps `mesh`, durably where there is a store, and sets its create time. The upload's reservation becomes
  // the mesh's. The same bytes twice are one mesh, which keeps the name, labels and units of the first upload;
  // in another format or layout they are kAlreadyExists. kResourceExhausted with asked and free bytes; the
  // store's errors.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const StoredMesh>> Add(
      StoredMesh mesh, MemoryReservation reservation);
  // Keeps a mesh that comes from the store. kResourceExhausted.
  [[nodiscard]] absl::Status Restore(StoredMesh mesh, MemoryReservation reservation);

  // kNotFound.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const StoredMesh>> Find(std::string_view id) const;

  // In order of id.
  [[nodiscard]] std::vector<std::shared_ptr<const StoredMesh>> All() const;

  // kNotFound; the store's errors, and then the mesh stays.
  [[nodiscard]] absl::Status Remove(std::string_view id);

  size_t size() const;

 private:
  Store* const store_;
  const HeaderOf header_of_;
  Mutex
      store_mutex_;  // held while a mesh comes or goes, so that map and store agree; comes before mutex_
  mutable Mutex mutex_;
  std::map<std::string, std::shared_ptr<const StoredMesh>, std::less<>> meshes_
      ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORES_MESH_STORE_H_
