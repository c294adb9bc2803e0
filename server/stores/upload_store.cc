// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/stores/upload_store.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"
#include "server/base/random_id.h"

namespace latticed {
namespace {

absl::Status SizeMismatch(uint64_t got, uint64_t announced) {
  return error::InvalidField(
      "data", fmt::format("received {} bytes, header.total_bytes is {}", got, announced),
      "SIZE_MISMATCH");
}

absl::Status Expired() {
  return error::WithDetails(
      absl::NotFoundError(fmt::format("the upload was dropped, because no data came for {} seconds",
                                      limits::kUploadIdleSeconds)),
      {.reason = "NOT_FOUND"});
}

}  // namespace

Upload::Upload(UploadHeader header, MemoryReservation reservation, Clock clock)
    : clock_(std::move(clock)),
      account_(reservation.account()),
      last_use_ns_(absl::ToUnixNanos(clock_())),
      header_(std::move(header)),
      reservation_(std::move(reservation)) {}

bool Upload::IsIdle() const {
  return clock_() - absl::FromUnixNanos(last_use_ns_) >= absl::Seconds(limits::kUploadIdleSeconds);
}

bool Upload::Expire() {
  if (!mutex_.TryLock()) return false;
  expired_ = true;
  std::string().swap(bytes_);  // clear() would keep the memory
  reservation_ = {};
  mutex_.Unlock();
  return true;
}

absl::Status Upload::AppendLocked(std::string_view data) {
  if (expired_) return Expired();
  if (data.empty() || data.size() > limits::kMaxPartBytes) {
    return error::OutOfRange("data", static_cast<double>(data.size()), 1, limits::kMaxPartBytes);
  }
  const uint64_t committed = bytes_.size() + data.size();
  if (committed > header_.total_bytes) return SizeMismatch(committed, header_.total_bytes);
  LATTICED_RETURN_IF_ERROR(reservation_.Resize("the upload", committed));
  // Addresses for all bytes, so that none are copied later. Pages take memory when they are written.
  if (bytes_.empty()) bytes_.reserve(header_.total_bytes);
  bytes_.append(data);
  Touch();
  return absl::OkStatus();
}

absl::Status Upload::Append(std::string_view data) {
  const MutexLock lock(&mutex_);
  return AppendLocked(data);
}

absl::StatusOr<uint64_t> Upload::AppendAt(uint64_t offset, std::string_view data) {
  const MutexLock lock(&mutex_);
  const uint64_t committed = bytes_.size();
  if (data.empty()) return committed;
  const bool came_before = offset < committed && data.size() <= committed - offset;
  if (came_before) return committed;
  if (offset != committed) {
    return error::WithDetails(
        absl::FailedPreconditionError(fmt::format(
            "offset: got {}, {} bytes are committed; go on from there", offset, committed)),
        {.reason = "OFFSET_MISMATCH",
         .field = "offset",
         .metadata = {{"committed", fmt::format("{}", committed)}}});
  }
  LATTICED_RETURN_IF_ERROR(AppendLocked(data));
  return bytes_.size();
}

absl::Status Upload::CheckCompleteLocked() const {
  if (expired_) return Expired();
  if (bytes_.size() == header_.total_bytes) return absl::OkStatus();
  return SizeMismatch(bytes_.size(), header_.total_bytes);
}

absl::Status Upload::CheckComplete() const {
  const MutexLock lock(&mutex_);
  return CheckCompleteLocked();
}

absl::StatusOr<CompleteUpload> Upload::Take() {
  const MutexLock lock(&mutex_);
  LATTICED_RETURN_IF_ERROR(CheckCompleteLocked());
  return CompleteUpload{
      .header = std::move(header_),
      .bytes = std::make_shared<const std::string>(std::exchange(bytes_, {})),
      .reservation = std::move(reservation_),
  };
}

absl::StatusOr<std::shared_ptr<Upload>> UploadStore::Admit(UploadHeader header,
                                                           const CallerAccount& caller) {
  const MutexLock lock(&mutex_);
  DropExpiredLocked();
  if (live_.size() >= limits::kMaxUploads) {
    return error::LimitExceeded("uploads at a time", limits::kMaxUploads);
  }
  const size_t share = caller.ShareOf(limits::kMaxUploads);
  const auto of_caller = std::ranges::count_if(live_, [&](const std::weak_ptr<Upload>& weak) {
    const std::shared_ptr<Upload> upload = weak.lock();
    return upload != nullptr && upload->account() == caller.memory;
  });
  if (static_cast<size_t>(of_caller) >= share) {
    return error::LimitExceeded("uploads at a time for one caller", share);
  }
  const uint64_t most = std::min(memory_->total_bytes(), caller.memory->most_bytes());
  if (header.total_bytes > most) return error::OutOfMemory("the upload", header.total_bytes, most);
  LATTICED_ASSIGN_OR_RETURN(MemoryReservation reservation,
                            memory_->Reserve("the upload", 0, caller.memory));
  auto upload = std::make_shared<Upload>(std::move(header), std::move(reservation), clock_);
  live_.push_back(upload);
  return upload;
}

size_t UploadStore::size() const {
  const MutexLock lock(&mutex_);
  return static_cast<size_t>(
      std::ranges::count_if(live_, [](const auto& upload) { return !upload.expired(); }));
}

std::string UploadStore::Keep(std::shared_ptr<Upload> upload, std::string_view tenant) {
  std::string id = NewRandomId();
  const MutexLock lock(&mutex_);
  kept_[TenantKey(tenant, id)] = std::move(upload);
  return id;
}

absl::StatusOr<std::shared_ptr<Upload>> UploadStore::Find(std::string_view key) {
  const MutexLock lock(&mutex_);
  DropExpiredLocked();
  const auto found = kept_.find(key);
  if (found == kept_.end()) return error::NotFound("upload", IdOf(key));
  found->second->Touch();
  return found->second;
}

absl::StatusOr<std::shared_ptr<Upload>> UploadStore::Take(std::string_view key) {
  const MutexLock lock(&mutex_);
  DropExpiredLocked();
  const auto found = kept_.find(key);
  if (found == kept_.end()) return error::NotFound("upload", IdOf(key));
  LATTICED_RETURN_IF_ERROR(found->second->CheckComplete());
  std::shared_ptr<Upload> upload = std::move(found->second);
  kept_.erase(found);
  return upload;
}

void UploadStore::DropExpired() {
  const MutexLock lock(&mutex_);
  DropExpiredLocked();
}

void UploadStore::DropExpiredLocked() {
  std::erase_if(kept_, [](const auto& entry) { return entry.second->IsIdle(); });
  std::erase_if(live_, [](const std::weak_ptr<Upload>& live) {
    const std::shared_ptr<Upload> upload = live.lock();
    return upload == nullptr || (upload->IsIdle() && upload->Expire());
  });
}

}  // namespace latticed
