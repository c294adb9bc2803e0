// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/editor_ledger.h"

#include <utility>

namespace latticed {

const EditSummary* EditorLedger::Find(std::string_view editor_id) const {
  const auto found = by_editor_.find(editor_id);
  return found == by_editor_.end() ? nullptr : &found->second->summary;
}

EditSummary* EditorLedger::Find(std::string_view editor_id) {
  const auto found = by_editor_.find(editor_id);
  return found == by_editor_.end() ? nullptr : &found->second->summary;
}

void EditorLedger::Store(std::string_view editor_id, EditSummary summary) {
  if (const auto found = by_editor_.find(editor_id); found != by_editor_.end()) {
    found->second->summary = std::move(summary);
    entries_.splice(entries_.begin(), entries_, found->second);
    return;
  }
  entries_.push_front({std::string(editor_id), std::move(summary)});
  by_editor_.emplace(entries_.front().editor_id, entries_.begin());
  if (entries_.size() > capacity_) {
    by_editor_.erase(entries_.back().editor_id);
    entries_.pop_back();
  }
}

}  // namespace latticed
