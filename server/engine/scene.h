// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene: one mesh under its lattices, edited by many and watched by many. Here the engine's rooms
// meet:
//
//   ApplyEdits -> scene/   SceneEditor: the next state, and which chunks are dirty
//              -> render/  RenderView::MarkDirty, RenderQueue::Schedule
//   a worker   -> TakeWork -> RenderView::Run, which publishes -> listeners are notified
//
// A SceneState is immutable: whoever holds one reads a consistent scene. Edits of one scene are
// serialised by edit_mutex_. A new plan is made without it: the edit that wants it is tried again with
// the plan, and commits if the structure is then still the one that was planned.
//
// With a store, an edit is applied, appended to the scene's log, and published when that is durable. The next edit
// builds on what is applied, but nobody sees a revision that a crash could take back. If the store fails, all that
// was applied since is forgotten, and the next edit builds on what is stored.
//
// Locks    edit_mutex_ before mutex_ before a view's; listeners are notified without mutex_ and without a view's
// Threads  safe
#ifndef LATTICED_SERVER_ENGINE_SCENE_H_
#define LATTICED_SERVER_ENGINE_SCENE_H_

#include <atomic>
#include <chrono>
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
#include "core/ffd/lattice.h"
#include "core/ffd/weights/vertex_weights.h"
#include "core/mesh/mesh_units.h"
#include "server/engine/points/point_set.h"
#include "server/engine/render/render_queue.h"
#include "server/engine/render/render_view.h"
#include "server/engine/scene/edit_log.h"
#include "server/engine/scene/point_revisions.h"
#include "server/engine/scene/presence.h"
#include "server/engine/scene/scene_editor.h"
#include "server/engine/scene/scene_journal.h"
#include "server/engine/scene/scene_listener.h"
#include "server/engine/scene/scene_memory.h"
#include "server/engine/scene/scene_replay.h"
#include "server/engine/scene/scene_state.h"
#include "server/engine/watch/watch_view.h"

namespace latticed {

class CpuArena;  // core/view/cpu_arena.h

// What a scene is made from. Only its lattices change.
struct SceneConfig {
  std::string id;       // with its tenant: server/base/auth/tenant.h
  std::string mesh_id;  // the same
  std::string name;     // for people; may be empty
  std::shared_ptr<const PolygonMesh> mesh;
  // At revision 0; reset{INITIAL} returns to them. At least one: their displacements add. The scene moves them out of here
  // and keeps its own copies.
  std::vector<Lattice> lattices;
  double strength = 1;    // at revision 0: how much of the deformation the scene takes
  VertexWeights weights;  // at revision 0; null: none (core/ffd/weights/vertex_weights.h)
  std::optional<double> crease_angle;  // in degrees (core/ffd/plan/vertex_normals.h)
  MeshUnits units;                     // of its coordinates, for clients and exported files
  WatchView default_view;
  Pipeline pipeline = Pipeline::kFused;
  absl::Duration idle_ttl = absl::Hours(24);
  bool fold_watch = false;  // the summary of each edit has a report of folds
  std::map<std::string, std::string> labels;
  std::string owner;
  absl::Time create_time = absl::Now();
  MemoryAccountPtr account;  // that the plan and the history are charged to; may be null
  // Identifies the request: the same request again returns the scene, another one is ALREADY_EXISTS.
  std::string fingerprint;
  // The key of resume tokens; secret. Empty: a new one.
  std::string token_key;
  // What a store keeps of it (server/store/records/header_codec.h).
  std::string stored_header;
};

// What the scenes of a server share. All outlive the scenes.
struct SceneContext {
  RenderBackend* backend = nullptr;
  RenderQueue* queue = nullptr;
  Store* store = nullptr;     // null: scenes end with the server
  CpuArena* arena = nullptr;  // null: surfaces are measured on the caller's thread alone
};

class Scene : public RenderSource, public std::enable_shared_from_this<Scene> {
 public:
  // Makes the plan and prepares the backend. kInvalidArgument for a bad lattice,
  // kResourceExhausted, kUnavailable; what `stop` says, which is asked meanwhile.
  [[nodiscard]] static absl::StatusOr<std::shared_ptr<Scene>> Create(SceneConfig config,
                                                                     const SceneContext& context,
                                                                     StopCheck stop = NeverStop);
  // The scene that was made from `config` before, as its log left it. Errors of Create; kDataLoss.
  [[nodiscard]] static absl::StatusOr<std::shared_ptr<Scene>> Restore(SceneConfig config,
                                                                      const SceneLog& log,
                                                                      const SceneContext& context,
                                                                      StopCheck stop = NeverStop);
  ~Scene() override;
  Scene(const Scene&) = delete;  // listeners and workers hold its address
  Scene& operator=(const Scene&) = delete;

  const SceneConfig& config() const { return config_; }
  const std::string& id() const { return config_.id; }
  absl::Time create_time() const { return config_.create_time; }
  // Of a revision that the scene was made from: those since its log's last snapshot, at most kMostCommitTimes.
  [[nodiscard]] std::optional<absl::Time> CommitTime(uint64_t revision) const;

  // Applies all of the batch or nothing, and makes the next revision. kInvalidArgument, kAborted
  // (STRUCTURE_CHANGED, REVISION_CHANGED, OUT_OF_ORDER, UNDO_CONFLICT), kFailedPrecondition (nothing to
  // undo), kResourceExhausted, kNotFound when the scene was deleted. A change of structure makes its plan
  // in this call, which takes seconds on large meshes; other edits are applied meanwhile. When `stop` ends
  // it, nothing has changed and nothing is kept for replay, so the batch may be sent again.
  // kResourceExhausted and kUnavailable, reason STORE: the store did not take it, and nothing has changed.
  [[nodiscard]] absl::StatusOr<EditSummary> ApplyEdits(const EditBatch& batch,
                                                       StopCheck stop = NeverStop)
      ABSL_LOCKS_EXCLUDED(edit_mutex_, mutex_);
  // The same, but returns when the batch is applied. Calls `done` once when it is durable, perhaps before it
  // returns, else on a thread of the store. A batch that is refused before it is applied is answered at once.
  using EditDone = std::function<void(const absl::StatusOr<EditSummary>&)>;
  void SubmitEdits(const EditBatch& batch, StopCheck stop, EditDone done)
      ABSL_LOCKS_EXCLUDED(edit_mutex_, mutex_);

  [[nodiscard]] std::shared_ptr<const SceneState> State() const ABSL_LOCKS_EXCLUDED(mutex_);
  // By which the newest plan is evaluated: the one that was asked for, if it takes turned lattices or there are none.
  [[nodiscard]] Pipeline pipeline() const { return PipelineFor(*State()->plan); }
  // The newest state, and what evaluates it.
  [[nodiscard]] RenderInput Head() const ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] MemoryUse memory() const ABSL_LOCKS_EXCLUDED(mutex_);
  // When the scene expires if nobody watches or edits it from now on.
  [[nodiscard]] absl::Time expire_time() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Why edits are refused and streams end: kNotFound after Delete; kUnavailable, reason SCENE_MOVED, after Leave; else OK.
  [[nodiscard]] absl::Status ended() const;
  // Whether the scene lives on in the store, and not here.
  [[nodiscard]] bool is_lost() const { return life_ == Life::kLeft; }
  [[nodiscard]] size_t watcher_count() const ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] size_t WatchersOf(const MemoryAccount& account) const ABSL_LOCKS_EXCLUDED(mutex_);
  // Counts of all scenes together.
  EngineCounts& counts() const { return context_.backend->counts(); }

  // The most bytes that Evict would free, on the host and all devices, or on one device. 0 while somebody
  // watches or holds the scene, or has a view of it.
  [[nodiscard]] uint64_t EvictableBytes(const MemoryShortage& shortage = {}) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  // When it was last watched, held or edited.
  [[nodiscard]] absl::Time last_use() const ABSL_LOCKS_EXCLUDED(mutex_);
  // The scene's log, as a store would have it: one snapshot, and no record. Only without a store: that has the log.
  [[nodiscard]] SceneLog Copy() ABSL_LOCKS_EXCLUDED(edit_mutex_);
  // Frees the views and what the scene has on devices, unless somebody watches or holds the scene, or has a
  // view of it. They are made again when they are needed. Returns whether it freed any.
  bool Evict() ABSL_LOCKS_EXCLUDED(mutex_);
  // Nothing is evicted while somebody keeps the result.
  [[nodiscard]] std::shared_ptr<const void> Hold() const { return hold_; }

  // Refuses edits from now on, and ends streams. After Leave, the scene may live on another server. Idempotent.
  void Delete() ABSL_LOCKS_EXCLUDED(edit_mutex_, mutex_) { End(Life::kDeleted); }
  void Leave() ABSL_LOCKS_EXCLUDED(edit_mutex_, mutex_) { End(Life::kLeft); }
  // What the store has is not what this scene has, or may be, as after Leave, which is still to be called: this waits for
  // nothing, and notifies nobody. Returns ended().
  absl::Status Lose();
  // Whether edits wait for the store.
  [[nodiscard]] bool has_pending() const { return !journal_.is_idle(); }
  // Housekeeping, called about once a second: ends gestures that time out, and drops views that nobody has
  // watched lately.
  void Tick(absl::Time now) ABSL_LOCKS_EXCLUDED(edit_mutex_, mutex_);

  // Notifies `listener` from now on, until it is destroyed.
  void AddListener(std::weak_ptr<SceneListener> listener) ABSL_LOCKS_EXCLUDED(mutex_);
  void NotifyListeners() ABSL_LOCKS_EXCLUDED(mutex_);
  // Who is at the scene. Whoever calls Show or Leave also wakes those that they return.
  PresenceBoard& presence() { return presence_; }
  // Returns the view with that key, which is made if it is new and lives as long as the result. A new view is
  // charged to `account`.
  // kInvalidArgument, or kResourceExhausted when limits::kMaxViewsPerScene views are watched.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<SnapshotBoard>> AcquireView(
      const ViewKey& key, const MemoryAccountPtr& account = nullptr) ABSL_LOCKS_EXCLUDED(mutex_);
  // What evaluates the scene.
  RenderBackend& backend() const { return *context_.backend; }
  // Points that clients keep here. While there are any, the scene is not put to sleep.
  PointSets& point_sets() { return point_sets_; }
  const PointSets& point_sets() const { return point_sets_; }
  // The scene is used now, so it expires later.
  void NoteUse() ABSL_LOCKS_EXCLUDED(mutex_);
  // Called when a view may have work: it was attached, wants a newer snapshot, or is behind.
  void RequestWork() { context_.queue->Schedule(shared_from_this()); }
  [[nodiscard]] std::function<void()> TakeWork(uint64_t most_points) override
      ABSL_LOCKS_EXCLUDED(mutex_);

  // The newest state, and the deltas that lead there from the lattice at `revision`.
  struct LatticeNews {
    std::shared_ptr<const SceneState> state;
    EditLog::Deltas deltas;
  };
  [[nodiscard]] LatticeNews LatticeAfter(std::optional<uint64_t> revision) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  // As EditLog::AppliedSequence.
  [[nodiscard]] uint64_t AppliedSequence(const std::string& editor_id, uint64_t revision) const
      ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  enum class Life { kLives, kDeleted, kLeft };
  void End(Life life) ABSL_LOCKS_EXCLUDED(edit_mutex_, mutex_);
  // A plan for the structures of all lattices, and the backend's target for it.
  struct Prepared {
    SceneState state;
    std::shared_ptr<TargetSlot> target;
  };
  Scene(SceneConfig config, SceneLife life, MemoryReservation history, const SceneContext& context);
  [[nodiscard]] static absl::StatusOr<std::shared_ptr<Scene>> Make(SceneConfig config,
                                                                   SceneLife life,
                                                                   const SceneContext& context,
                                                                   StopCheck stop);
  // Accounts for the history that a new life of the scene begins with. kResourceExhausted.
  [[nodiscard]] absl::Status HoldRestored(const SceneLattices& lattices)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(edit_mutex_) ABSL_LOCKS_EXCLUDED(mutex_);
  // Of undo steps, log_ and commits_.
  uint64_t HistoryBytes() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(edit_mutex_)
      ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] Pipeline PipelineFor(const DeformPlan& plan) const;
  [[nodiscard]] absl::StatusOr<Prepared> Prepare(const PlanKey& key, StopCheck stop) const;
  // For a batch that wants this plan. Where weights are to keep a volume, with the moments that this takes: made here, they
  // hold up no other edit.
  [[nodiscard]] absl::StatusOr<Prepared> PrepareFor(const EditBatch& batch, const PlanKey& key,
                                                    StopCheck stop) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  // What becomes of a batch: its answer, or where there is a store, nothing here and `done` later.
  using Answer = std::optional<absl::StatusOr<EditSummary>>;
  // Applies the batch with the present plan. If it leads to another one, sets `wanted` to what that is of, and
  // changes nothing.
  [[nodiscard]] Answer TryEdits(const EditBatch& batch, std::optional<PlanCandidate>& candidate,
                                std::shared_ptr<TargetSlot> target, std::optional<PlanKey>& wanted,
                                const EditDone& done) ABSL_LOCKS_EXCLUDED(edit_mutex_, mutex_);
  void MaybeSnapshot(const SceneRecord& record) ABSL_EXCLUSIVE_LOCKS_REQUIRED(edit_mutex_);
  [[nodiscard]] absl::Status AdmitEdit() ABSL_EXCLUSIVE_LOCKS_REQUIRED(edit_mutex_)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Goes on from what is stored, after an append has failed.
  [[nodiscard]] absl::Status ReadAgain() ABSL_EXCLUSIVE_LOCKS_REQUIRED(edit_mutex_)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // The answer to a batch that is now durable, or why it is not. Publishes what it did.
  [[nodiscard]] absl::StatusOr<EditSummary> Settle(const absl::StatusOr<EditCommit>& commit,
                                                   const std::shared_ptr<TargetSlot>& target,
                                                   const absl::Status& durable)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Time since the scene was made, over all its lives.
  EditHistory::TimePoint Now() const {
    return EditHistory::TimePoint(std::chrono::steady_clock::now() - epoch_);
  }
  void Publish(const EditCommit& commit, std::shared_ptr<TargetSlot> target)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Forgets the oldest of history and log until the rest fits in memory. No edit is refused for them. Counts
  // in `record` what a log must repeat.
  void FitHistory(EditRecord& record) ABSL_EXCLUSIVE_LOCKS_REQUIRED(edit_mutex_)
      ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] bool ForgetOldest(EditRecord& record) ABSL_EXCLUSIVE_LOCKS_REQUIRED(edit_mutex_)
      ABSL_LOCKS_EXCLUDED(mutex_);
  void EndIdleGestures(absl::Time now) ABSL_LOCKS_EXCLUDED(edit_mutex_, mutex_);
  void RunTurn(RenderWork work) ABSL_LOCKS_EXCLUDED(mutex_);
  size_t WatchersLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool InUseLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const SceneConfig config_;
  const SceneContext context_;
  std::atomic<Life> life_ = Life::kLives;
  const std::shared_ptr<const void> hold_ = std::make_shared<char>();
  PresenceBoard presence_;
  PointSets point_sets_;

  const EditHistory::TimePoint epoch_;  // Now() was 0
  const CommitTimes commits_;           // of earlier lives

  Mutex edit_mutex_;
  SceneEditor editor_ ABSL_GUARDED_BY(edit_mutex_);
  SceneJournal journal_;
  // What the last edit led to. It is published when it is durable.
  std::shared_ptr<const SceneState> applied_ ABSL_GUARDED_BY(edit_mutex_);
  bool is_box_stored_ ABSL_GUARDED_BY(edit_mutex_) = true;
  HistoryReservation history_reservation_ ABSL_GUARDED_BY(edit_mutex_);
  std::atomic<uint64_t> history_bytes_ = 0;  // HistoryBytes(), to be read without the locks

  mutable Mutex mutex_;
  RenderInput head_ ABSL_GUARDED_BY(mutex_);
  std::map<ViewKey, std::shared_ptr<RenderView>> views_ ABSL_GUARDED_BY(mutex_);
  EditLog log_ ABSL_GUARDED_BY(mutex_);
  PointRevisions moved_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::weak_ptr<SceneListener>> listeners_ ABSL_GUARDED_BY(mutex_);
  absl::Time last_use_ ABSL_GUARDED_BY(mutex_);
  size_t next_view_ ABSL_GUARDED_BY(mutex_) = 0;  // which view has the next turn
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_H_
