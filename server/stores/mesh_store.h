// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Uploaded meshes by id, within the memory budget, and in the server's store if it has one. A mesh in use stays
// alive through its shared_ptr after Remove, and counts against the budget as long. A mesh of the store is read when
// it is needed, and leaves memory when nobody has used it for a while.
//
// Threads  safe; no lock is held while a mesh is read, parsed, hashed or destroyed
#ifndef LATTICED_SERVER_STORES_MESH_STORE_H_
#define LATTICED_SERVER_STORES_MESH_STORE_H_

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
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
  std::string tenant;  // whose mesh it is
  std::map<std::string, std::string> labels;
  MeshUnits units;  // as announced; for a GLB the rest is glTF's
};

struct StoredMesh : MeshDescription {
  // SHA-256 of `bytes`, 64 lower-case hex digits; with its tenant: server/base/auth/tenant.h
  std::string id;
  std::shared_ptr<const PolygonMesh> mesh;
  Bounds bounds;                             // of mesh
  std::shared_ptr<const std::string> bytes;  // the upload as it came
  absl::Time create_time;                    // by MeshStore::Add, unless it is set
  MemoryReservation memory;                  // MemoryBytes(), by MeshStore::Add

  // What the budget counts: the upload and its mesh.
  uint64_t MemoryBytes() const { return bytes->size() + mesh->MemoryBytes(); }
};

// A mesh in a list: in memory, or what the store keeps beside its bytes.
struct ListedMesh {
  std::string id;
  std::string header;                      // empty without a store
  std::shared_ptr<const StoredMesh> mesh;  // null if it is not in memory
};

class MeshStore {
 public:
  // How a store keeps meshes.
  struct Keeping {
    Store* store = nullptr;  // null: meshes end with the server. Else it outlives this
    // What it keeps of a mesh beside its bytes.
    std::function<std::string(const StoredMesh&)> header_of;
    // Reads a mesh from it, within the memory budget. kNotFound, kDataLoss, kResourceExhausted.
    std::function<absl::StatusOr<StoredMesh>(const std::string& id)> read;
  };
  // Bytes of meshes by id.
  using Arriving = std::map<std::string, uint64_t, std::less<>>;
  // Whether a new mesh may be kept. The store may have some of those that arrive already.
  using Admission = std::function<absl::Status(const Arriving&)>;
  explicit MeshStore(Keeping keeping) : keeping_(std::move(keeping)) {}

  // Keeps `mesh`, durably where there is a store, and sets its create time if that is not set. The upload's reservation becomes
  // the mesh's. The same bytes twice are one mesh, which keeps the name, labels and units of the first upload;
  // in another format or layout they are kAlreadyExists. kResourceExhausted with asked and free bytes; the
  // store's errors. `admit`, if given, is asked before a mesh that is new is kept, about one mesh at a time.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const StoredMesh>> Add(
      StoredMesh mesh, MemoryReservation reservation, const Admission& admit = nullptr);

  // Reads it from the store if it is not in memory, which may take seconds. kNotFound; kDataLoss naming it;
  // kResourceExhausted; the store's errors.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const StoredMesh>> Find(std::string_view id);
  // Whether Find may have to wait for the store.
  [[nodiscard]] bool IsAsleep(std::string_view id) const;
  // Null if it is not in memory.
  [[nodiscard]] std::shared_ptr<const StoredMesh> InMemory(std::string_view id) const;

  // Those in memory, in order of id.
  [[nodiscard]] std::vector<std::shared_ptr<const StoredMesh>> All() const;
  // All, in order of id. The store's errors.
  [[nodiscard]] absl::StatusOr<std::vector<ListedMesh>> List() const;

  // kNotFound; the store's errors, and then the mesh stays.
  [[nodiscard]] absl::Status Remove(std::string_view id);
  // Takes meshes out of memory that the store has and nobody has used since `time`.
  void DropUnusedSince(absl::Time time);

 private:
  struct Entry {
    std::shared_ptr<const StoredMesh> mesh;
    absl::Time last_use;
  };
  // While a thread reads, puts or deletes a mesh, so that map and store agree. Work on the same mesh waits for its turn.
  class Work {
   public:
    Work(MeshStore* store, std::string id);
    ~Work();
    Work(const Work&) = delete;  // it ends once
    Work& operator=(const Work&) = delete;

   private:
    MeshStore* const store_;
    const std::string id_;
  };
  std::shared_ptr<const StoredMesh> Keep(StoredMesh mesh) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  [[nodiscard]] absl::Status Admit(const StoredMesh& mesh, const Admission& admit);
  // Takes a mesh out of memory that another server has deleted from the store.
  std::shared_ptr<const StoredMesh> TakeDeletedElsewhere(const std::string& id);
  void AwaitFree(const std::string& id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const StoredMesh>> Read(const std::string& id);

  const Keeping keeping_;
  Mutex admission_mutex_;  // two meshes are not admitted for the same bytes; comes before mutex_
  mutable Mutex mutex_;
  std::map<std::string, Entry, std::less<>> meshes_ ABSL_GUARDED_BY(mutex_);
  std::set<std::string, std::less<>> busy_ ABSL_GUARDED_BY(mutex_);  // ids of all Work
  // Admitted; the store may have them already. All are in busy_.
  Arriving arriving_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORES_MESH_STORE_H_
