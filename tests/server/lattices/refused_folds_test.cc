// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// refuse_folds through the stub where the scene gets another plan: other falloff widths, several lattices, and lattices that
// are turned against each other.
#include <array>
#include <string>
#include <vector>

#include "tests/server/lattices/removed_fixture.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

class RefusedFoldsTest : public RemovedLatticesTest {
 protected:
  void Watch(const std::vector<v1::Lattice>& lattices) {
    v1::CreateSceneRequest request = RequestOf(lattices);
    request.set_fold_watch(true);
    ASSERT_OK(Create(request));
  }
  v1::FoldReport Certify() {
    v1::FoldReport report;
    EXPECT_OK(Call(&Scenes::CertifyFolds, For<v1::CertifyFoldsRequest>(), &report));
    return report;
  }
  // Applies it, careful or not, and checks that the report in the answer is that of CertifyFolds.
  v1::FoldReport FoldsAfter(v1::EditBatch batch, bool refuse = true) {
    batch.set_refuse_folds(refuse);
    v1::EditResult result;
    EXPECT_OK(Apply(batch, &result));
    EXPECT_EQ(result.folds().SerializeAsString(), Certify().SerializeAsString());
    return result.folds();
  }
  void ExpectNewFold(v1::EditBatch batch) {
    batch.set_refuse_folds(true);
    const v1::Scene before = Get();
    const v1::FoldReport folds = Certify();
    ExpectRefused(Apply(batch), Code::kFailedPrecondition, "FOLD");
    const v1::Scene after = Get();
    EXPECT_EQ(after.revision(), before.revision());
    EXPECT_EQ(after.structure_id(), before.structure_id());
    EXPECT_EQ(after.weighted(), before.weighted());
    EXPECT_EQ(Certify().SerializeAsString(), folds.SerializeAsString());
  }
  // Of all control points of a lattice.
  v1::EditBatch PushAll(uint32_t number, Vec3d offset) {
    v1::EditBatch batch = Push(number, 0, offset);
    auto& indices = *batch.mutable_edits(0)->mutable_move_control_points()->mutable_indices();
    for (uint32_t i = 1; i < 64; ++i) indices.Add(i);
    return batch;
  }
  v1::EditBatch Weigh(const std::array<float, 8>& weights) {
    v1::EditBatch batch = Batch(0);
    batch.add_edits()->mutable_set_weights()->set_values(
        reinterpret_cast<const char*>(weights.data()), sizeof(weights));
    return batch;
  }
  // The lattice as it is, with another width of the falloff.
  v1::EditBatch Widen(uint32_t number, int side, double width) {
    v1::Lattice lattice = LatticeAt(number).lattice();
    lattice.mutable_outside()->clear_steps();
    lattice.mutable_outside()->set_widths(side, width);
    return Put(number, lattice);
  }
};

// Weights of kUnitCubeObj that rise from 0 to 1 along x.
constexpr std::array<float, 8> kRising = {0, 1, 1, 0, 0, 1, 1, 0};

// A shift by d fades out over the width b, in lengths of 0.6: where it falls most, det J is about 1 - 1.5 d / (0.6 b) or less.
TEST_F(RefusedFoldsTest, AFalloffWidthThatFoldsIsRefused) {
  Watch({Falloff(0.8)});
  EXPECT_TRUE(FoldsAfter(PushAll(0, {0.15, 0, 0})).certified());
  EXPECT_TRUE(FoldsAfter(Widen(0, 1, 0.75)).certified());
  ExpectNewFold(Widen(0, 1, 0.1));
  EXPECT_NEAR(Lattice().lattice().outside().widths(1), 0.75, 0);

  EXPECT_GT(FoldsAfter(Widen(0, 1, 0.1), false).folded(), 0u);
  EXPECT_GT(FoldsAfter(Widen(0, 1, 0.09)).folded(), 0u);  // an old fold, within the old one
  EXPECT_TRUE(FoldsAfter(Widen(0, 1, 0.75)).certified());
  EXPECT_GT(FoldsAfter(Undo(0)).folded(), 0u);
}

TEST_F(RefusedFoldsTest, AmongSeveralLatticesTheSumCounts) {
  Watch({Whole(), Spot()});
  EXPECT_TRUE(FoldsAfter(PushAll(1, {0.05, 0, 0})).certified());
  ExpectNewFold(Widen(1, 1, 0.05));
  EXPECT_TRUE(FoldsAfter(PushAll(0, {-1.5, 0, 0})).certified());
  ExpectNewFold(Weigh(kRising));
  EXPECT_TRUE(FoldsAfter(Weigh({1, 0, 0, 1, 1, 0, 0, 1})).certified());
  EXPECT_GT(FoldsAfter(Weigh(kRising), false).folded(), 0u);
}

TEST_F(RefusedFoldsTest, WeightsCountWhereLatticeZeroIsRemoved) {
  Watch({Whole(), Whole({1, 1, 1})});
  ASSERT_OK(Apply(Remove(0)));
  EXPECT_TRUE(FoldsAfter(PushAll(1, {-1.5, 0, 0})).certified());
  ExpectNewFold(Weigh(kRising));
  EXPECT_TRUE(FoldsAfter(Weigh({1, 0, 0, 1, 1, 0, 0, 1})).certified());
  EXPECT_GT(FoldsAfter(Undo(0)).boxes(), 0u);
  EXPECT_FALSE(Get().weighted());
}

TEST_F(RefusedFoldsTest, TurnedLatticesAreJudgedOnTheSurface) {
  Watch({Whole(), TurnedSpot()});
  EXPECT_TRUE(FoldsAfter(PushAll(1, {0.05, 0, 0})).certified());
  ExpectNewFold(Widen(1, 1, 0.02));
  EXPECT_TRUE(FoldsAfter(Widen(1, 0, 0.02)).certified());  // there the shift stretches
  EXPECT_TRUE(FoldsAfter(Widen(1, 1, 0.45)).certified());
  EXPECT_TRUE(FoldsAfter(PushAll(0, {-1.5, 0, 0})).certified());
  ExpectNewFold(Weigh(kRising));
  EXPECT_TRUE(FoldsAfter(Weigh({1, 0, 0, 1, 1, 0, 0, 1})).certified());
  EXPECT_GT(FoldsAfter(Weigh(kRising), false).folded(), 0u);
  EXPECT_TRUE(FoldsAfter(Undo(0)).certified());
  EXPECT_GT(FoldsAfter(Redo(0)).folded(), 0u);
}

}  // namespace
}  // namespace latticed::testing
