// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the log of a scene has of an editor who moves ten control points, moves them back a millisecond later, and goes on
// with ten others.
//
// Errors   none: a refused edit ends the program
#ifndef LATTICED_TESTS_BENCH_STORE_EDITED_HISTORY_H_
#define LATTICED_TESTS_BENCH_STORE_EDITED_HISTORY_H_

#include <string>
#include <utility>

#include "core/ffd/history/edit_history.h"
#include "server/engine/scene/scene_replay.h"

namespace latticed::bench {

class EditedHistory {
 public:
  static constexpr int kMoved = 10;

  // Goes on from there. The lattice has at least 200 control points.
  explicit EditedHistory(SceneLife life) : life_(std::move(life)) {}

  const SceneHistory& history() const { return life_.history; }
  // Ends the edits.
  SceneHistory TakeHistory() { return std::move(life_.history); }
  // Makes an edit, and its record.
  [[nodiscard]] std::string NextRecord();
  // Of all edits up to now.
  [[nodiscard]] std::string Snapshot() const;

 private:
  SceneLife life_;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_STORE_EDITED_HISTORY_H_
