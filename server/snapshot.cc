// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/snapshot.h"

#include <algorithm>
#include <utility>

#include "absl/container/flat_hash_set.h"
#include "core/base/limits.h"

namespace latticed {

void SnapshotRing::Publish(std::shared_ptr<const Snapshot> snapshot) {
  DropUnpinned();
  entries_.push_back({std::move(snapshot), 0});
  while (entries_.size() > static_cast<size_t>(limits::kMaxSnapshotsPerView)) entries_.pop_front();
}

std::shared_ptr<const Snapshot> SnapshotRing::newest() const {
  return entries_.empty() ? nullptr : entries_.back().snapshot;
}

std::shared_ptr<const Snapshot> SnapshotRing::PinNewest() {
  if (entries_.empty()) return nullptr;
  ++entries_.back().pins;
  return entries_.back().snapshot;
}

void SnapshotRing::Unpin(uint64_t number) {
  const auto entry = std::ranges::find_if(
      entries_, [number](const Entry& e) { return e.snapshot->number == number; });
  if (entry == entries_.end()) return;
  --entry->pins;
  // The newest stays: the next watcher begins with it.
  if (entry->pins == 0 && entry->snapshot != entries_.back().snapshot) entries_.erase(entry);
}

std::shared_ptr<const Snapshot> SnapshotRing::Find(uint64_t number) const {
  const auto entry = std::ranges::find_if(
      entries_, [number](const Entry& e) { return e.snapshot->number == number; });
  return entry == entries_.end() ? nullptr : entry->snapshot;
}

size_t SnapshotRing::bytes() const {
  absl::flat_hash_set<const uint8_t*> seen;
  size_t sum = 0;
  for (const Entry& entry : entries_) {
    for (const SnapshotChunk& chunk : entry.snapshot->chunks) {
      if (seen.insert(chunk.data.data).second) sum += chunk.data.size;
    }
  }
  return sum;
}

void SnapshotRing::DropUnpinned() {
  std::erase_if(entries_, [](const Entry& entry) { return entry.pins == 0; });
}

}  // namespace latticed
