// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/snapshot_ring.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "absl/container/flat_hash_set.h"
#include "core/base/limits.h"

namespace latticed {

SnapshotRing::Dropped SnapshotRing::Publish(std::shared_ptr<const Snapshot> snapshot,
                                            absl::Time now, uint64_t most_bytes) {
  Dropped dropped;
  for (const Entry& entry : entries_) {
    if (entry.pins == 0) dropped.snapshots.push_back(entry.snapshot);
  }
  std::erase_if(entries_, [](const Entry& entry) { return entry.pins == 0; });
  entries_.push_back({std::move(snapshot), 0, now});
  constexpr auto kMost = static_cast<size_t>(limits::kMaxSnapshotsPerView);
  while (entries_.size() > 1 && (entries_.size() > kMost || held_bytes() > most_bytes)) {
    const bool stalled = now - entries_.front().last_taken >= kStalled;
    const bool first = stalled || entries_.size() == 2;  // of two, the second is the newest
    const auto entry = first ? entries_.begin() : std::next(entries_.begin());
    dropped.snapshots.push_back(std::move(entry->snapshot));
    entries_.erase(entry);
    ++dropped.retired;
  }
  return dropped;
}

std::shared_ptr<const Snapshot> SnapshotRing::newest() const {
  return entries_.empty() ? nullptr : entries_.back().snapshot;
}

std::shared_ptr<const Snapshot> SnapshotRing::PinNewest(absl::Time now) {
  if (entries_.empty()) return nullptr;
  Entry& entry = entries_.back();
  ++entry.pins;
  entry.last_taken = now;
  return entry.snapshot;
}

std::deque<SnapshotRing::Entry>::iterator SnapshotRing::At(uint64_t number) {
  return std::ranges::find_if(
      entries_, [number](const Entry& entry) { return entry.snapshot->number == number; });
}

std::shared_ptr<const Snapshot> SnapshotRing::Unpin(uint64_t number) {
  const auto entry = At(number);
  if (entry == entries_.end()) return nullptr;
  --entry->pins;
  // The newest snapshot stays: the next watcher begins with it.
  if (entry->pins > 0 || entry->snapshot == entries_.back().snapshot) return nullptr;
  auto dropped = std::move(entry->snapshot);
  entries_.erase(entry);
  return dropped;
}

std::shared_ptr<const Snapshot> SnapshotRing::Find(uint64_t number, absl::Time now) {
  const auto entry = At(number);
  if (entry == entries_.end()) return nullptr;
  entry->last_taken = now;
  return entry->snapshot;
}

size_t SnapshotRing::bytes() const {
  absl::flat_hash_set<const uint8_t*> seen;
  size_t sum = 0;
  for (const Entry& entry : entries_) {
    const ChunkTable& chunks = entry.snapshot->chunks;
    for (size_t c = 0; c < chunks.size(); ++c) {
      const std::span<const uint8_t> data = chunks[c].data;
      if (seen.insert(data.data()).second) sum += data.size();
    }
  }
  return sum;
}

uint64_t SnapshotRing::held_bytes() const {
  uint64_t sum = 0;
  for (const Entry& entry : entries_) sum += entry.snapshot->held_bytes;
  return sum;
}

}  // namespace latticed
