// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A snapshot: the complete set of chunks of a view at one revision, immutable and shared.  DESIGN
// §4
//
// Chunks whose bytes did not change are shared with the snapshot before, revision and all. The ring
// keeps the newest snapshot and those that a watcher is being sent (pinned), at most
// limits::kMaxSnapshotsPerView in all. What leaves it while pinned is *retired*: its watcher finds
// nothing under the number any more and begins again with the newest. Bytes that a socket still
// holds live until it lets go.
//
// The oldest stays as long as somebody takes more of it, and the next one is retired in its stead:
// otherwise many slow readers, each of a snapshot of its own, would all begin again and again.
//
// Threads  a Snapshot is immutable; a SnapshotRing is guarded by its owner
#ifndef LATTICED_SERVER_ENGINE_RENDER_SNAPSHOT_H_
#define LATTICED_SERVER_ENGINE_RENDER_SNAPSHOT_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "absl/time/time.h"
#include "core/backend.h"
#include "core/ffd/deform_plan.h"
#include "core/ffd/quantisation_box.h"
#include "server/engine/render/chunk_table.h"

namespace latticed {

// What distinguishes views: watchers with the same key share one evaluation and one encoding.
struct ViewKey {
  ViewSpec spec;
  Encoding encoding = Encoding::kDracoPoints;
  friend auto operator<=>(const ViewKey&, const ViewKey&) = default;
};

// A view as one watcher asks for it.
struct WatchView {
  ViewKey key;
  // What segments are lowered for while edits come: server/engine/watch/level_of_detail.h. 0: no limit.
  uint64_t max_points = 0;
  uint64_t max_bytes_per_second = 0;
  // In force while a gesture is open. 0: the key's.
  int drag_position_bits = 0;
  int drag_normal_bits = 0;
};

struct Snapshot {
  uint64_t number = 0;  // rises within a view
  ViewKey view;
  uint64_t revision = 0;
  uint64_t structure_id = 0;
  QuantisationBox box;
  std::shared_ptr<const DeformPlan> plan;
  ChunkTable chunks;
  uint64_t held_bytes = 0;  // that the chunks keep; chunk_blocks.h
  absl::Time edit_time;     // when the edit that made the revision was committed
  absl::Duration evaluate_time;
  absl::Duration encode_time;
};

class SnapshotRing {
 public:
  // An oldest one that nobody has looked at for so long is retired first.
  static constexpr absl::Duration kStalled = absl::Seconds(5);

  // What left the ring, to be destroyed where no lock is held: its chunks may be a device's to free.
  struct Dropped {
    std::vector<std::shared_ptr<const Snapshot>> snapshots;
    size_t retired = 0;  // of them
  };
  // Makes `snapshot` the newest; drops what is not pinned, then retires what is above the limit.
  Dropped Publish(std::shared_ptr<const Snapshot> snapshot, absl::Time now);
  // Null before the first Publish.
  std::shared_ptr<const Snapshot> newest() const;
  // The newest, pinned until Unpin(number); null before the first Publish.
  std::shared_ptr<const Snapshot> PinNewest(absl::Time now);
  // The snapshot where that dropped it, as Dropped; null for a retired one.
  std::shared_ptr<const Snapshot> Unpin(uint64_t number);
  // For a watcher that takes more of it; null when it was retired.
  std::shared_ptr<const Snapshot> Find(uint64_t number, absl::Time now);
  size_t size() const { return entries_.size(); }
  // Of chunks; those that snapshots share count once.
  size_t bytes() const;
  // Of the snapshots' held_bytes: what is shared counts in each.
  uint64_t held_bytes() const;

 private:
  struct Entry {
    std::shared_ptr<const Snapshot> snapshot;
    int pins = 0;
    absl::Time last_taken;
  };
  std::deque<Entry>::iterator At(uint64_t number);

  std::deque<Entry> entries_;  // oldest first
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_SNAPSHOT_H_
