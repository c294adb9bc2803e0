// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One watcher of a scene: it attaches to a view, holds the snapshot that is being sent, and asks
// watch/next_event.h what comes next.
//
// Threads  one at a time: the stream locks it. Takes the locks of the scene and the view.
#ifndef LATTICED_SERVER_ENGINE_WATCHER_H_
#define LATTICED_SERVER_ENGINE_WATCHER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/engine/scene.h"
#include "server/engine/watch/level_of_detail.h"
#include "server/engine/watch/next_event.h"
#include "server/engine/watch/resume_token.h"

namespace latticed {

struct WatcherOptions {
  std::string
      evaluator;    // name of the build and its devices; runs with the same make the same bytes
  std::string run;  // name of this run of the server
  std::string editor_id;           // whose applied_sequence is sent; may be empty
  WatchView view;                  // as asked for
  std::string resume_token;        // may be empty, or of another server
  size_t max_unacked_updates = 2;  // 0: acknowledgements are off
  uint64_t min_revision = 0;       // updates below it are not begun
  bool only_full_detail = false;   // the limits of the view do not lower the detail
  MemoryAccountPtr account;        // that views which it makes are charged to; may be null
};

class Watcher {
 public:
  // kInvalidArgument (max_points below one segment), kResourceExhausted (views).
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<Watcher>> Create(std::shared_ptr<Scene> scene,
                                                                       WatcherOptions options);
  ~Watcher();
  Watcher(const Watcher&) = delete;  // counts as a watcher of its view
  Watcher& operator=(const Watcher&) = delete;

  // The next event; nullopt when there is nothing to send before the scene changes, or before wake_at().
  // kNotFound when the scene was deleted; the view's error when it cannot be evaluated.
  [[nodiscard]] absl::StatusOr<std::optional<WatchEvent>> Next(absl::Time now);
  // When max_bytes_per_second allows the next batch, or when full detail may be due. InfiniteFuture when the
  // passing of time changes nothing.
  absl::Time wake_at() const { return wake_at_; }

  // Acknowledges an update and those before it. kInvalidArgument for one that was not begun.
  [[nodiscard]] absl::Status Ack(uint64_t update_id);
  [[nodiscard]] absl::Status CheckAck(uint64_t update_id) const;
  // Sets the view from the next update on.
  [[nodiscard]] absl::Status SetView(const WatchView& view);
  // No update is begun while paused or silent. The update in progress goes on while paused, and is dropped
  // when silent.
  void SetPaused(bool paused);
  void SetSilent(bool silent);
  // While an edit is being applied, updates above the revision before it wait for its answer.
  void SetCeiling(std::optional<uint64_t> revision) { client_.ceiling = revision; }
  // The client has half-closed and can acknowledge no more, so nothing waits for acknowledgements.
  void StopAcks() { client_.max_unacked_updates = 0; }
  // Takes effect from the next update on.
  void WantFullDetail() { only_full_detail_ = true; }

  bool resumed() const { return resumed_; }
  // The revision of the last update_end; nullopt before the first.
  std::optional<uint64_t> covered() const { return client_.covered; }
  // Whether the last update_end left all the detail that the view asks for.
  bool has_full_detail() const { return client_.had && client_.had->view == asked_.key; }
  bool update_in_progress() const { return client_.update.has_value(); }
  // Whether a lattice was sent, and whether it is the scene's newest.
  bool has_lattice() const { return client_.lattice_revision.has_value(); }
  bool lattice_current() const;
  const WatchView& view() const { return asked_; }
  // The view of the next updates, under the limits of the view.
  const ViewKey& key() const { return board_->key(); }
  const std::shared_ptr<Scene>& scene() const { return scene_; }

 private:
  Watcher(std::shared_ptr<Scene> scene, const WatcherOptions& options);
  absl::Status UseView(const WatchView& asked);
  // Keeps the present view when no other can be acquired.
  void SwitchTo(const ViewKey& key);
  void ChooseDetail(absl::Time now);
  // Whether the update in progress, of `snapshot`, gives way to one of fewer segments.
  bool GivesWay(const Snapshot& snapshot, absl::Time now);
  void UpdateActivity();
  void Drop();
  // The snapshot of the update in progress, else the newest, leased.
  std::shared_ptr<const Snapshot> TakeSnapshot(absl::Time now);
  void WantNewer(const Snapshot* offered);
  const std::string& TopologyOf(const Snapshot& snapshot);
  void Complete(UpdateEnds& end);
  void Count(const WatchEvent& event) const;

  const std::shared_ptr<Scene> scene_;
  const std::string editor_id_;
  const MemoryAccountPtr account_;
  const TokenScope scope_;
  ClientState client_;
  WatchView asked_;
  LevelOfDetail detail_{asked_};
  std::shared_ptr<SnapshotBoard> full_board_;  // as asked
  std::shared_ptr<SnapshotBoard> board_;       // of the next updates, perhaps with fewer segments
  std::optional<SnapshotLease> lease_;         // of the update in progress
  bool attached_ = false, paused_ = false, silent_ = false;
  bool only_full_detail_ = false;
  bool resumed_ = false;
  std::pair<uint64_t, int> named_;  // structure and TopologySegments of name_
  std::string name_;                // their topology's
  uint64_t applied_sequence_ = 0;
  absl::Time wake_at_ = absl::InfiniteFuture();
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_WATCHER_H_
