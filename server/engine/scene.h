// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene: one mesh under one lattice, edited by many and watched by many.            DESIGN §4
//
//   ApplyEdits -> new SceneState (revision + 1) -> dirty chunks of every view -> listeners woken
//   UpdatePipeline: TakeWork -> evaluate and encode with no lock held -> SceneView publishes
//
// A SceneState is immutable: who holds one reads a consistent scene for as long as he likes. Edits
// of one scene are serialised by edit_mutex_. A new plan is made without it: the edit that wants it
// is tried again with the plan, and commits if the structure is then still the one that was
// planned.
//
// Locks    edit_mutex_ before mutex_ before SceneView's own; listeners run with none of them held
// Threads  safe
#ifndef LATTICED_SERVER_ENGINE_SCENE_H_
#define LATTICED_SERVER_ENGINE_SCENE_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/backend.h"
#include "core/base/mutex.h"
#include "core/base/stop_check.h"
#include "core/ffd/edit_history.h"
#include "core/ffd/lattice.h"
#include "server/engine/memory/scene_room.h"
#include "server/engine/render/scene_view.h"
#include "server/engine/scene/edit_log.h"
#include "server/engine/scene/presence.h"
#include "server/engine/scene/scene_state.h"

namespace latticed {

class DirtySet;  // core/ffd/dirty_set.h
class UpdatePipeline;

// What a scene is made from, and what of it never changes.
struct SceneConfig {
  std::string id;
  std::string mesh_id;
  std::shared_ptr<const PolygonMesh> mesh;
  // At revision 0, and what reset{INITIAL} returns to. The scene takes it out of here: it has enough
  // copies.
  Lattice lattice;
  WatchView default_view;
  Pipeline pipeline = Pipeline::kFused;
  absl::Duration idle_ttl = absl::Hours(24);
  std::map<std::string, std::string> labels;
  std::string owner;
  std::shared_ptr<MemoryBudget> memory;  // plans and views ask it first; null: no limit
  // Of the request: the same again returns the scene, another is ALREADY_EXISTS.
  std::string fingerprint;
};

// Is told that a scene has something new, or that it was deleted. Called with no lock of the scene
// held, from any thread; must not block.
class SceneListener {
 public:
  virtual ~SceneListener() = default;
  virtual void OnSceneChanged() = 0;
};

class Scene : public std::enable_shared_from_this<Scene> {
 public:
  // Makes the plan and prepares the backend. kInvalidArgument for a bad lattice,
  // kResourceExhausted, kUnavailable; what `stop` says, which is asked meanwhile. `residency` and
  // `pipeline` outlive the scene.
  [[nodiscard]] static absl::StatusOr<std::shared_ptr<Scene>> Create(SceneConfig config,
                                                                     Residency* residency,
                                                                     UpdatePipeline* pipeline,
                                                                     StopCheck stop = NeverStop);
  ~Scene();
  Scene(const Scene&) = delete;  // listeners and workers hold its address
  Scene& operator=(const Scene&) = delete;

  const SceneConfig& config() const { return config_; }
  const std::string& id() const { return config_.id; }
  absl::Time create_time() const { return create_time_; }
  // Of all the scenes of this process no other has it, not even one of the same id.
  uint64_t incarnation() const { return incarnation_; }

  // All of the batch or nothing; revision + 1. kInvalidArgument, kAborted (STRUCTURE_CHANGED,
  // REVISION_CHANGED, OUT_OF_ORDER, UNDO_CONFLICT), kFailedPrecondition (nothing to undo),
  // kResourceExhausted, kNotFound when the scene was deleted. A change of structure makes its plan
  // here, for seconds on large meshes; other edits go on meanwhile, and what `stop` says ends it:
  // then nothing has changed and nothing is kept for replay, so that the batch may be sent again.
  [[nodiscard]] absl::StatusOr<EditSummary> ApplyEdits(const EditBatch& batch,
                                                       StopCheck stop = NeverStop)
      ABSL_LOCKS_EXCLUDED(edit_mutex_, mutex_);

  [[nodiscard]] std::shared_ptr<const SceneState> State() const ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] MemoryUse memory() const ABSL_LOCKS_EXCLUDED(mutex_);
  // When it will be evicted if nobody watches or edits from now on.
  [[nodiscard]] absl::Time expire_time() const ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] bool deleted() const { return deleted_.load(); }
  [[nodiscard]] size_t watcher_count() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Of all scenes together.
  EngineCounts& counts() const { return residency_->counts(); }

  // What GiveBack would free, at most, on the host and on all devices, or on one of them; 0 while
  // somebody watches, holds, or has a view of it.
  [[nodiscard]] uint64_t GivableBytes(std::optional<int> device = std::nullopt) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Frees its views and what it has on the device, unless somebody watches, holds, or has a view of
  // it. Whoever comes next has the same made again. Whether it freed any.
  bool GiveBack() ABSL_LOCKS_EXCLUDED(mutex_);
  // While the result lives nothing is given back.
  [[nodiscard]] std::shared_ptr<const void> Hold() const { return hold_; }

  // From here on edits are refused and streams end with kNotFound. Idempotent.
  void Delete() ABSL_LOCKS_EXCLUDED(edit_mutex_, mutex_);
  // Housekeeping, about once a second: gestures that time out, views that nobody has watched
  // lately.
  void Tick(absl::Time now) ABSL_LOCKS_EXCLUDED(edit_mutex_, mutex_);

  // Wakes `listener` from now on; it expires by itself.
  void AddListener(std::weak_ptr<SceneListener> listener) ABSL_LOCKS_EXCLUDED(mutex_);
  // The view of that key, made when it is new. kInvalidArgument, or kResourceExhausted when all of
  // limits::kMaxViewsPerScene are watched.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<SceneView>> AcquireView(const ViewKey& key)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Who is here. Who shows or takes back a presence wakes those who wait for it.
  PresenceBoard& presence() { return presence_; }
  void WakeListeners() ABSL_LOCKS_EXCLUDED(mutex_);
  // Tells the pipeline that a view may have work: it was attached, unpaused or left behind.
  void RequestWork() ABSL_LOCKS_EXCLUDED(mutex_);
  // One stage of one view that is watched and behind, with what may follow it, of `most_points` or
  // less; nullopt when there is none.
  [[nodiscard]] std::optional<ViewWork> TakeWork(uint64_t most_points) ABSL_LOCKS_EXCLUDED(mutex_);
  // Runs what TakeWork gave, without a lock, then requests work again, for what was edited or
  // evaluated meanwhile, and wakes the listeners. `part_done` as in WorkHooks.
  void RunWork(ViewWork work, std::function<void(uint64_t points)> part_done)
      ABSL_LOCKS_EXCLUDED(mutex_);

  // As of EditLog, which has this scene's edits.
  [[nodiscard]] EditLog::Deltas DeltasAfter(uint64_t revision) const ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] uint64_t AppliedSequence(const std::string& editor_id, uint64_t revision) const
      ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  Scene(SceneConfig config, Lattice lattice, Residency* residency, UpdatePipeline* pipeline);
  // What an edit that changes the structure needs, or why it cannot be had.
  struct Candidate {
    LatticeStructure structure;
    absl::StatusOr<SceneState> state;
  };
  [[nodiscard]] absl::StatusOr<SceneState> Prepare(const LatticeStructure& structure,
                                                   StopCheck stop) const;
  [[nodiscard]] absl::StatusOr<SceneState> PrepareUnguarded(const LatticeStructure& structure,
                                                            StopCheck stop) const;
  // Applies the batch, unless it leads to a structure other than the candidate's: then `wanted` is
  // that structure and nothing has changed.
  [[nodiscard]] absl::StatusOr<EditSummary> TryEdits(const EditBatch& batch,
                                                     std::optional<Candidate>& candidate,
                                                     std::optional<LatticeStructure>& wanted)
      ABSL_LOCKS_EXCLUDED(edit_mutex_, mutex_);
  void Commit(const EditBatch& batch, const EditOutcome& outcome,
              std::shared_ptr<const SceneState> next, const DirtySet& dirty)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Forgets what is oldest of history and log until there is room for the rest. An edit is never
  // refused for them.
  void KeepHistoryInRoom() ABSL_EXCLUSIVE_LOCKS_REQUIRED(edit_mutex_) ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] bool ForgetOldest() ABSL_EXCLUSIVE_LOCKS_REQUIRED(edit_mutex_)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // The newest state without an open gesture, at the same revision: for views that send fewer bits
  // meanwhile.
  void EndGestures() ABSL_EXCLUSIVE_LOCKS_REQUIRED(edit_mutex_) ABSL_LOCKS_EXCLUDED(mutex_);
  bool WatchedLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool InUseLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const SceneConfig config_;
  Residency* const residency_;
  UpdatePipeline* const pipeline_;
  const absl::Time create_time_ = absl::Now();
  const uint64_t incarnation_;
  std::atomic<bool> deleted_ = false;
  const std::shared_ptr<const void> hold_ = std::make_shared<char>();

  Mutex edit_mutex_;
  EditHistory history_ ABSL_GUARDED_BY(edit_mutex_);
  HistoryRoom history_room_ ABSL_GUARDED_BY(edit_mutex_);
  std::atomic<uint64_t> history_bytes_ = 0;  // and of log_, for those who do not lock
  PresenceBoard presence_;

  mutable Mutex mutex_;
  std::shared_ptr<const SceneState> state_ ABSL_GUARDED_BY(mutex_);
  std::map<ViewKey, std::shared_ptr<SceneView>> views_ ABSL_GUARDED_BY(mutex_);
  EditLog log_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::weak_ptr<SceneListener>> listeners_ ABSL_GUARDED_BY(mutex_);
  absl::Time last_use_ ABSL_GUARDED_BY(mutex_);
  size_t next_view_ ABSL_GUARDED_BY(mutex_) = 0;  // round robin over the views
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_H_
