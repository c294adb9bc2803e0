// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view of a scene: one evaluation, one encoding and one snapshot at a time, shared by all watchers
// of its key.
//
//                    Begin                   evaluated              published
//   kIdle, kPublished ----> kEvaluating ----------> kEncoding ----------> kPublished
//                                |                      |
//                                +--- nobody watches ---+----> kIdle      its chunks stay dirty
//                                +--- an error ---------+----> kFailed    until a watcher attaches
//
// Edits during a turn add dirty chunks for the next turn. Snapshots are sent during all stages. A view that
// nobody watches begins no turn, but remembers its dirty chunks.
//
// Memory   reserved once, when the vertices are made, for the most that the view can take: vertices,
//          staging, and chunks of snapshots, which are retired when they would take more
// Threads  safe; the running turn uses the vertices with no lock held
#ifndef LATTICED_SERVER_ENGINE_RENDER_RENDER_VIEW_H_
#define LATTICED_SERVER_ENGINE_RENDER_RENDER_VIEW_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "server/engine/render/chunk_set.h"
#include "server/engine/render/snapshot_board.h"
#include "server/engine/render/target_slot.h"
#include "server/engine/scene/point_revisions.h"
#include "server/engine/scene/scene_state.h"

namespace latticed {

class RenderView;

// What a view is evaluated from.
struct RenderInput {
  std::shared_ptr<const SceneState> state;
  std::shared_ptr<TargetSlot> target;  // of the state's plan
};

// One turn of a view.
struct RenderWork {
  std::shared_ptr<RenderView> view;
  RenderInput input;
  std::vector<uint32_t> chunks;  // dirty, ascending; may be empty
  // Of the first turn: what the revisions of chunks follow from.
  std::optional<PointRevisions> moved;
};

// The bytes of all vertices of a view, or of its bounds. Its encoded chunks take no more, except for their headers.
[[nodiscard]] uint64_t VertexBytes(const DeformPlan& plan, const ViewKey& key);
// The most that a view's snapshots may keep. Draco streams usually take a quarter of their
// vertices, so there is room for four; raw and quantised chunks are their vertices.
[[nodiscard]] uint64_t SnapshotBytes(const DeformPlan& plan, const ViewKey& key, size_t lattices);

class RenderView {
 public:
  enum class Stage { kIdle, kEvaluating, kEncoding, kPublished, kFailed };

  // `account`, which may be null, is charged for the view's memory.
  RenderView(const ViewKey& key, RenderBackend* backend, MemoryAccountPtr account, absl::Time now)
      : backend_(backend), account_(std::move(account)), board_(key, now) {}

  SnapshotBoard& board() { return board_; }
  const ViewKey& key() const { return board_.key(); }
  const MemoryAccountPtr& account() const { return account_; }
  Stage stage() const ABSL_LOCKS_EXCLUDED(mutex_);

  // Adds the chunks that an edit changed; all after a change of structure or quantisation box.
  void MarkDirty(std::span<const uint32_t> chunks) ABSL_LOCKS_EXCLUDED(mutex_);
  void MarkAllDirty() ABSL_LOCKS_EXCLUDED(mutex_);

  // Begins a turn and takes the dirty chunks. Returns nullopt
  //   while a turn runs, or after a failure;
  //   when nobody watches, nobody wants a newer snapshot, or the newest one has this state already;
  //   when the turn has more than `most_points` points to encode; what the host's cores evaluate counts twice, and the
  //   bounds of a patch count as some points.
  // `moved` has the edits up to the state.
  [[nodiscard]] std::optional<RenderWork> Begin(std::shared_ptr<RenderView> self, RenderInput input,
                                                const PointRevisions& moved, uint64_t most_points)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Evaluates, encodes and publishes, with no lock held. It stops early when the last watcher leaves. Called
  // once for each Begin. Returns whether watchers should look: there is a new snapshot, or a failure.
  bool Run(const RenderWork& work) ABSL_LOCKS_EXCLUDED(mutex_);

  [[nodiscard]] MemoryUse memory() const ABSL_LOCKS_EXCLUDED(mutex_);
  // The bytes that destroying this view would free, on the host and on devices.
  [[nodiscard]] uint64_t EvictableBytes() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Of these, the bytes that the account would get back.
  [[nodiscard]] uint64_t BytesChargedTo(const MemoryAccount& account) const
      ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  uint64_t PointsOf(size_t chunks) const;
  // The stages of a turn.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<Snapshot>> Render(const RenderWork& work)
      ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] absl::Status PrepareVertices(const RenderInput& input) ABSL_LOCKS_EXCLUDED(mutex_);
  // Adds to evaluated_.
  [[nodiscard]] absl::Status Evaluate(const RenderWork& work);
  // The ends of a turn.
  void Publish(std::shared_ptr<Snapshot> snapshot) ABSL_LOCKS_EXCLUDED(mutex_);
  bool GiveUp(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  void DropVertices() ABSL_LOCKS_EXCLUDED(mutex_);
  void NoteMemory() ABSL_LOCKS_EXCLUDED(mutex_);

  RenderBackend* const backend_;
  const MemoryAccountPtr account_;
  SnapshotBoard board_;

  // Used by the running turn.
  std::shared_ptr<DeformTarget> target_;  // what vertices_ is a view of
  std::unique_ptr<DeformView> vertices_;
  ViewTraits traits_;
  uint64_t vertices_structure_ = 0;
  // The chunks that the turn began with, and those that its evaluation changed beside them, ascending.
  std::vector<uint32_t> evaluated_;

  mutable Mutex mutex_;
  Stage stage_ ABSL_GUARDED_BY(mutex_) = Stage::kIdle;
  ChunkSet dirty_ ABSL_GUARDED_BY(mutex_) = ChunkSet::All();
  uint64_t begun_revision_ ABSL_GUARDED_BY(mutex_) = 0;
  MemoryReservation reservation_ ABSL_GUARDED_BY(mutex_);
  MemoryUse vertex_memory_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_RENDER_VIEW_H_
