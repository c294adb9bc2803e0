// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A client's random session: edits, drags, carried control points, gestures, refused folds, constraints, kept volumes, knots,
// undo and redo, point sets, and restarts of the server on its folder, also within a gesture. A seventh of the scenes is
// plain, two sevenths go on outside, one has vertex weights, two have two lattices, parallel ones and turned ones, and one has
// weights and turned lattices. After each step the test compares with a model:
//
//   a refused batch       changes nothing, and each restart neither
//   an edit               puts the control points where the definition puts them; one of a gesture begins at its begin
//   a drag                leaves the points as far from their targets as it says
//   a cancelled gesture   leaves the lattice as it was; another one is one step of undo
//   undo and redo         bring back the lattice and the constraints that the model has, bit by bit
//   held control points   do not move
//   a kept volume         is kept to 1e-12 of it, whichever lattice is edited
//   refuse_folds          leaves a certified scene certified
//   a point set           has the positions of the definition, and so have points of the surface
#include <cstdio>
#include <utility>

#include "fmt/format.h"
#include "tests/server/points/random_session.h"

namespace latticed::testing {
namespace {

constexpr int kRandomSessions = 14, kSessionSteps = 30, kMostKnots = 3;

class EditedAtRandom : public RandomSession {
 protected:
  void TakeStep() {
    if (is_of_two() && Below(4) == 0) MoveOther();
    switch (Below(14)) {
      case 0:
      case 1:
        return UndoOrRedo(/*undo=*/Below(undone_.empty() ? 4 : 2) != 0);
      case 2:
        if (Send(Constrain())) Done(before_);
        return;
      case 3:
        if (knots_ < kMostKnots && Send(InsertKnot())) {
          ++knots_;
          ++counts_["knots inserted"];
          Done(before_);
        }
        return;
      case 4:
        return RestartAndCompare();
      case 5:
      case 6:
      case 7:
        return MakeGesture();
      default:
        return Edit();
    }
  }

 private:
  void RestartAndCompare() {
    const std::string state = state_.SerializeAsString();
    Restart();
    EXPECT_EQ(State().SerializeAsString(), state) << "a restart changes nothing";
    ++counts_["restarts"];
  }
  void Edit() {
    const v1::EditBatch batch = Change();
    const bool certified = IsCertified();
    if (!Send(batch)) return;
    Done(before_);
    ExpectHeld();
    ExpectEffect(batch, before_);
    if (batch.refuse_folds() && certified) {
      EXPECT_TRUE(IsCertified());
    }
  }
  void ExpectEffect(const v1::EditBatch& batch, const v1::LatticeState& begin) {
    if (KeepsVolume(batch) || IsFollowed(batch)) ExpectVolume();
    // The lattice that follows a drag moves its points once more.
    const bool moves_on = IsFollowed(batch) && batch.edits(0).has_drag_points();
    if (!KeepsVolume(batch) && !moves_on) ExpectChange(batch.edits(0), begin);
    if (IsFollowed(batch)) ++counts_["edits that are followed"];
  }
  // Updates, each from the lattice at the begin, then one of the ways in which gestures end.
  void MakeGesture() {
    const v1::LatticeState begin = state_;
    const std::string other = OtherPoints();
    const std::string id = fmt::format("gesture {}", sequence_);
    bool is_open = false;
    for (int update = Below(3); update >= 0; --update) {
      // What it moves is chosen from the lattice of the begin: a target is no place of an update before.
      const v1::LatticeState now = std::exchange(state_, begin);
      v1::EditBatch batch = Change();
      state_ = now;
      batch.set_gesture_id(id);
      if (!Send(batch)) continue;
      is_open = true;
      ExpectHeld();
      ExpectEffect(batch, begin);
      if (Below(6) == 0) RestartAndCompare();
    }
    if (!is_open) return;
    const int end = Below(3);
    if (end < 2) {
      v1::EditBatch batch = Batch();
      batch.clear_edits();
      batch.set_gesture_id(id);
      batch.set_gesture_phase(end == 0 ? v1::GESTURE_PHASE_CANCEL : v1::GESTURE_PHASE_COMMIT);
      ASSERT_TRUE(Send(batch));
    }  // else the next step ends it
    ++counts_[end == 0 ? "gestures cancelled" : "gestures committed"];
    if (end == 0) {
      EXPECT_EQ(UndoableOf(state_), UndoableOf(begin)) << "cancelled";
      EXPECT_EQ(OtherPoints(), other) << "cancelled";
      undone_.clear();  // by its first update
    } else {
      Done(begin);
    }
  }
  void Done(const v1::LatticeState& before) {
    undone_.clear();
    done_.push_back(UndoableOf(before));
  }
  void UndoOrRedo(bool undo) {
    std::vector<Undoable>&from = undo ? done_ : undone_, &to = undo ? undone_ : done_;
    v1::EditBatch batch = Batch();
    if (undo) {
      batch.mutable_edits(0)->mutable_undo();
    } else {
      batch.mutable_edits(0)->mutable_redo();
    }
    ASSERT_EQ(Send(batch), !from.empty());
    if (from.empty()) return;
    EXPECT_EQ(UndoableOf(state_), from.back()) << (undo ? "undo" : "redo");
    to.push_back(UndoableOf(before_));
    from.pop_back();
    ++counts_[undo ? "undone" : "redone"];
  }

  std::vector<Undoable> done_, undone_;  // what undo and redo bring back
  int knots_ = 0;
};

TEST_P(EditedAtRandom, KeepsWhatItPromises) {
  for (int step = 0; step < kSessionSteps && !HasFailure(); ++step) {
    SCOPED_TRACE(step);
    TakeStep();
    ExpectDefinition();
  }
  for (const auto& [what, count] : counts_) std::printf("%s: %d\n", what.c_str(), count);
  EXPECT_GE(counts_["applied"], kSessionSteps / 3);
}

INSTANTIATE_TEST_SUITE_P(Seeds, EditedAtRandom, ::testing::Range(0, kRandomSessions));

}  // namespace
}  // namespace latticed::testing
