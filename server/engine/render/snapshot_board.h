// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The door between a view and its watchers. The view publishes snapshots here, and looks whether a
// newer one is wanted; watchers take them. Neither knows the other.
//
//   view      wanted? -> Publish(snapshot) | Fail(status)
//   watcher   Attach, Want(the number that it has) -> newest, Lease -> Detach
//
// Back-pressure: a snapshot is wanted when some watcher could take it at once. Publish ends the want, so
// a view is at most one snapshot ahead of its fastest watcher.
//
// Threads  safe
#ifndef LATTICED_SERVER_ENGINE_RENDER_SNAPSHOT_BOARD_H_
#define LATTICED_SERVER_ENGINE_RENDER_SNAPSHOT_BOARD_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "server/engine/render/snapshot_ring.h"

namespace latticed {

class SnapshotBoard {
 public:
  SnapshotBoard(const ViewKey& key, absl::Time now) : key_(key), last_watched_(now) {}
  SnapshotBoard(const SnapshotBoard&) = delete;  // leases hold its address
  SnapshotBoard& operator=(const SnapshotBoard&) = delete;

  const ViewKey& key() const { return key_; }

  // Counts the watchers that take updates; paused ones do not. A new watcher wants a snapshot. It also clears
  // a failure, so that the view is tried again.
  void Attach(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);
  void Detach(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);
  bool watched() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns `now` while somebody watches.
  absl::Time last_watched(absl::Time now) const ABSL_LOCKS_EXCLUDED(mutex_);
  // Says that a watcher could take a snapshot newer than `number` at once; 0: it has none. Returns whether
  // this is new, so that the view should look.
  [[nodiscard]] bool Want(uint64_t number) ABSL_LOCKS_EXCLUDED(mutex_);
  bool wanted() const ABSL_LOCKS_EXCLUDED(mutex_);

  // Publishes the snapshot under the next number. Snapshots that this drops are destroyed without the lock.
  // Returns how many were retired. `most_bytes` as in SnapshotRing::Publish.
  size_t Publish(std::shared_ptr<Snapshot> snapshot, absl::Time now, uint64_t most_bytes)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Null before the first Publish.
  [[nodiscard]] std::shared_ptr<const Snapshot> newest() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Says why the view cannot be evaluated any more. Its watchers end with this status.
  void Fail(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] absl::Status failure() const ABSL_LOCKS_EXCLUDED(mutex_);

  // As SnapshotRing::bytes and SnapshotRing::held_bytes.
  uint64_t chunk_bytes() const ABSL_LOCKS_EXCLUDED(mutex_);
  uint64_t held_bytes() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  friend class SnapshotLease;
  std::shared_ptr<const Snapshot> PinNewest(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);
  void Unpin(uint64_t number) ABSL_LOCKS_EXCLUDED(mutex_);
  std::shared_ptr<const Snapshot> Find(uint64_t number, absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);

  const ViewKey key_;
  mutable Mutex mutex_;
  int watchers_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Time last_watched_ ABSL_GUARDED_BY(mutex_);
  bool wanted_ ABSL_GUARDED_BY(mutex_) = true;
  uint64_t last_number_ ABSL_GUARDED_BY(mutex_) = 0;
  SnapshotRing ring_ ABSL_GUARDED_BY(mutex_);
  absl::Status failure_ ABSL_GUARDED_BY(mutex_);
};

// Pins the snapshot that was the newest when it was made: the board keeps it, unless it is retired.
class SnapshotLease {
 public:
  // nullopt when nothing is published.
  [[nodiscard]] static std::optional<SnapshotLease> OfNewest(std::shared_ptr<SnapshotBoard> board,
                                                             absl::Time now);
  SnapshotLease(SnapshotLease&& other) noexcept
      : board_(std::exchange(other.board_, nullptr)), number_(other.number_) {}
  SnapshotLease& operator=(SnapshotLease&& other) noexcept {
    std::swap(board_, other.board_);
    std::swap(number_, other.number_);
    return *this;
  }
  ~SnapshotLease() {
    if (board_ != nullptr) board_->Unpin(number_);
  }

  const std::shared_ptr<SnapshotBoard>& board() const { return board_; }
  uint64_t number() const { return number_; }
  // Null when it was retired.
  [[nodiscard]] std::shared_ptr<const Snapshot> Get(absl::Time now) const {
    return board_->Find(number_, now);
  }

 private:
  SnapshotLease(std::shared_ptr<SnapshotBoard> board, uint64_t number)
      : board_(std::move(board)), number_(number) {}

  std::shared_ptr<SnapshotBoard> board_;
  uint64_t number_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_SNAPSHOT_BOARD_H_
