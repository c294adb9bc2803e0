// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A store that keeps everything in memory: it ends with the process. It is what tests of the engine use, and the model
// that other stores are compared with.
//
// Threads  safe. One thread of its own applies and answers appends, in the order of the calls
#ifndef LATTICED_SERVER_STORE_MEMORY_STORE_H_
#define LATTICED_SERVER_STORE_MEMORY_STORE_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "server/store/store.h"

namespace latticed {

class MemoryStore : public Store {
 public:
  static constexpr uint64_t kMostWaitingBytes = uint64_t{64} << 20;

  MemoryStore();
  // Answers what waits.
  ~MemoryStore() override;

  absl::Status CreateScene(std::string_view id, std::string header) override;
  absl::Status CreateSceneAt(std::string_view id, std::string header, uint64_t lsn,
                             std::string snapshot) override;
  absl::Status DeleteScene(std::string_view id) override;
  absl::StatusOr<std::vector<StoredEntry>> Scenes() override;
  absl::StatusOr<std::string> ReadSceneHeader(std::string_view id) override;
  absl::StatusOr<SceneLog> ReadScene(std::string_view id) override;
  absl::StatusOr<SceneLog> CopyScene(std::string_view id) override;
  void Append(std::string_view scene, uint64_t lsn, std::string record, Done done) override;
  absl::Status Admit() override;
  void PutSnapshot(std::string_view scene, uint64_t lsn, std::string snapshot) override;
  void Flush() override;
  absl::Status PutMesh(std::string_view id, std::string header, std::string_view bytes) override;
  absl::Status DeleteMesh(std::string_view id) override;
  absl::StatusOr<std::vector<StoredEntry>> Meshes() override;
  absl::StatusOr<std::string> ReadMeshHeader(std::string_view id) override;
  absl::StatusOr<std::string> ReadMesh(std::string_view id) override;
  absl::Status PutShare(std::string_view id, std::string_view scene, std::string header) override;
  absl::Status DeleteShare(std::string_view id) override;
  absl::StatusOr<std::vector<StoredEntry>> Shares() override;

  // For tests. As a medium that fails: every write is refused with `failure` until OK is set.
  void SetFailure(absl::Status failure) ABSL_LOCKS_EXCLUDED(mutex_);
  // For tests. As a slow medium: nothing that waits is applied until Resume.
  void Pause() ABSL_LOCKS_EXCLUDED(mutex_);
  void Resume() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Scene {
    SceneLog log;
    absl::Status broken;
  };
  struct Mesh {
    std::string header;
    std::string bytes;
  };
  struct Share {
    std::string scene;
    std::string header;
  };
  // What the thread does in its turn, and whom it answers then.
  struct Work {
    std::function<absl::Status()> apply;
    Done done;  // may be null
    uint64_t bytes = 0;
  };

  void Post(Work work) ABSL_LOCKS_EXCLUDED(mutex_);
  // Posts, and waits for the answer.
  absl::Status Call(std::function<absl::Status()> apply) ABSL_LOCKS_EXCLUDED(mutex_);
  void Run() ABSL_LOCKS_EXCLUDED(mutex_);
  // Within the lock, which the thread holds.
  absl::Status ApplyAppend(const std::string& id, uint64_t lsn,
                           std::string record) ABSL_NO_THREAD_SAFETY_ANALYSIS;
  absl::Status ApplySnapshot(const std::string& id, uint64_t lsn,
                             std::string snapshot) ABSL_NO_THREAD_SAFETY_ANALYSIS;

  Mutex mutex_;
  std::map<std::string, Scene, std::less<>> scenes_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, Mesh, std::less<>> meshes_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, Share, std::less<>> shares_ ABSL_GUARDED_BY(mutex_);
  std::deque<Work> waiting_ ABSL_GUARDED_BY(mutex_);
  uint64_t waiting_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status failure_ ABSL_GUARDED_BY(mutex_);
  bool paused_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;  // last: it uses the rest
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_MEMORY_STORE_H_
