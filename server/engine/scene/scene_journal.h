// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What one scene writes to its store. Without a store a scene lives in memory alone, and nothing here does anything.
//
//   Admit    before a batch is applied: what was applied cannot be taken back
//   Append   after it, with the record of the batch; what the batch did is published in `then`, when it is durable
//   Wait     the same for an answer that has no record but must not overtake those before it
//
// An append that fails breaks the journal. What was applied since is then lost: the scene goes on from what Read
// returns, once no append is under way.
//
// Threads  is_broken and is_idle are safe; the rest one at a time
#ifndef LATTICED_SERVER_ENGINE_SCENE_SCENE_JOURNAL_H_
#define LATTICED_SERVER_ENGINE_SCENE_SCENE_JOURNAL_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/store/records/scene_codec.h"
#include "server/store/store.h"

namespace latticed {

class SceneJournal {
 public:
  // Called on a thread of the store with none of its locks held, in the order of Append and Wait. If it throws for want
  // of memory, the journal is broken, and it is called again with kAborted: its scene may not show what is stored.
  using Then = std::function<void(const absl::Status&)>;

  // `store` may be null, else it outlives the scene. `unsnapped` records have come since its last snapshot.
  SceneJournal(Store* store, std::string scene, uint64_t unsnapped)
      : store_(store), scene_(std::move(scene)), records_(unsnapped) {}

  // Held while a batch is applied. If that ends before the batch is appended, for want of memory, what is applied and what
  // is stored differ: the journal is broken.
  class Attempt {
   public:
    explicit Attempt(SceneJournal& journal) : journal_(&journal) {}
    ~Attempt() {
      if (journal_ != nullptr) journal_->state_->broken = journal_->durable();
    }
    Attempt(const Attempt&) = delete;
    Attempt& operator=(const Attempt&) = delete;
    void Done() { journal_ = nullptr; }

   private:
    SceneJournal* journal_;
  };

  bool durable() const { return store_ != nullptr; }
  // Why no batch may be applied now: the store's Admit, or kUnavailable, reason STORE, while the journal is broken.
  [[nodiscard]] absl::Status Admit() const;
  // Only if durable().
  void Append(uint64_t lsn, const SceneRecord& record, Then then);
  void Wait(Then then);
  // Whether a snapshot should follow, and there is room for it. It bounds what is replayed when the scene is made again:
  // to about 4,096 records, or 4 MiB of them.
  bool WantsSnapshot() const {
    return (records_ >= kMostRecords || bytes_ >= kMostBytes) && store_->Admit().ok();
  }
  // A snapshot that stands for all records up to `lsn`, the last one.
  void PutSnapshot(uint64_t lsn, const SceneImage& image);
  bool is_broken() const { return state_->broken; }
  // Whether everything was answered.
  bool is_idle() const { return state_->pending == 0; }
  // What the store has of the scene. The store's errors.
  [[nodiscard]] absl::StatusOr<SceneLog> Read() const { return store_->ReadScene(scene_); }
  // The scene goes on from what Read returned.
  void Mend() { state_->broken = false; }

 private:
  // Answers may outlive the scene.
  struct State {
    std::atomic<uint64_t> pending = 0;
    std::atomic<bool> broken = false;
  };

  static constexpr uint64_t kMostRecords = 4'096;
  static constexpr uint64_t kMostBytes = uint64_t{4} << 20;

  void Post(uint64_t lsn, std::string record, Then then);

  Store* const store_;
  const std::string scene_;
  uint64_t records_;  // since the last snapshot
  uint64_t bytes_ = 0;
  const std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_SCENE_JOURNAL_H_
