// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/history/editor_ledger.h"

#include <utility>

#include "absl/strings/cord.h"

namespace latticed {

size_t EditorLedger::BytesOf(const Entry& entry) {
  // The nodes of list and map, and the allocations of an error status.
  constexpr size_t kNodes = 96, kRefusal = 96;
  size_t bytes = sizeof(Entry) + kNodes + entry.editor_id.capacity();
  if (entry.summary.status.ok()) return bytes;
  bytes += kRefusal + entry.summary.status.message().size();
  entry.summary.status.ForEachPayload([&](absl::string_view url, const absl::Cord& payload) {
    bytes += url.size() + payload.size();
  });
  return bytes;
}

EditSummary* EditorLedger::Find(std::string_view editor_id) const {
  const auto found = by_editor_.find(editor_id);
  return found == by_editor_.end() ? nullptr : &found->second->summary;
}

void EditorLedger::Store(std::string_view editor_id, EditSummary summary) {
  if (const auto found = by_editor_.find(editor_id); found != by_editor_.end()) {
    Entry& entry = *found->second;
    bytes_ -= BytesOf(entry);
    entry.summary = std::move(summary);
    bytes_ += BytesOf(entry);
    entries_.splice(entries_.begin(), entries_, found->second);
    return;
  }
  entries_.push_front({std::string(editor_id), std::move(summary)});
  by_editor_.emplace(entries_.front().editor_id, entries_.begin());
  bytes_ += BytesOf(entries_.front());
  if (entries_.size() > capacity_) DropOldest();
}

bool EditorLedger::ForgetOldest() {
  if (entries_.size() <= 1) return false;
  DropOldest();
  return true;
}

void EditorLedger::DropOldest() {
  bytes_ -= BytesOf(entries_.back());
  by_editor_.erase(entries_.back().editor_id);
  entries_.pop_back();
}

}  // namespace latticed
