// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Uploads under way: the bytes of a mesh as they come, from the header that admits them until they are
// complete. Memory is reserved for the bytes that have come, not for those that are announced. A stream holds
// its Upload itself; the UploadStore keeps unary uploads by id. An upload that gets no bytes for
// limits::kUploadIdleSeconds is dropped and frees its memory and its place.
//
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
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/base/limits.h"
#include "core/base/mutex.h"
#include "server/stores/callers.h"
#include "server/stores/mesh_store.h"

namespace latticed {

// What a client announces before the bytes.
struct UploadHeader {
  MeshDescription mesh;
  uint64_t total_bytes = 0;
  std::string sha256;  // 64 hex digits; empty: not announced
};

// All bytes of an upload, and the memory that is reserved for them.
struct CompleteUpload {
  UploadHeader header;
  std::shared_ptr<const std::string> bytes;
  MemoryReservation reservation;
};

class Upload {
 public:
  using Clock = std::function<absl::Time()>;
  Upload(UploadHeader header, MemoryReservation reservation, Clock clock);

  // Postpones the expiry, as adding bytes does.
  void Touch() { last_use_ns_ = absl::ToUnixNanos(clock_()); }
  [[nodiscard]] bool IsIdle() const;
  const MemoryAccountPtr& account() const { return account_; }
  // Frees the memory and returns true, unless the upload is in use. Later calls return kNotFound.
  bool Expire() ABSL_LOCKS_EXCLUDED(mutex_);

  // Adds the next bytes: 1 to limits::kMaxPartBytes, and no more in all than announced.
  // kInvalidArgument, reasons OUT_OF_RANGE and SIZE_MISMATCH; kNotFound once expired;
  // kResourceExhausted, reason OUT_OF_MEMORY: the bytes are not added, and may come again.
  [[nodiscard]] absl::Status Append(std::string_view data) ABSL_LOCKS_EXCLUDED(mutex_);
  // Adds bytes that begin at `offset` and returns how many bytes the upload has. Bytes that it has already
  // are ignored; an empty part only asks for the number. Errors of Append; kFailedPrecondition, reason
  // OFFSET_MISMATCH.
  [[nodiscard]] absl::StatusOr<uint64_t> AppendAt(uint64_t offset, std::string_view data)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // kInvalidArgument, reason SIZE_MISMATCH, while bytes are missing; kNotFound once expired.
  [[nodiscard]] absl::Status CheckComplete() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Moves everything out. Call once. CheckComplete's errors.
  [[nodiscard]] absl::StatusOr<CompleteUpload> Take() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  absl::Status AppendLocked(std::string_view data) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status CheckCompleteLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const Clock clock_;
  const MemoryAccountPtr account_;
  std::atomic<int64_t> last_use_ns_;
  mutable Mutex mutex_;
  UploadHeader header_ ABSL_GUARDED_BY(mutex_);
  bool expired_ ABSL_GUARDED_BY(mutex_) = false;
  MemoryReservation reservation_ ABSL_GUARDED_BY(mutex_);
  std::string bytes_ ABSL_GUARDED_BY(mutex_);
};

class UploadStore {
 public:
  explicit UploadStore(std::shared_ptr<MemoryBudget> memory, Upload::Clock clock = absl::Now)
      : memory_(std::move(memory)), clock_(std::move(clock)) {}

  // Admits an upload of `caller`. Also drops what has expired. kResourceExhausted, reason LIMIT_EXCEEDED for one
  // upload too many, OUT_OF_MEMORY for one larger than the caller may ever have. Nothing is reserved or evicted
  // for bytes that are only announced.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<Upload>> Admit(UploadHeader header,
                                                              const CallerAccount& caller)
      ABSL_LOCKS_EXCLUDED(mutex_);

  // Keeps an upload of the tenant under a new, unguessable id. The functions below take its key.
  [[nodiscard]] std::string Keep(std::shared_ptr<Upload> upload, std::string_view tenant = "")
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Also postpones the expiry. kNotFound.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<Upload>> Find(std::string_view key)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Removes a complete upload from the store. kNotFound; CheckComplete's errors, which leave it there.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<Upload>> Take(std::string_view key)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Frees the memory of idle uploads, also of those that streams carry. The calls above do so too.
  void DropExpired() ABSL_LOCKS_EXCLUDED(mutex_);
  // The number of unfinished uploads, with those that streams carry.
  [[nodiscard]] size_t size() const ABSL_LOCKS_EXCLUDED(mutex_);
  // When an upload that is used now will expire.
  [[nodiscard]] absl::Time ExpireTime() const {
    return clock_() + absl::Seconds(limits::kUploadIdleSeconds);
  }

 private:
  void DropExpiredLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::shared_ptr<MemoryBudget> memory_;
  const Upload::Clock clock_;
  mutable Mutex mutex_;
  std::map<std::string, std::shared_ptr<Upload>, std::less<>> kept_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::weak_ptr<Upload>> live_ ABSL_GUARDED_BY(mutex_);  // with those of streams
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORES_UPLOAD_STORE_H_
