// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The snapshots of a view that are still needed: the newest, and those that a watcher is being sent
// (pinned), at most limits::kMaxSnapshotsPerView and within the bytes that the view has reserved.
//
// A pinned snapshot that leaves the ring is *retired*: its watcher finds nothing under the number any
// more and begins again with the newest. Bytes that a socket still holds live until it lets go.
//
// The oldest stays as long as somebody takes more of it, and the next one is retired in its stead:
// otherwise many slow readers, each of a snapshot of its own, would all begin again and again.
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
  // The oldest is retired first once nobody has looked at it for so long.
  static constexpr absl::Duration kStalled = absl::Seconds(5);

  // What left the ring, to be destroyed where no lock is held: its chunks may be a device's to free.
  struct Dropped {
    std::vector<std::shared_ptr<const Snapshot>> snapshots;
    size_t retired = 0;  // of them
  };
  // Makes `snapshot` the newest. Drops what is not pinned, then retires what is above the limit, or
  // what does not fit into `most_bytes` together with it.
  Dropped Publish(std::shared_ptr<const Snapshot> snapshot, absl::Time now,
                  uint64_t most_bytes = std::numeric_limits<uint64_t>::max());
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

#endif  // LATTICED_SERVER_ENGINE_RENDER_SNAPSHOT_RING_H_
