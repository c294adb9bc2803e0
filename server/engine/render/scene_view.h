// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view of a scene: the one evaluation and the one encoding that all watchers of a key share.
//
//   MarkDirty* (edits) -> Begin (a worker takes the united dirty set) -> Run: evaluate, encode
//                                                                             -> snapshot
//   slot 0   evaluate k     | encode k       | evaluate k+2 | encode k+2 ...
//   slot 1                  | evaluate k+1   | encode k+1   | evaluate k+3 ...
//   watchers                  k-1              k              k+1
//
// One evaluation and one encoding of a view are out at a time; edits meanwhile gather for the next.
// Where the backend evaluates on a device of its own, the next revision is evaluated while this one
// is encoded: when a watcher waits that has all there is, and not before the encoding nears its end,
// lest it encode what is stale by then. It needs a second slot of vertices; where there is no room
// for that, and on the host's own cores, one revision follows the other in one slot. What fails in
// one of two slots is tried again in the other alone before the view fails.
//
// A view that nobody watches is never begun, but remembers what is dirty.
//
// Threads  safe; a slot is used by the stage whose ViewWork names it, with no lock held
#ifndef LATTICED_SERVER_ENGINE_RENDER_SCENE_VIEW_H_
#define LATTICED_SERVER_ENGINE_RENDER_SCENE_VIEW_H_

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/backend.h"
#include "core/base/mutex.h"
#include "server/engine/memory/memory_budget.h"
#include "server/engine/render/chunk_set.h"
#include "server/engine/render/encode_snapshot.h"
#include "server/engine/render/residency.h"
#include "server/engine/render/snapshot.h"
#include "server/engine/render/vertex_slot.h"
#include "server/engine/render/view_room.h"

namespace latticed {

struct SceneState;  // server/engine/scene.h
class SceneView;

// One evaluation and encoding of a view, taken from a consistent state.
struct ViewWork {
  std::shared_ptr<SceneView> view;
  std::shared_ptr<const SceneState> state;
  std::vector<uint32_t> chunks;  // dirty since the revision begun before; ascending, may be empty
  size_t slot = 0;
  std::vector<uint32_t> stale;  // what of the slot's vertices is older than the state
  bool drop_other = false;      // the other slot is of another structure
  bool evaluated = false;
  absl::Duration evaluate_time;
  uint64_t points = 0;  // to evaluate on the host's cores, and to encode
};

// What a stage calls on its way, on its own thread and with no lock held.
struct WorkHooks {
  std::function<void()> more_work;                 // the next evaluation may begin beside this
  std::function<void(uint64_t points)> part_done;  // so many points since the call before
};

inline constexpr uint64_t kAnyPoints = std::numeric_limits<uint64_t>::max();

class SceneView {
 public:
  // What its evaluation needs is asked of `memory` first; null: no limit. `residency` outlives it.
  SceneView(const ViewKey& key, Residency* residency, std::shared_ptr<MemoryBudget> memory)
      : key_(key), residency_(residency), room_(std::move(memory)) {}

  const ViewKey& key() const { return key_; }

  // Watchers that want updates now; paused ones do not count.
  void AddActive() ABSL_LOCKS_EXCLUDED(mutex_);
  void RemoveActive() ABSL_LOCKS_EXCLUDED(mutex_);
  bool watched() const { return active_.load() > 0; }
  absl::Time last_watched() const ABSL_LOCKS_EXCLUDED(mutex_);

  // Marks chunks for the next evaluation; all of them after a change of structure or box.
  void MarkDirty(const std::vector<uint32_t>& chunks) ABSL_LOCKS_EXCLUDED(mutex_);
  void MarkAllDirty() ABSL_LOCKS_EXCLUDED(mutex_);

  // What was evaluated ahead, once it can be encoded; or takes what is dirty for an evaluation of
  // `state`. nullopt while the stage is taken, when nobody watches, when the view is at the state,
  // while no watcher has taken the newest snapshot (evaluating ahead of slow readers would be
  // waste), or after a failure; and where it is more than `most_points`.
  [[nodiscard]] std::optional<ViewWork> Begin(std::shared_ptr<SceneView> self,
                                              std::shared_ptr<const SceneState> state,
                                              uint64_t most_points) ABSL_LOCKS_EXCLUDED(mutex_);
  // Evaluates, encodes and publishes, holding no lock meanwhile. Stops early when the last watcher
  // leaves. Once for each Begin. Whether watchers should look: there is a new snapshot, or a
  // failure. `replaced`: what a new snapshot took the place of, to be freed when there is time.
  bool Run(ViewWork work, const WorkHooks& hooks, std::shared_ptr<const Snapshot>& replaced)
      ABSL_LOCKS_EXCLUDED(mutex_);

  // The newest snapshot, pinned; null while it is below `at_least` or there is none. The caller
  // tells the scene (RequestWork) afterwards: now a newer one is worth evaluating, unless the
  // watcher may not take that either (`takes_next`), for it would be old when it may.
  [[nodiscard]] std::shared_ptr<const Snapshot> PinNewest(uint64_t at_least, bool takes_next)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // The watcher to which snapshot `number` is sent may take the next one now. Whether the caller
  // should tell the scene.
  [[nodiscard]] bool TakeNext(uint64_t number) ABSL_LOCKS_EXCLUDED(mutex_);
  // A watcher has all of snapshot `number` and would take a newer one, and the one after it, if it
  // `takes_next`. Whether the caller should tell the scene.
  [[nodiscard]] bool WaitForNewer(uint64_t number, bool takes_next) ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] std::shared_ptr<const Snapshot> newest() const ABSL_LOCKS_EXCLUDED(mutex_);
  void Unpin(uint64_t number) ABSL_LOCKS_EXCLUDED(mutex_);
  // For a watcher that takes more of it; null when it was retired.
  [[nodiscard]] std::shared_ptr<const Snapshot> Find(uint64_t number) ABSL_LOCKS_EXCLUDED(mutex_);
  // Why the view cannot be evaluated any more; its watchers end with it.
  [[nodiscard]] absl::Status failure() const ABSL_LOCKS_EXCLUDED(mutex_);

  // Evaluations begun so far, and those of them that an encoding of the view was beside.
  [[nodiscard]] uint64_t evaluations() const { return evaluations_.load(); }
  [[nodiscard]] uint64_t evaluations_beside() const { return evaluations_beside_.load(); }
  [[nodiscard]] MemoryUse memory() const ABSL_LOCKS_EXCLUDED(mutex_);
  // What would be free without this view, on the host and on the device.
  [[nodiscard]] uint64_t GivableBytes() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  // Begin's choice of a slot for an evaluation; nullopt where none may begin.
  std::optional<size_t> ChooseSlot(const SceneState& state) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  uint64_t PointsOf(size_t chunks) const;
  // The two halves of Run.
  enum class Next { kEncode, kHeld, kEnd };
  Next EvaluateStage(ViewWork& work, const WorkHooks& hooks) ABSL_LOCKS_EXCLUDED(mutex_);
  void EncodeStage(const ViewWork& work, const WorkHooks& hooks, const Snapshot* before)
      ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status Evaluate(ViewWork& work, const WorkHooks& hooks) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status BetweenBatches(const ViewWork& work, const EncodeProgress& progress,
                              const WorkHooks& hooks) ABSL_LOCKS_EXCLUDED(mutex_);
  // Of the budget, for the slots as they are after the work, and for what the snapshots will keep with
  // this one. Where there is none its chunks leave blocks that are mostly empty, before other scenes
  // give something back.
  absl::Status MakeRoomFor(Snapshot& next, const ViewWork& work) ABSL_LOCKS_EXCLUDED(mutex_);
  uint64_t SlotBytes() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);  // on the host
  void StartEncoding(ViewWork& work) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Leaves what the work was to do to the next. Unless it was stopped (ok or kCancelled) its slot
  // was reset: the view goes on with the other one, or has failed.
  void GiveUp(const ViewWork& work, const absl::Status& status)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // What was held, to be destroyed without the lock.
  std::optional<ViewWork> DropHeld() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void ForgetSlot(size_t slot) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const ViewKey key_;
  Residency* const residency_;
  std::atomic<int> active_ = 0;
  std::atomic<uint64_t> evaluations_ = 0, evaluations_beside_ = 0;

  // Each used by the stage whose ViewWork names it; by AddActive while none is out.
  std::array<VertexSlot, 2> slots_;

  mutable Mutex mutex_;
  // The stages.
  bool evaluating_ ABSL_GUARDED_BY(mutex_) = false;
  bool encoding_ ABSL_GUARDED_BY(mutex_) = false;
  size_t encoding_slot_ ABSL_GUARDED_BY(mutex_) = 0;
  bool encoding_ends_soon_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<ViewWork> held_ ABSL_GUARDED_BY(mutex_);  // evaluated; without `view`
  absl::Duration evaluate_time_ ABSL_GUARDED_BY(mutex_);  // of the last one
  // What the last one begun was: of its structure, in its slot.
  uint64_t begun_revision_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t begun_structure_ ABSL_GUARDED_BY(mutex_) = 0;
  size_t begun_slot_ ABSL_GUARDED_BY(mutex_) = 0;
  bool two_slots_ ABSL_GUARDED_BY(mutex_) = false;      // both may hold memory
  bool one_slot_only_ ABSL_GUARDED_BY(mutex_) = false;  // there was no room for two
  ViewRoom room_ ABSL_GUARDED_BY(mutex_);

  // What edits leave to do: in the next snapshot, and in each slot.
  ChunkSet dirty_ ABSL_GUARDED_BY(mutex_) = ChunkSet::All();
  ChunkSet unpublished_ ABSL_GUARDED_BY(mutex_);  // of work given up; whatever is encoded next
  std::array<ChunkSet, 2> stale_ ABSL_GUARDED_BY(mutex_) = {ChunkSet::All(), ChunkSet::All()};

  bool newest_taken_ ABSL_GUARDED_BY(mutex_) = true;
  bool awaited_ ABSL_GUARDED_BY(mutex_) = false;  // by one who has all and takes two
  uint64_t next_number_ ABSL_GUARDED_BY(mutex_) = 1;
  SnapshotRing ring_ ABSL_GUARDED_BY(mutex_);
  std::array<MemoryUse, 2> slot_memory_ ABSL_GUARDED_BY(mutex_);
  absl::Status failure_ ABSL_GUARDED_BY(mutex_);
  absl::Time last_watched_ ABSL_GUARDED_BY(mutex_) = absl::Now();
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_SCENE_VIEW_H_
