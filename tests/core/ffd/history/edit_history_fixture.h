// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// An edit history over the unit cube, its clock, and short helpers to apply batches.
#ifndef LATTICED_TESTS_CORE_FFD_HISTORY_EDIT_HISTORY_FIXTURE_H_
#define LATTICED_TESTS_CORE_FFD_HISTORY_EDIT_HISTORY_FIXTURE_H_

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/ffd/history/edit_history.h"
#include "tests/support/status_matchers.h"

namespace latticed {

inline Bounds UnitBounds() {
  Bounds bounds;
  bounds.Extend(Vec3d{0, 0, 0});
  bounds.Extend(Vec3d{1, 1, 1});
  return bounds;
}

inline Lattice UnitLattice() { return *FitLattice(UnitBounds(), {4, 4, 4}, {2, 2, 2}, 0); }

class EditHistoryTest : public ::testing::Test {
 protected:
  using Batch = EditBatch;

  absl::StatusOr<EditOutcome> Apply(EditBatch batch) {
    if (batch.sequence == 0) batch.sequence = ++sequences_[batch.editor_id];
    if (batch.structure_id == 0) batch.structure_id = history_.structure_id();
    return history_.Apply(batch, now_, [this](const LatticeStructure&) { return admission_; });
  }
  absl::StatusOr<EditOutcome> Do(const std::string& editor, Edit edit) {
    return Apply({.editor_id = editor, .edits = {std::move(edit)}});
  }
  absl::StatusOr<EditOutcome> Drag(const std::string& editor, const std::string& gesture,
                                   std::vector<uint32_t> points, double x,
                                   GesturePhase phase = GesturePhase::kUpdate) {
    return Apply({.editor_id = editor,
                  .gesture_id = gesture,
                  .gesture_phase = phase,
                  .edits = {MoveControlPoints{std::move(points), {x, 0, 0}}}});
  }
  absl::StatusOr<EditOutcome> End(const std::string& editor, const std::string& gesture,
                                  GesturePhase phase) {
    return Apply({.editor_id = editor, .gesture_id = gesture, .gesture_phase = phase});
  }
  static Edit Move(std::vector<uint32_t> points, double x) {
    return MoveControlPoints{std::move(points), {x, 0, 0}};
  }
  static std::string Reason(const absl::StatusOr<EditOutcome>& result) {
    return error::DetailsOf(result.status()).reason;
  }
  // How far control point i is from its start, along x.
  double Moved(size_t i) const {
    return history_.lattice().control_points[i].x - history_.initial().control_points[i].x;
  }
  bool AtStart() const {
    return history_.lattice().control_points == history_.initial().control_points;
  }

  EditHistory history_{UnitLattice()};
  std::map<std::string, uint64_t> sequences_;
  EditHistory::TimePoint now_;
  absl::Status admission_;
};

}  // namespace latticed

#endif  // LATTICED_TESTS_CORE_FFD_HISTORY_EDIT_HISTORY_FIXTURE_H_
