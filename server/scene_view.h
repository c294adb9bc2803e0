// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view of a scene: the one evaluation and the one encoding that all watchers of a key share.
//
//   MarkDirty* (edits) -> Begin (a worker takes the united dirty set) -> ViewWork::Run -> Publish
//
// At most one ViewWork of a view is out at a time; edits meanwhile gather for the next. The update
// before is being sent meanwhile. A view that nobody watches is never begun, but remembers what is
// dirty. A chunk whose new bytes equal the old ones keeps its version.
//
// Threads  safe; the DeformView is used by the one ViewWork that is out, with no lock held
#ifndef LATTICED_SERVER_SCENE_VIEW_H_
#define LATTICED_SERVER_SCENE_VIEW_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/backend.h"
#include "server/memory_budget.h"
#include "server/mutex.h"
#include "server/snapshot.h"

namespace latticed {

struct SceneState;  // server/scene.h
class SceneView;

// One evaluation and encoding of a view, taken from a consistent state.
struct ViewWork {
  std::shared_ptr<SceneView> view;
  std::shared_ptr<const SceneState> state;
  std::vector<uint32_t> chunks;  // dirty, ascending; may be empty
};

class SceneView {
 public:
  // What its evaluation needs is asked of `memory` first; null: no limit.
  SceneView(const ViewKey& key, std::shared_ptr<MemoryBudget> memory)
      : key_(key), memory_(std::move(memory)) {}

  const ViewKey& key() const { return key_; }

  // Watchers that want updates now; paused ones do not count.
  void AddActive() ABSL_LOCKS_EXCLUDED(mutex_);
  void RemoveActive() ABSL_LOCKS_EXCLUDED(mutex_);
  bool watched() const { return active_.load() > 0; }
  absl::Time last_watched() const ABSL_LOCKS_EXCLUDED(mutex_);

  // Marks chunks for the next evaluation; all of them after a change of structure or box.
  void MarkDirty(const std::vector<uint32_t>& chunks) ABSL_LOCKS_EXCLUDED(mutex_);
  void MarkAllDirty() ABSL_LOCKS_EXCLUDED(mutex_);

  // Takes what is dirty for an evaluation of `state`; nullopt while one is out, when nobody
  // watches, when the view is at the state, while no watcher has taken the newest snapshot
  // (evaluating ahead of slow readers would be waste), or after a failure.
  [[nodiscard]] std::optional<ViewWork> Begin(std::shared_ptr<SceneView> self,
                                              std::shared_ptr<const SceneState> state)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Evaluates, encodes and publishes, holding no lock meanwhile. Stops early when the last watcher
  // leaves. Once for each Begin.
  void Run(const ViewWork& work) ABSL_LOCKS_EXCLUDED(mutex_);

  // The newest snapshot, pinned; null while it is below `at_least` or there is none. The caller
  // tells the scene (RequestWork) afterwards: now a newer one is worth evaluating.
  [[nodiscard]] std::shared_ptr<const Snapshot> PinNewest(uint64_t at_least)
      ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] std::shared_ptr<const Snapshot> newest() const ABSL_LOCKS_EXCLUDED(mutex_);
  void Unpin(uint64_t number) ABSL_LOCKS_EXCLUDED(mutex_);
  // Null when it was retired.
  [[nodiscard]] std::shared_ptr<const Snapshot> Find(uint64_t number) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Why the view cannot be evaluated any more; its watchers end with it.
  [[nodiscard]] absl::Status failure() const ABSL_LOCKS_EXCLUDED(mutex_);

  // Evaluations begun so far.
  [[nodiscard]] uint64_t evaluations() const { return evaluations_.load(); }
  [[nodiscard]] MemoryUse memory() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  absl::StatusOr<std::shared_ptr<Snapshot>> Compute(const ViewWork& work, const Snapshot* before);
  // Makes deform_view_ for the state's structure, where it is not that already.
  absl::Status Prepare(const SceneState& state);
  absl::Status Encode(const ViewWork& work, const Snapshot* before, Snapshot& snapshot);
  void MarkAgain(const ViewWork& work) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const ViewKey key_;
  const std::shared_ptr<MemoryBudget> memory_;
  std::atomic<int> active_ = 0;
  std::atomic<uint64_t> evaluations_ = 0;

  // Used by the ViewWork that is out (busy_).
  MemoryReservation reservation_;
  std::unique_ptr<DeformView> deform_view_;
  uint64_t deform_view_structure_ = 0;

  mutable Mutex mutex_;
  bool busy_ ABSL_GUARDED_BY(mutex_) = false;
  bool newest_taken_ ABSL_GUARDED_BY(mutex_) = true;
  bool all_dirty_ ABSL_GUARDED_BY(mutex_) = true;
  std::vector<bool> dirty_ ABSL_GUARDED_BY(mutex_);
  uint64_t next_number_ ABSL_GUARDED_BY(mutex_) = 1;
  SnapshotRing ring_ ABSL_GUARDED_BY(mutex_);
  MemoryUse deform_memory_ ABSL_GUARDED_BY(mutex_);
  absl::Status failure_ ABSL_GUARDED_BY(mutex_);
  absl::Time last_watched_ ABSL_GUARDED_BY(mutex_) = absl::Now();
};

}  // namespace latticed

#endif  // LATTICED_SERVER_SCENE_VIEW_H_
