// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A store in memory that several servers of one process share: for tests. Each server has a SharedMemoryStore, and all
// of them one SharedMemory. A lease has no clock here: it holds until the test ends it.
//
//   auto memory = std::make_shared<SharedMemory>();
//   SharedMemoryStore first(memory, "host-1:50051"), second(memory, "host-2:50051");
//
// Threads  safe
#ifndef LATTICED_SERVER_STORE_SHARED_MEMORY_STORE_H_
#define LATTICED_SERVER_STORE_SHARED_MEMORY_STORE_H_

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "server/store/memory_store.h"
#include "server/store/store.h"

namespace latticed {

class SharedMemoryStore;

class SharedMemory {
 public:
  // As when a server was silent for longer than its lease: it owns nothing from now on, and is told.
  void Fence(std::string_view server) ABSL_LOCKS_EXCLUDED(mutex_);
  // From now on claims of scenes of `server` wait, as while a lease was not renewed lately; until Fence, or Renew.
  void Silence(std::string_view server) ABSL_LOCKS_EXCLUDED(mutex_);
  void Renew(std::string_view server) ABSL_LOCKS_EXCLUDED(mutex_);

  MemoryStore& all() { return all_; }  // what is stored, and the faults of its medium

 private:
  friend class SharedMemoryStore;

  struct Server {
    uint64_t free_bytes = 0;
    bool silent = false;
    std::function<void()> fenced;
  };
  // Takes the scenes of some owners away.
  void GiveUp(const std::function<bool(const std::string& owner)>& whose)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  Mutex mutex_;
  std::map<std::string, Server, std::less<>> servers_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, std::string, std::less<>> owners_ ABSL_GUARDED_BY(mutex_);   // by scene
  std::map<std::string, absl::Time, std::less<>> given_up_ ABSL_GUARDED_BY(mutex_);  // last
  MemoryStore all_;
};

class SharedMemoryStore : public Store {
 public:
  // Joins as the server `name`, which nobody else has.
  SharedMemoryStore(std::shared_ptr<SharedMemory> memory, std::string name);
  // Answers what waits, and gives up all scenes.
  ~SharedMemoryStore() override;

  absl::Status CreateScene(std::string_view id, std::string header) override;
  absl::Status CreateSceneAt(std::string_view id, std::string header, uint64_t lsn,
                             std::string snapshot) override;
  absl::Status DeleteScene(std::string_view id) override;
  absl::StatusOr<std::vector<StoredEntry>> Scenes() override;
  absl::StatusOr<std::string> ReadSceneHeader(std::string_view id) override {
    return all_.ReadSceneHeader(id);
  }
  absl::StatusOr<SceneLog> ReadScene(std::string_view id) override;
  absl::StatusOr<SceneLog> CopyScene(std::string_view id) override { return all_.CopyScene(id); }
  void Append(std::string_view scene, uint64_t lsn, std::string record, Done done) override;
  absl::Status Admit() override { return all_.Admit(); }
  void PutSnapshot(std::string_view scene, uint64_t lsn, std::string snapshot) override;
  void Flush() override { all_.Flush(); }
  absl::StatusOr<SceneClaim> ClaimScene(std::string_view id) override;
  absl::Status ReleaseScene(std::string_view id) override;
  absl::Status ExpireScene(std::string_view id, absl::Duration unused) override;
  void OnFenced(std::function<void()> fenced) override;
  bool shared() const override { return true; }
  absl::StatusOr<std::vector<StoredServer>> Servers() override;
  void SetFreeBytes(uint64_t bytes) override;
  absl::Status PutMesh(std::string_view id, std::string header, std::string_view bytes) override {
    return all_.PutMesh(id, std::move(header), bytes);
  }
  absl::Status DeleteMesh(std::string_view id) override { return all_.DeleteMesh(id); }
  absl::StatusOr<std::vector<StoredEntry>> Meshes() override { return all_.Meshes(); }
  absl::StatusOr<std::string> ReadMeshHeader(std::string_view id) override {
    return all_.ReadMeshHeader(id);
  }
  absl::StatusOr<std::string> ReadMesh(std::string_view id) override { return all_.ReadMesh(id); }
  absl::Status PutShare(std::string_view id, std::string_view scene, std::string header) override {
    return all_.PutShare(id, scene, std::move(header));
  }
  absl::Status DeleteShare(std::string_view id) override { return all_.DeleteShare(id); }
  absl::StatusOr<std::vector<StoredEntry>> Shares() override { return all_.Shares(); }

 private:
  // kNotFound, kAborted.
  absl::Status CheckOwned(std::string_view scene);
  bool Owns(std::string_view scene) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(memory_->mutex_);

  const std::shared_ptr<SharedMemory> memory_;
  const std::string name_;
  MemoryStore& all_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_SHARED_MEMORY_STORE_H_
