// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// set_weights in a history that keeps a volume: what restores it belongs to the step, to its undo and to its record.
#include "core/base/limits.h"
#include "tests/core/ffd/history/edit_sessions.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;

class WeightsHistoryTest : public EditHistoryTest {
 protected:
  void SetUp() override {
    ASSERT_OK(history_.MadeWith(nullptr, 8));
    ASSERT_OK(DoKept({SetConstraints{{.volume = KeptVolume{.volume = 2}}}}));
  }
  absl::StatusOr<EditOutcome> DoKept(EditBatch batch) {
    batch.editor_id = "ann";
    batch.sequence = ++sequences_["ann"];
    batch.structure_id = history_.structure_id();
    last_ = batch;
    return history_.Apply(
        batch, now_, [](const auto&) { return absl::OkStatus(); }, admit_points_, &keeper_,
        [](const auto&) { return absl::OkStatus(); });
  }
  absl::StatusOr<EditOutcome> DoKept(Edit edit) { return DoKept(EditBatch{.edits = {edit}}); }
  double FirstHeight() const { return history_.lattice().control_points[0].z; }

  const ScriptedKeeper keeper_{};  // moves the first point by 0.02
  AdmitPoints admit_points_;
  EditBatch last_;
};

TEST_F(WeightsHistoryTest, TheStepHasWhatRestoresTheVolume) {
  ASSERT_OK(DoKept(SetWeights{{1}, {0.5f}}));
  EXPECT_EQ(FirstHeight(), 0.02);
  EXPECT_EQ(history_.weights()->at(1), 0.5f);
  ASSERT_OK(DoKept(Undo{}));
  EXPECT_EQ(FirstHeight(), 0);
  EXPECT_EQ(history_.weights(), nullptr);
  ASSERT_OK(DoKept(Redo{}));
  EXPECT_EQ(FirstHeight(), 0.02);
  EXPECT_EQ(history_.weights()->at(1), 0.5f);
}

TEST_F(WeightsHistoryTest, RefusedPointsChangeNothing) {
  admit_points_ = [](const auto&, auto points, double) {
    return points[0].z > 0 ? absl::FailedPreconditionError("too high") : absl::OkStatus();
  };
  EXPECT_THAT(DoKept(SetWeights{{1}, {0.5f}}), StatusIs(absl::StatusCode::kFailedPrecondition));
  EXPECT_EQ(FirstHeight(), 0);
  EXPECT_EQ(history_.weights(), nullptr);
  EXPECT_EQ(history_.structure_id(), 1u);
}

TEST_F(WeightsHistoryTest, WithoutALatticeTheyMoveNothing) {
  ASSERT_OK(DoKept(SetWeights{{1}, {0.5f}}));
  ASSERT_OK(DoKept(Undo{}));
  ASSERT_OK(Do("bob", RemoveLattice{}));
  EXPECT_EQ(Reason(DoKept(Redo{})), "LATTICE_REMOVED");
  EXPECT_EQ(Reason(DoKept({.edits = {SetWeights{{1}, {0.5f}}}, .keep_volume = KeptVolume{}})),
            "LATTICE_REMOVED");
  ASSERT_OK(DoKept(SetWeights{{1}, {0.5f}}));
  EXPECT_OK(EditHistory::FromImage(history_.image()).status());
  ASSERT_OK(Do("bob", Undo{}));
  EXPECT_EQ(FirstHeight(), 0);
}

// Weights of so many vertices are too large for an undo step.
TEST_F(WeightsHistoryTest, ARecordHasThePointsOfAStepThatCannotBeUndone) {
  constexpr size_t kVertices = limits::kMaxUndoBytes / sizeof(float);
  EditHistory copy(UnitLattice());
  for (EditHistory* history : {&history_, &copy}) ASSERT_OK(history->MadeWith(nullptr, kVertices));
  ASSERT_OK(copy.ApplyRecord(history_.LastRecord(last_, now_)));

  ASSERT_OK(DoKept(SetWeights{{}, std::vector<float>(kVertices, 0.5f)}));

  EXPECT_EQ(history_.undo_steps(), 0u);
  ASSERT_OK(copy.ApplyRecord(history_.LastRecord(last_, now_)));
  EXPECT_EQ(FirstHeight(), 0.02);
  ExpectSame(copy, history_);
}

TEST_F(WeightsHistoryTest, ADamagedRecordIsRefused) {
  EditHistory copy(UnitLattice());
  ASSERT_OK(copy.ApplyRecord(history_.LastRecord(last_, now_)));
  ASSERT_OK(DoKept(SetWeights{{1}, {0.5f}}));
  EditRecord record = history_.LastRecord(last_, now_);
  ASSERT_EQ(record.batch.edits.size(), 2u);
  std::get<SetControlPoints>(record.batch.edits[1]).indices[0] = 64;
  EXPECT_THAT(copy.ApplyRecord(record), StatusIs(absl::StatusCode::kDataLoss));
}

}  // namespace
}  // namespace latticed
