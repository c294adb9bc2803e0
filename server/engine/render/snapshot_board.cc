// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/snapshot_board.h"

namespace latticed {

void SnapshotBoard::Attach(absl::Time now) {
  const MutexLock lock(&mutex_);
  ++watchers_;
  last_watched_ = now;
  wanted_ = true;
  failure_ = absl::OkStatus();
}

void SnapshotBoard::Detach(absl::Time now) {
  const MutexLock lock(&mutex_);
  --watchers_;
  last_watched_ = now;
}

bool SnapshotBoard::watched() const {
  const MutexLock lock(&mutex_);
  return watchers_ > 0;
}

absl::Time SnapshotBoard::last_watched(absl::Time now) const {
  const MutexLock lock(&mutex_);
  return watchers_ > 0 ? now : last_watched_;
}

bool SnapshotBoard::Want(uint64_t number) {
  const MutexLock lock(&mutex_);
  return number == last_number_ && !std::exchange(wanted_, true);
}

bool SnapshotBoard::wanted() const {
  const MutexLock lock(&mutex_);
  return wanted_;
}

size_t SnapshotBoard::Publish(std::shared_ptr<Snapshot> snapshot, absl::Time now,
                              uint64_t most_bytes) {
  SnapshotRing::Dropped dropped;  // destroyed after the lock is released
  const MutexLock lock(&mutex_);
  snapshot->number = ++last_number_;
  wanted_ = false;
  dropped = ring_.Publish(std::move(snapshot), now, most_bytes);
  return dropped.retired;
}

std::shared_ptr<const Snapshot> SnapshotBoard::newest() const {
  const MutexLock lock(&mutex_);
  return ring_.newest();
}

void SnapshotBoard::Fail(const absl::Status& status) {
  const MutexLock lock(&mutex_);
  failure_ = status;
}

absl::Status SnapshotBoard::failure() const {
  const MutexLock lock(&mutex_);
  return failure_;
}

uint64_t SnapshotBoard::chunk_bytes() const {
  const MutexLock lock(&mutex_);
  return ring_.bytes();
}

uint64_t SnapshotBoard::held_bytes() const {
  const MutexLock lock(&mutex_);
  return ring_.held_bytes();
}

std::shared_ptr<const Snapshot> SnapshotBoard::PinNewest(absl::Time now) {
  const MutexLock lock(&mutex_);
  return ring_.PinNewest(now);
}

void SnapshotBoard::Unpin(uint64_t number) {
  std::shared_ptr<const Snapshot> dropped;  // destroyed after the lock is released
  const MutexLock lock(&mutex_);
  dropped = ring_.Unpin(number);
}

std::shared_ptr<const Snapshot> SnapshotBoard::Find(uint64_t number, absl::Time now) {
  const MutexLock lock(&mutex_);
  return ring_.Find(number, now);
}

std::optional<SnapshotLease> SnapshotLease::OfNewest(std::shared_ptr<SnapshotBoard> board,
                                                     absl::Time now) {
  const auto snapshot = board->PinNewest(now);
  if (snapshot == nullptr) return std::nullopt;
  return SnapshotLease(std::move(board), snapshot->number);
}

}  // namespace latticed
