// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Keeps the last sequence, with its result, of each editor that a scene remembers, so that a batch that is sent twice
// is applied once.
//
// Errors   none
// Threads  plain data
#ifndef LATTICED_CORE_FFD_HISTORY_EDITOR_LEDGER_H_
#define LATTICED_CORE_FFD_HISTORY_EDITOR_LEDGER_H_

#include <chrono>
#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "absl/status/status.h"

namespace latticed {

struct FoldReport;  // core/folds/fold_report.h

// The result of a batch, as its editor receives it.
struct EditSummary {
  uint64_t sequence = 0;
  absl::Status status;
  uint64_t revision = 0;      // of the scene after the batch
  uint64_t structure_id = 0;  // of the scene after the batch
  uint64_t boxes_touched = 0;
  uint64_t patches_touched = 0;
  double largest_move = 0;   // of a control point, world units; 0 where the structure changed
  double drag_residual = 0;  // of EditTarget
  // Set by the scene. Empty in the stored result, which a repeated batch gets.
  std::optional<std::chrono::steady_clock::time_point> commit_time;
  // Where the deformation folds after the batch. Set by scenes that watch folds; empty in the stored result as well.
  std::shared_ptr<const FoldReport> folds;
};

class EditorLedger {
 public:
  struct Entry {
    std::string editor_id;
    EditSummary summary;
  };

  explicit EditorLedger(size_t capacity) : capacity_(capacity) {}
  EditorLedger(const EditorLedger&) = delete;  // by_editor_ would point into the other one
  EditorLedger& operator=(const EditorLedger&) = delete;
  EditorLedger(EditorLedger&&) = default;
  EditorLedger& operator=(EditorLedger&&) = default;

  // nullptr for an editor that is not remembered. The pointer is valid until the next Store or ForgetOldest.
  EditSummary* Find(std::string_view editor_id) const;
  // Keeps `summary`, and forgets the editor that has been silent longest when there are too many.
  void Store(std::string_view editor_id, EditSummary summary);
  size_t size() const { return entries_.size(); }
  // Of the editor who was heard last first.
  const std::list<Entry>& entries() const { return entries_; }
  // Forgets the editor that was silent longest. Returns false where only one is left.
  bool ForgetOldest();
  size_t MemoryBytes() const { return bytes_; }

 private:
  static size_t BytesOf(const Entry& entry);
  void DropOldest();

  size_t capacity_;
  size_t bytes_ = 0;
  std::list<Entry> entries_;  // most recent first
  // Keys point into entries_, whose nodes do not move.
  std::unordered_map<std::string_view, std::list<Entry>::iterator> by_editor_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_HISTORY_EDITOR_LEDGER_H_
