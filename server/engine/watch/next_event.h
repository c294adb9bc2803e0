// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Decides what a watcher is sent next, from what it has and what there is.
//
//   Next(client, offer) -> the next event; `client` then has it
//
// There is no queue. After update_end at revision r a client has every chunk with a version at or below r.
// So its view, structure, quantisation, revision and kept tolerance describe all that it has; they are also
// the resume token. The lattice comes before the surface; what the client evaluates by itself needs the lattice of its
// update's very revision, which of several lattices is their sum and comes in the update. An update whose snapshot was retired
// is begun again, with restart set, from what the client had before it.
//
// Threads  pure: no clock, no lock, no scene
#ifndef LATTICED_SERVER_ENGINE_WATCH_NEXT_EVENT_H_
#define LATTICED_SERVER_ENGINE_WATCH_NEXT_EVENT_H_

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/time/time.h"
#include "core/adaptive/pattern_key.h"
#include "server/engine/watch/watch_event.h"

namespace latticed {

// A surface that a client has in full.
struct ClientSurface {
  ViewKey view;
  uint64_t structure_id = 0;
  uint64_t quantisation_id = 0;
  uint64_t revision = 0;
  absl::Time commit_time;          // of the revision, in nanoseconds
  double curvature_tolerance = 0;  // that its patterns were chosen with
  friend bool operator==(const ClientSurface&, const ClientSurface&) = default;
};

// An update that is being sent.
struct ClientUpdate {
  std::string topology_id;
  std::vector<uint32_t> chunks;
  size_t sent = 0;       // how many of them were sent
  bool has_sum = false;  // SumNews was sent
  uint64_t id = 0;       // 0: update_begin was not sent yet
  absl::Time begin_time;
};

struct ClientState {
  // What the client asked for.
  bool takes_updates = true;        // begins new ones
  size_t max_unacked_updates = 2;   // 0: acknowledgements are off
  uint64_t min_revision = 0;        // updates below it are not begun
  std::optional<uint64_t> ceiling;  // updates above it wait for the answer to an edit
  // What the client was sent.
  std::optional<uint64_t> lattice_structure, lattice_revision;
  std::shared_ptr<const SceneState> wholes;  // whose lattices are being sent; null: none
  size_t next_whole = 0;                     // which is next
  std::shared_ptr<const LatticeDelta> also;  // of the revision that was sent last; it is next
  uint64_t lattice_from = 0;                 // the lattices of revisions from here on were all sent
  std::string topology_id;
  std::optional<std::pair<uint64_t, ViewKey>> quantisation;  // id and view
  std::bitset<1 << kPatternCodeBits> patterns;               // by code
  std::shared_ptr<const std::vector<Vec3d>> sum;             // of the lattices; null: none
  uint64_t sum_structure = 0;
  std::optional<ClientSurface> had;  // in full; perhaps from an earlier watch
  std::optional<uint64_t> covered;   // revision of the last update_end
  std::optional<ClientUpdate> update;
  bool restart = false;  // the next update replaces one that was begun
  uint64_t last_update_id = 0;
  std::deque<uint64_t> unacked;
  absl::Time next_batch_time = absl::InfinitePast();
};

// What the scene offers at one moment.
struct WatchOffer {
  std::shared_ptr<const SceneState> state;  // the newest
  EditLog::Deltas deltas;                   // those after the client's lattice
  // The snapshot of client.update, which must not be retired; without one, the newest of the view in force,
  // if any.
  std::shared_ptr<const Snapshot> snapshot;
  std::string topology_id;  // of the snapshot
  WatchView asked;          // in full detail
  absl::Time now;
};

struct NextEvent {
  std::optional<WatchEvent> event;  // nullopt: nothing to send until the offer changes, …
  absl::Time wake_at = absl::InfiniteFuture();  // … or until this time
};

// Whether the lattice is sent next, for which no snapshot is needed.
[[nodiscard]] bool LatticeIsDue(const ClientState& client, const EditLog::Deltas& deltas);
// The caller sets applied_sequence and resume_token of an UpdateEnd.
[[nodiscard]] NextEvent Next(ClientState& client, const WatchOffer& offer);

// Whether the client may be sent this many more updates before it acknowledges one.
[[nodiscard]] bool AcksAllow(const ClientState& client, size_t updates);
// Whether the snapshot is of a view without positions, and its lattice was skipped: the client cannot use it.
[[nodiscard]] bool LacksLattice(const ClientState& client, const Snapshot& snapshot);
// Whether the client could take a snapshot newer than the offered one at once, so that the view should make
// it.
[[nodiscard]] bool WantsNewer(const ClientState& client, const Snapshot* offered);
// Gives up the update in progress. If the client knows of it, it is begun again.
void DropUpdate(ClientState& client);
// The client has acknowledged update `id` and all earlier ones.
void Acknowledge(ClientState& client, uint64_t id);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_WATCH_NEXT_EVENT_H_
