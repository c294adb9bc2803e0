// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A volume that one of a session's lattices keeps, whichever is edited.
#include <cmath>
#include <set>
#include <utility>

#include "fmt/format.h"
#include "tests/server/mixed/mixed_session.h"

namespace latticed::testing {
namespace {

constexpr double kVolumeSlack = 1e-12 + 4e-16;  // and rounding
constexpr int kEdits = 4;

}  // namespace

void MixedSession::KeepVolume() {
  const auto chunks = Chunks();
  const MixedModel before = model_;
  kept_ = Kept{.keeper = AnyPresent(), .steps = {}, .states = {States()}};
  const uint32_t keeper = kept_->keeper;
  v1::EditBatch batch = Batch(keeper);
  v1::Constraints& constraints =
      *batch.add_edits()->mutable_set_constraints()->mutable_constraints();
  constraints = LatticeAt(keeper).constraints();
  constraints.mutable_volume();
  ASSERT_OK(Apply(batch));
  kept_->steps.push_back(keeper);
  kept_->states.push_back(States());
  for (int n = 0; n < kEdits && !HasFailure(); ++n) {
    EditWithVolume();
    ExpectModel();
    if (Below(4) == 0) RestartServer();
  }
  UndoAll();
  model_ = before;
  for (const uint32_t number : std::set(kept_->steps.begin(), kept_->steps.end())) {
    ForgetUndone(number);
  }
  kept_.reset();
  EXPECT_TRUE(Chunks() == chunks) << "undone";
}

// Control points that move to keep the shape of a higher degree would not keep it if they kept the volume, too; so Elevate() is
// not here. An addition that was undone could not be kept from being redone.
void MixedSession::EditWithVolume() {
  switch (Below(8)) {
    case 0:
      return SetStrength();
    case 1:
      return model_.Now(0).present ? SetWeights() : MovePoints();
    case 2:
      return ChangeOutside();
    case 3:
      return RemoveAny();
    case 4:  // keeps the volume that there is
      return kept_->steps.size() > 1 ? InsertKnot() : MovePoints();
    case 5:
      return DragPoints();
    default:
      return MovePoints();
  }
}

void MixedSession::Follow(uint32_t number) {
  const uint32_t keeper = kept_->keeper;
  kept_->steps.push_back(number);
  kept_->states.push_back(States());
  NumberState& state = model_.Now(keeper);
  if (!state.present) return;
  if (keeper != number) {
    std::vector<Vec3d> points = LatticeOf(LatticeAt(keeper)).control_points;
    ExpectHeld(keeper, points);
    state.lattice.control_points = std::move(points);
  }
  EXPECT_LE(std::abs(MeasuredVolume() - 1), kVolumeSlack);
  ++counts_["volumes kept"];
}

void MixedSession::UndoAll() {
  auto& [keeper, steps, states] = *kept_;
  for (size_t n = steps.size(); n > 0 && !HasFailure(); --n) {
    ASSERT_OK(Apply(Undo(steps[n - 1]))) << n;
    EXPECT_EQ(States(), states[n - 1]) << n;
  }
}

std::vector<std::string> MixedSession::States() {
  std::vector<std::string> states;
  for (const uint32_t number : Numbers()) {
    v1::LatticeState state = LatticeAt(number);
    state.clear_revision();
    state.clear_structure_id();
    states.push_back(state.SerializeAsString());
  }
  return states;
}

void MixedSession::ForgetUndone(uint32_t number) {
  if (!model_.Now(number).present) return;
  v1::EditBatch batch = Push(number, AnyPoint(number), {0.1, 0, 0});
  batch.set_gesture_id(fmt::format("gesture {}", sequence_));
  ASSERT_OK(Apply(batch));
  EndGesture(number, batch.gesture_id(), v1::GESTURE_PHASE_CANCEL);
  model_.ForgetUndone(number);
}

}  // namespace latticed::testing
