// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/memory_store.h"

#include <cstddef>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/base/telemetry.h"
#include "server/store/store_errors.h"

namespace latticed {

MemoryStore::MemoryStore() : thread_([this] { Run(); }) {}

MemoryStore::~MemoryStore() {
  {
    MutexLock lock(&mutex_);
    stopping_ = true;
    paused_ = false;
  }
  thread_.join();
}

void MemoryStore::Post(Work work) {
  MutexLock lock(&mutex_);
  waiting_bytes_ += work.bytes;
  counts_.waiting_bytes = waiting_bytes_;
  ++counts_.waiting_writes;
  waiting_.push_back(std::move(work));
}

absl::Status MemoryStore::Call(std::function<absl::Status()> apply) {
  std::optional<absl::Status> answer;
  Post({.apply = std::move(apply), .done = [&](const absl::Status& status) {
          MutexLock lock(&mutex_);
          answer = status;
        }});
  MutexLock lock(&mutex_);
  mutex_.Await([&] { return answer.has_value(); });
  return *answer;
}

void MemoryStore::Run() {
  while (true) {
    Work work;
    absl::Status answer;
    {
      MutexLock lock(&mutex_);
      mutex_.Await([this] { return (!waiting_.empty() && !paused_) || stopping_; });
      if (waiting_.empty()) return;
      work = std::move(waiting_.front());
      waiting_.pop_front();
      answer = work.apply();
    }
    if (work.done) work.done(answer);
    MutexLock lock(&mutex_);
    waiting_bytes_ -= work.bytes;
    counts_.waiting_bytes = waiting_bytes_;
    --counts_.waiting_writes;
  }
}

// The thread holds the lock while it applies work, which the annotations of lambdas cannot say.
absl::Status MemoryStore::CreateScene(std::string_view id, std::string header) {
  return CreateSceneAt(id, std::move(header), 0, "");
}

absl::Status MemoryStore::CreateSceneAt(std::string_view id, std::string header, uint64_t lsn,
                                        std::string snapshot) {
  return Call([&]() ABSL_NO_THREAD_SAFETY_ANALYSIS -> absl::Status {
    LATTICED_RETURN_IF_ERROR(failure_);
    if (scenes_.contains(id)) return error::AlreadyExists("scene", id);
    scenes_[std::string(id)].log = {std::move(header), lsn, std::move(snapshot), {}};
    return absl::OkStatus();
  });
}

absl::Status MemoryStore::DeleteScene(std::string_view id) {
  return Call([&]() ABSL_NO_THREAD_SAFETY_ANALYSIS -> absl::Status {
    LATTICED_RETURN_IF_ERROR(failure_);
    const auto found = scenes_.find(id);
    if (found == scenes_.end()) return error::NotFound("scene", id);
    scenes_.erase(found);
    std::erase_if(shares_, [id](const auto& share) { return share.second.scene == id; });
    return absl::OkStatus();
  });
}

absl::StatusOr<std::vector<StoredEntry>> MemoryStore::Scenes() {
  MutexLock lock(&mutex_);
  std::vector<StoredEntry> entries;
  for (const auto& [id, scene] : scenes_) entries.push_back({id, scene.log.header, {}});
  return entries;
}

absl::StatusOr<std::string> MemoryStore::ReadSceneHeader(std::string_view id) {
  MutexLock lock(&mutex_);
  const auto found = scenes_.find(id);
  if (found == scenes_.end()) return error::NotFound("scene", id);
  return found->second.log.header;
}

absl::StatusOr<SceneLog> MemoryStore::ReadScene(std::string_view id) {
  SceneLog log;
  LATTICED_RETURN_IF_ERROR(Call([&]() ABSL_NO_THREAD_SAFETY_ANALYSIS -> absl::Status {
    const auto found = scenes_.find(id);
    if (found == scenes_.end()) return error::NotFound("scene", id);
    found->second.broken = absl::OkStatus();
    log = found->second.log;
    return absl::OkStatus();
  }));
  return log;
}

absl::StatusOr<SceneLog> MemoryStore::CopyScene(std::string_view id) {
  MutexLock lock(&mutex_);
  const auto found = scenes_.find(id);
  if (found == scenes_.end()) return error::NotFound("scene", id);
  return found->second.log;
}

void MemoryStore::Append(std::string_view scene, uint64_t lsn, std::string record, Done done) {
  const uint64_t bytes = record.size();
  Post({.apply =
            [this, id = std::string(scene), lsn, record = std::move(record)]() mutable {
              absl::Status status = ApplyAppend(id, lsn, std::move(record));
              if (!status.ok() && lsn != 0) ++counts_.appends_refused;
              return status;
            },
        .done = std::move(done),
        .bytes = bytes});
}

absl::Status MemoryStore::ApplyAppend(const std::string& id, uint64_t lsn, std::string record) {
  const auto found = scenes_.find(id);
  if (found == scenes_.end()) return error::NotFound("scene", id);
  Scene& scene = found->second;
  LATTICED_RETURN_IF_ERROR(scene.broken);
  if (lsn == 0) return absl::OkStatus();
  const uint64_t next = scene.log.lsn() + 1;
  scene.broken = lsn == next ? failure_ : error::NotNextRecord(id, next, lsn);
  if (!scene.broken.ok()) ++counts_.scenes_broken;
  LATTICED_RETURN_IF_ERROR(scene.broken);
  counts_.append_bytes += record.size();
  ++counts_.appends_stored;
  scene.log.records.push_back(std::move(record));
  return absl::OkStatus();
}

absl::Status MemoryStore::Admit() {
  MutexLock lock(&mutex_);
  LATTICED_RETURN_IF_ERROR(failure_);
  if (waiting_bytes_ > kMostWaitingBytes)
    return error::StoreBusy(waiting_bytes_, kMostWaitingBytes);
  return absl::OkStatus();
}

void MemoryStore::PutSnapshot(std::string_view scene, uint64_t lsn, std::string snapshot) {
  const uint64_t bytes = snapshot.size();
  Post({.apply =
            [this, id = std::string(scene), lsn, snapshot = std::move(snapshot)]() mutable {
              return ApplySnapshot(id, lsn, std::move(snapshot));
            },
        .done =
            [id = std::string(scene)](const absl::Status& status) {
              if (status.ok()) return;
              LogEvent(spdlog::level::warn, "snapshot not stored",
                       {{"scene", id}, {"error", std::string(status.message())}});
            },
        .bytes = bytes});
}

absl::Status MemoryStore::ApplySnapshot(const std::string& id, uint64_t lsn, std::string snapshot) {
  LATTICED_RETURN_IF_ERROR(failure_);
  const auto found = scenes_.find(id);
  if (found == scenes_.end()) return error::NotFound("scene", id);
  SceneLog& log = found->second.log;
  if (lsn <= log.snapshot_lsn || lsn > log.lsn()) {
    return error::NotNextRecord(id, log.lsn(), lsn);
  }
  const auto covered = static_cast<ptrdiff_t>(lsn - log.snapshot_lsn);
  log.records.erase(log.records.begin(), log.records.begin() + covered);
  ++counts_.snapshots_stored;
  counts_.snapshot_bytes += snapshot.size();
  log.snapshot_lsn = lsn;
  log.snapshot = std::move(snapshot);
  return absl::OkStatus();
}

void MemoryStore::Flush() {
  Call([] { return absl::OkStatus(); }).IgnoreError();  // it is OK
}

absl::Status MemoryStore::PutMesh(std::string_view id, std::string header, std::string_view bytes) {
  MutexLock lock(&mutex_);
  LATTICED_RETURN_IF_ERROR(failure_);
  meshes_.try_emplace(std::string(id), Mesh{std::move(header), std::string(bytes)});
  return absl::OkStatus();
}

absl::Status MemoryStore::DeleteMesh(std::string_view id) {
  MutexLock lock(&mutex_);
  LATTICED_RETURN_IF_ERROR(failure_);
  const auto found = meshes_.find(id);
  if (found == meshes_.end()) return error::NotFound("mesh", id);
  meshes_.erase(found);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<StoredEntry>> MemoryStore::Meshes() {
  MutexLock lock(&mutex_);
  std::vector<StoredEntry> entries;
  for (const auto& [id, mesh] : meshes_) entries.push_back({id, mesh.header, {}});
  return entries;
}

absl::StatusOr<std::string> MemoryStore::ReadMeshHeader(std::string_view id) {
  MutexLock lock(&mutex_);
  const auto found = meshes_.find(id);
  if (found == meshes_.end()) return error::NotFound("mesh", id);
  return found->second.header;
}

absl::StatusOr<std::string> MemoryStore::ReadMesh(std::string_view id) {
  MutexLock lock(&mutex_);
  const auto found = meshes_.find(id);
  if (found == meshes_.end()) return error::NotFound("mesh", id);
  return found->second.bytes;
}

absl::Status MemoryStore::PutShare(std::string_view id, std::string_view scene,
                                   std::string header) {
  MutexLock lock(&mutex_);
  LATTICED_RETURN_IF_ERROR(failure_);
  if (!scenes_.contains(scene)) return error::NotFound("scene", scene);
  shares_[std::string(id)] = {std::string(scene), std::move(header)};
  return absl::OkStatus();
}

absl::Status MemoryStore::DeleteShare(std::string_view id) {
  MutexLock lock(&mutex_);
  LATTICED_RETURN_IF_ERROR(failure_);
  shares_.erase(std::string(id));
  return absl::OkStatus();
}

absl::StatusOr<std::vector<StoredEntry>> MemoryStore::Shares() {
  MutexLock lock(&mutex_);
  std::vector<StoredEntry> entries;
  for (const auto& [id, share] : shares_) entries.push_back({id, share.header, {}});
  return entries;
}

void MemoryStore::SetFailure(absl::Status failure) {
  MutexLock lock(&mutex_);
  if (failure_.ok() && !failure.ok()) ++counts_.failures;
  counts_.writable = failure.ok();
  failure_ = std::move(failure);
}

void MemoryStore::Pause() {
  MutexLock lock(&mutex_);
  paused_ = true;
}

void MemoryStore::Resume() {
  MutexLock lock(&mutex_);
  paused_ = false;
}

}  // namespace latticed
