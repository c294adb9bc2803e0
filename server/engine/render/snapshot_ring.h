// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The snapshots of a view that are still needed: the newest, and those that a watcher is being sent
// (pinned), at most limits::kMaxSnapshotsPerView and within the bytes that the view has reserved.
//
// A pinned snapshot that leaves the ring is *retired*: its watcher no longer finds it and begins again with
// the newest. Bytes that are queued at a socket stay in memory until they are sent.
//
// The oldest snapshot stays as long as somebody takes more of it, and the next older one is retired in its
// place. Otherwise many slow readers, each of another snapshot, would all begin again and again.
//
// Threads  guarded by its owner
#ifndef LATTICED_SERVER_ENGINE_RENDER_SNAPSHOT_RING_H_
#define LATTICED_SERVER_ENGINE_RENDER_SNAPSHOT_RING_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <vector>

#include "absl/time/time.h"
#include "server/engine/render/snapshot.h"

namespace latticed {

class SnapshotRing {
 public:
  // When nobody has taken more of the oldest snapshot for so long, it is retired first.
  static constexpr absl::Duration kStalled = absl::Seconds(5);

  // Snapshots that left the ring. They are destroyed with no lock held, because freeing chunks of a device
  // may take long.
  struct Dropped {
    std::vector<std::shared_ptr<const Snapshot>> snapshots;
    size_t retired = 0;  // how many of them were retired
  };
  // Makes `snapshot` the newest. Drops the snapshots that are not pinned. Then retires others while there are
  // more than the limit, or while all together take more than `most_bytes`.
  Dropped Publish(std::shared_ptr<const Snapshot> snapshot, absl::Time now,
                  uint64_t most_bytes = std::numeric_limits<uint64_t>::max());
  // Null before the first Publish.
  std::shared_ptr<const Snapshot> newest() const;
  // The newest, pinned until Unpin(number); null before the first Publish.
  std::shared_ptr<const Snapshot> PinNewest(absl::Time now);
  // Returns the snapshot if this dropped it, to be destroyed as Dropped is; else null.
  std::shared_ptr<const Snapshot> Unpin(uint64_t number);
  // Called by a watcher that takes more of the snapshot. Null when it was retired.
  std::shared_ptr<const Snapshot> Find(uint64_t number, absl::Time now);
  size_t size() const { return entries_.size(); }
  // The bytes of all chunks; a chunk that snapshots share counts once.
  size_t bytes() const;
  // The sum of the snapshots' held_bytes; what they share counts in each.
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

#endif  // LATTICED_SERVER_ENGINE_RENDER_SNAPSHOT_RING_H_
