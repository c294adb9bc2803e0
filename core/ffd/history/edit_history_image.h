// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// All that an EditHistory holds, as data. EditHistory::image() takes it, EditHistory::FromImage goes on from it.
//
// Threads  plain data
#ifndef LATTICED_CORE_FFD_HISTORY_EDIT_HISTORY_IMAGE_H_
#define LATTICED_CORE_FFD_HISTORY_EDIT_HISTORY_IMAGE_H_

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "core/ffd/history/edit_layers.h"
#include "core/ffd/history/editor_ledger.h"
#include "core/ffd/lattice.h"

namespace latticed {

struct UndoneStep {
  EditStep step;
  std::string undone_by;
  uint64_t undone_at = 0;
};

struct EditHistoryImage {
  struct Result {
    std::string editor_id;
    EditSummary summary;
  };

  LayersBase base;
  std::deque<EditStep> steps;      // oldest first
  std::vector<UndoneStep> undone;  // in the order in which they were undone
  std::vector<Result> results;     // of the editor who was silent longest first
  uint64_t revision = 0;
  uint64_t structure_id = 1;
  uint64_t clock = 0;
  uint64_t records = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_HISTORY_EDIT_HISTORY_IMAGE_H_
