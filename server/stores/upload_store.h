// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Uploads under way: the bytes of a mesh as they come, from the header that admits them to the
// stored mesh. A stream holds its Upload itself; unary uploads are kept by id in the UploadStore. One
// that got no bytes for limits::kUploadIdleSeconds is dropped: its memory and place are others' then.
//
// Errors   those of MeshService.UploadMesh (mesh.proto)
// Threads  safe; an Upload's appends are serialised by its lock
#ifndef LATTICED_SERVER_STORES_UPLOAD_STORE_H_
#define LATTICED_SERVER_STORES_UPLOAD_STORE_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/base/limits.h"
#include "latticed/v1/mesh.pb.h"
#include "server/stores/mesh_store.h"

namespace latticed {

class Upload {
 public:
  using Clock = std::function<absl::Time()>;
  Upload(v1::MeshHeader header, std::string owner, MemoryReservation reservation, Clock clock);

  // Puts off its end, as what adds bytes does.
  void Touch() { last_use_ns_ = absl::ToUnixNanos(clock_()); }
  [[nodiscard]] bool IsIdle() const;
  // Whether it is dropped, which it is not while it is in use: its memory is given back, and who goes
  // on with it hears kNotFound.
  bool Expire() ABSL_LOCKS_EXCLUDED(mutex_);

  // Adds the next bytes: 1 to limits::kMaxPartBytes, and no more in all than announced.
  [[nodiscard]] absl::Status Append(std::string_view data) ABSL_LOCKS_EXCLUDED(mutex_);
  // The same for bytes that begin at `offset`; those that came before are ignored, and no bytes ask
  // only for the answer: how many are committed.
  [[nodiscard]] absl::StatusOr<uint64_t> AppendAt(uint64_t offset, std::string_view data)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // kInvalidArgument, reason SIZE_MISMATCH, while bytes are missing.
  [[nodiscard]] absl::Status CheckComplete() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Verifies, parses and stores: seconds for large files, so not on a gRPC thread. Call once.
  // kCancelled where `cancelled` says so between its steps. `admit` is asked before the mesh is stored,
  // and what it refuses is not.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const StoredMesh>> Finish(
      MeshStore& store, const std::function<bool()>& cancelled,
      const std::function<absl::Status(const StoredMesh&)>& admit) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  absl::Status AppendLocked(std::string_view data) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status CheckCompleteLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const v1::MeshHeader header_;
  const std::string owner_;
  const Clock clock_;
  std::atomic<int64_t> last_use_ns_;
  mutable absl::Mutex mutex_;
  bool expired_ ABSL_GUARDED_BY(mutex_) = false;
  MemoryReservation reservation_ ABSL_GUARDED_BY(mutex_);
  std::string bytes_ ABSL_GUARDED_BY(mutex_);
};

class UploadStore {
 public:
  UploadStore(MeshStore* meshes, uint64_t max_mesh_bytes, Upload::Clock clock = absl::Now)
      : meshes_(meshes), max_mesh_bytes_(max_mesh_bytes), clock_(std::move(clock)) {}

  // Decides from the header alone. Also drops what has expired.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<Upload>> Admit(const v1::MeshHeader& header,
                                                              const std::string& owner)
      ABSL_LOCKS_EXCLUDED(mutex_);

  // Keeps an upload under a new, unguessable id.
  [[nodiscard]] std::string Keep(std::shared_ptr<Upload> upload) ABSL_LOCKS_EXCLUDED(mutex_);
  // Also puts off its expiry. kNotFound.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<Upload>> Find(std::string_view id)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Takes a complete upload out. kNotFound; CheckComplete's, and then it stays.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<Upload>> Take(std::string_view id)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Gives back the memory of uploads that are idle, streams' as well; the calls above do so too.
  void DropExpired() ABSL_LOCKS_EXCLUDED(mutex_);
  // Under way, those of streams as well.
  [[nodiscard]] size_t size() const ABSL_LOCKS_EXCLUDED(mutex_);
  // When an upload that was just used will expire.
  [[nodiscard]] absl::Time ExpireTime() const {
    return clock_() + absl::Seconds(limits::kUploadIdleSeconds);
  }

 private:
  void DropExpiredLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  MeshStore* const meshes_;
  const uint64_t max_mesh_bytes_;
  const Upload::Clock clock_;
  mutable absl::Mutex mutex_;
  std::map<std::string, std::shared_ptr<Upload>, std::less<>> kept_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::weak_ptr<Upload>> live_ ABSL_GUARDED_BY(mutex_);  // streams' as well
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORES_UPLOAD_STORE_H_
