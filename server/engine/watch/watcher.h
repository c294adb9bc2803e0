// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What one watcher has, and what it is sent next: the order and the guarantees of SceneEvent,
// without a transport.                                                                    WIRE.md
// "SceneEvent"
//
//   lattice (whole, then deltas) | topology, quantisation when they change | begin, batches, end
//
// There is no queue: Next() looks at the scene and at what the watcher has. After update_end at
// revision r it has every chunk with a version at or below r, so (structure, quantisation, view, r)
// says all: it is also the resume token. An update whose snapshot was retired is begun again with
// restart, from what the watcher had before it.
//
// Threads  one at a time: the stream locks. Takes the locks of the scene and the view.
#ifndef LATTICED_SERVER_ENGINE_WATCH_WATCHER_H_
#define LATTICED_SERVER_ENGINE_WATCH_WATCHER_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/engine/scene.h"
#include "server/engine/watch/level_of_detail.h"

namespace latticed {

struct WatcherOptions {
  std::string boot_id;
  std::string editor_id;           // whose applied_sequence is told; may be empty
  WatchView view;                  // as asked for
  std::string resume_token;        // may be empty or of another run
  size_t max_unacked_updates = 2;  // 0: acknowledgements are off
  uint64_t min_revision = 0;       // updates below it are not begun
  bool only_full_detail = false;   // whatever the limits of the view
};

struct LatticeWhole {
  std::shared_ptr<const SceneState> state;
};
struct TopologyNews {
  std::string topology_id;
  std::shared_ptr<const Snapshot> snapshot;
};
struct QuantisationNews {
  std::shared_ptr<const Snapshot> snapshot;
};
struct UpdateBegins {
  uint64_t update_id = 0;
  uint64_t revision = 0;
  size_t chunk_count = 0;
  bool restart = false;
  WatchView view;  // in force
};
struct ChunkBatch {
  uint64_t update_id = 0;
  std::string topology_id;
  std::shared_ptr<const Snapshot> snapshot;
  std::vector<uint32_t> chunks;
  size_t bytes = 0;
};
struct UpdateEnds {
  uint64_t update_id = 0;
  uint64_t revision = 0;
  uint64_t head_revision = 0;
  uint64_t applied_sequence = 0;
  bool full_detail = true;
  std::string resume_token;
  absl::Duration queue_time, evaluate_time, encode_time, send_time;
};
// An update that is being sent. Outside of Watcher, which holds it in an optional: its default
// member initialisers must be complete there.
struct UpdateInProgress {
  uint64_t id = 0;
  uint64_t number = 0;  // of the snapshot
  std::string topology_id;
  std::vector<uint32_t> chunks;
  size_t sent = 0;
  bool begun = false;  // update_begin was sent
  absl::Time begin_time;
};

using WatcherEvent = std::variant<LatticeWhole, std::shared_ptr<const LatticeDelta>, TopologyNews,
                                  QuantisationNews, UpdateBegins, ChunkBatch, UpdateEnds>;

class Watcher {
 public:
  // kInvalidArgument (max_points below one segment), kResourceExhausted (views).
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<Watcher>> Create(std::shared_ptr<Scene> scene,
                                                                       WatcherOptions options);
  ~Watcher();
  Watcher(const Watcher&) = delete;  // counts as active in its view
  Watcher& operator=(const Watcher&) = delete;

  // The next event; nullopt when there is nothing to send before the scene changes, or before
  // wake_at(). kNotFound when the scene was deleted, or why its view cannot be evaluated.
  [[nodiscard]] absl::StatusOr<std::optional<WatcherEvent>> Next(absl::Time now);
  // When max_bytes_per_second lets the next batch go, or full detail may be due; InfiniteFuture
  // where time changes nothing.
  absl::Time wake_at() const { return wake_at_; }

  // Acknowledges an update and those before it. kInvalidArgument for one that was not begun.
  [[nodiscard]] absl::Status Ack(uint64_t update_id);
  [[nodiscard]] absl::Status CheckAck(uint64_t update_id) const;
  // The view from the next update on.
  [[nodiscard]] absl::Status SetView(const WatchView& view);
  // While paused, or silent, no update is begun. The one in progress goes on when paused, and is
  // dropped when silent.
  void SetPaused(bool paused);
  void SetSilent(bool silent);
  // While an edit is being applied, updates above the revision before it wait for its answer.
  void SetCeiling(std::optional<uint64_t> revision) { ceiling_ = revision; }
  // The client can acknowledge no more (half-close): nothing waits for it.
  void StopAcks() { options_.max_unacked_updates = 0; }
  // From the next update on.
  void WantFullDetail() { options_.only_full_detail = true; }

  bool resumed() const { return resumed_; }
  // Revision of the last update_end; nullopt before the first.
  std::optional<uint64_t> covered() const { return covered_; }
  // Whether the last update_end left all the detail that the view asks for.
  bool has_full_detail() const { return had_.has_value() && had_->view == full_view_->key(); }
  bool update_in_progress() const { return current_.has_value(); }
  // Whether a lattice was sent, and whether it is the scene's newest.
  bool has_lattice() const { return lattice_revision_.has_value(); }
  bool lattice_current() const;
  const WatchView& view() const { return asked_; }
  // Of the updates to come, as the limits of the view have it.
  const ViewKey& key() const { return view_->key(); }
  const std::shared_ptr<Scene>& scene() const { return scene_; }

 private:
  // What the watcher has in full.
  struct Had {
    ViewKey view;
    uint64_t structure_id = 0;
    uint64_t quantisation_id = 0;
    uint64_t revision = 0;
  };

  Watcher(std::shared_ptr<Scene> scene, WatcherOptions options);
  absl::Status UseView(const WatchView& asked);
  // Stays with the view that there is where no other can be had.
  void SwitchTo(const ViewKey& key);
  void ChooseDetail(absl::Time now);
  bool GivesWay(const Snapshot& snapshot, absl::Time now);
  void UpdateActivity();
  void DropUpdate();
  std::optional<WatcherEvent> NextLattice();
  void BeginUpdate(absl::Time now);
  bool AcksAllow(size_t updates) const;  // so many more to be begun
  bool MayBegin() const;
  bool HasNothingNew(const Snapshot& newest) const;
  bool Comparable(const Snapshot& snapshot) const;
  const std::string& TopologyOf(const Snapshot& snapshot);
  std::optional<WatcherEvent> NextOfUpdate(const std::shared_ptr<const Snapshot>& snapshot,
                                           absl::Time now);
  WatcherEvent MakeBegin(const Snapshot& snapshot, absl::Time now);
  WatcherEvent MakeBatch(const std::shared_ptr<const Snapshot>& snapshot, absl::Time now);
  void CountEnd(const Snapshot& snapshot, absl::Time now) const;
  WatcherEvent MakeEnd(const Snapshot& snapshot, absl::Time now);
  std::string MakeToken() const;
  std::optional<Had> ParseToken(std::string_view token) const;

  const std::shared_ptr<Scene> scene_;
  WatcherOptions options_;
  WatchView asked_;
  LevelOfDetail detail_{asked_};
  std::shared_ptr<SceneView> full_view_;     // as asked
  std::shared_ptr<SceneView> view_;          // of the updates to come, perhaps with fewer segments
  std::shared_ptr<SceneView> current_view_;  // of the update in progress
  bool active_ = false, paused_ = false, silent_ = false;
  bool resumed_ = false;

  std::optional<uint64_t> lattice_structure_, lattice_revision_;  // sent
  std::string topology_id_;                                       // sent
  std::optional<std::pair<uint64_t, ViewKey>> quantisation_;      // sent: id and view
  std::pair<uint64_t, int> named_;                                // structure and segments of name_
  std::string name_;                                              // their topology's
  std::optional<Had> had_;
  std::optional<uint64_t> covered_;
  std::optional<uint64_t> ceiling_;
  std::optional<UpdateInProgress> current_;
  bool restart_ = false;  // the next update replaces one that was begun
  uint64_t last_update_id_ = 0;
  std::deque<uint64_t> unacked_;
  uint64_t applied_sequence_ = 0;
  absl::Time wake_at_ = absl::InfiniteFuture();
  absl::Time next_batch_time_ = absl::InfinitePast();
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_WATCH_WATCHER_H_
