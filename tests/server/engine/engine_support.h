// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Shared by the tests of the scene engine: a small scene, edits in one line, and a watcher's client that
// checks the guarantees of SceneEvent with every event.
#ifndef LATTICED_TESTS_SERVER_ENGINE_ENGINE_SUPPORT_H_
#define LATTICED_TESTS_SERVER_ENGINE_ENGINE_SUPPORT_H_

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/clock.h"
#include "core/base/mutex.h"
#include "server/engine/watcher.h"
#include "server/stores/scene_registry.h"

namespace latticed::testing {

// A wavy square of cells x cells quads over [0,1] x [0,1].
std::shared_ptr<const PolygonMesh> MakeWavyGrid(int cells);

// A scene of a wavy grid in a lattice of size^3 control points, degree 2. Its default view has 4 segments,
// positions of 12 bits, normals of 8 bits, QUANTISED.
SceneConfig MakeSceneConfig(std::string id, int cells = 8, int size = 5);

EditBatch MoveBatch(const Scene& scene, std::string editor, uint64_t sequence,
                    std::vector<uint32_t> indices, Vec3d offset);
EditBatch KnotBatch(const Scene& scene, std::string editor, uint64_t sequence, int axis,
                    double value);

// Signals that the scene has something new.
class Bell : public SceneListener {
 public:
  void OnSceneChanged() override;
  // Waits until the scene has changed since the last Wait, at most `most`.
  void Wait(absl::Duration most);

 private:
  Mutex mutex_;
  bool rung_ ABSL_GUARDED_BY(mutex_) = false;
};

// The client of one watcher. It keeps what it is sent and fails the test when a guarantee is broken.
class WatcherClient {
 public:
  struct Update {
    UpdateBegins begin;
    size_t chunks_sent = 0;
    UpdateEnds end;
  };

  // A given `queue` has no workers: the client runs its turns itself.
  WatcherClient(std::shared_ptr<Scene> scene, const WatcherOptions& options,
                RenderQueue* queue = nullptr);

  Watcher& watcher() { return *watcher_; }
  Bell& bell() { return *bell_; }
  // Takes one event; false when there is none now.
  bool Step(absl::Time now = absl::Now());
  // Steps until an update has ended; fails the test after a minute, or when no turn is left.
  void RunToUpdate(const std::function<absl::Time()>& clock = absl::Now);
  // Steps until an update is in progress and has begun.
  void RunIntoUpdate();
  // Steps until the last update is at the scene's newest revision and nothing is left to send.
  void RunToHead();
  // Reconnects with the token of the last update. If the watcher resumes, the client keeps its chunks.
  void Reconnect(const WatcherOptions& options);

  const std::vector<Update>& updates() const { return updates_; }
  uint64_t lattice_revision() const { return lattice_revision_; }
  const std::vector<Vec3d>& cage() const { return cage_; }
  size_t lattice_wholes() const { return lattice_wholes_; }
  size_t topologies() const { return topologies_; }
  size_t quantisations() const { return quantisations_; }
  const absl::Status& status() const { return status_; }
  // Bytes of every chunk as of the last update_end.
  const std::vector<SharedBytes>& chunks() const { return chunks_; }
  const std::optional<ViewKey>& view() const { return view_; }

 private:
  void Take(const LatticeWhole& event);
  void Take(const std::shared_ptr<const LatticeDelta>& delta);
  void Take(const TopologyNews& event);
  void Take(const QuantisationNews& event);
  void Take(const PatternNews& event);
  void Take(const UpdateBegins& event);
  void Take(const SumNews& event);
  void Take(const ChunkBatch& event);
  void Take(const UpdateEnds& event);

  // Called when no event is ready: runs a turn of `queue`, or waits.
  void AwaitNews();

  std::shared_ptr<Scene> scene_;
  RenderQueue* const queue_;
  std::shared_ptr<Bell> bell_ = std::make_shared<Bell>();
  std::unique_ptr<Watcher> watcher_;
  absl::Status status_;

  uint64_t lattice_revision_ = 0, lattice_structure_ = 0;
  uint64_t lattice_from_ = 0;  // the last whole one
  std::vector<Vec3d> cage_;
  size_t lattice_wholes_ = 0, topologies_ = 0, quantisations_ = 0;
  std::optional<ViewKey> view_;
  std::vector<SharedBytes> chunks_;
  std::optional<Update> current_;
  bool must_restart_ = false;  // the update in progress was dropped, and begins again
  std::map<uint32_t, SharedBytes> staged_;
  std::string topology_id_;
  uint64_t quantisation_id_ = 0;
  std::set<uint16_t> patterns_;  // since Reconnect
  std::vector<Update> updates_;
  size_t first_update_ = 0;  // the first update since Reconnect
};

// The chunks of `state` in the view `key`, all evaluated anew by a separate CPU backend.
std::vector<std::vector<uint8_t>> EvaluateAfresh(const SceneState& state, const ViewKey& key);

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_ENGINE_ENGINE_SUPPORT_H_
