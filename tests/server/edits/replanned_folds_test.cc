// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// refuse_folds of edits that make another plan, through the stub: weights, and other lattices where the scene folded before.
#include <string>
#include <vector>

#include "core/ffd/lattice.h"
#include "server/wire/converters.h"
#include "tests/server/edits/folds_fixture.h"

namespace latticed::testing {
namespace {

// By vertex of kGridObj, 3 x 3 on [0,2]^2: they depend on x alone, and are `at` 0, 1 and 2.
std::vector<float> Along(float left, float middle, float right) {
  return {left, middle, right, left, middle, right, left, middle, right};
}

class ReplannedFoldsTest : public FoldsTest {
 protected:
  v1::EditBatch Weigh(const std::vector<float>& weights, bool refuse = true) {
    v1::EditBatch batch = Alone(refuse);
    batch.add_edits()->mutable_set_weights()->set_values(
        reinterpret_cast<const char*>(weights.data()), weights.size() * sizeof(float));
    return batch;
  }
  // Moves all that follows the lattice by x. Between two columns of vertices det J is then 1 + x times the rise of weights.
  v1::EditBatch Shift(double x) {
    v1::EditBatch batch = Push(0, x, false);
    auto& indices = *batch.mutable_edits(0)->mutable_move_control_points()->mutable_indices();
    for (uint32_t i = 1; i < 64; ++i) indices.Add(i);
    return batch;
  }
  v1::EditBatch Replace(const v1::Lattice& lattice) {
    v1::EditBatch batch = Alone();
    *batch.add_edits()->mutable_replace_lattice()->mutable_lattice() = lattice;
    return batch;
  }
  // The scene's frame with 6 x 6 x 6 control points, whose knot boxes are eight times as many, at rest.
  v1::Lattice Finer() {
    v1::Lattice lattice = Lattice().lattice();
    SetAxes(*lattice.mutable_size(), 6, 6, 6);
    lattice.clear_knots_u();
    lattice.clear_knots_v();
    lattice.clear_knots_w();
    lattice.clear_control_points();
    return lattice;
  }
};

TEST_F(ReplannedFoldsTest, WeightsThatFoldAreRefusedAndChangeNothing) {
  ASSERT_TRUE(Applied(Shift(-3)).folds().certified());
  const v1::EditBatch folding = Weigh(Along(0, 0.5f, 1));
  const absl::Status refusal = Apply(folding);
  ExpectRefused(refusal, absl::StatusCode::kFailedPrecondition, "FOLD");
  EXPECT_NEAR(std::stod(error::DetailsOf(refusal).metadata.at("determinant")), -0.5, 1e-9);
  ExpectNewFold(folding);  // sent again
  EXPECT_FALSE(Get().weighted());
  EXPECT_EQ(Get().structure_id(), 1u);
  EXPECT_TRUE(Certify().certified());
  Restart();
  ExpectNewFold(folding);
  EXPECT_FALSE(Get().weighted());

  const v1::FoldReport folds = Applied(Weigh(Along(0, 0.5f, 1), false)).folds();
  EXPECT_EQ(folds.folded(), 4u);
  EXPECT_NEAR(folds.places(0).determinant(), -0.5, 1e-9);
}

TEST_F(ReplannedFoldsTest, WeightsThatDoNotFoldPass) {
  ASSERT_OK(Apply(Shift(-1.9)));
  EXPECT_TRUE(Applied(Weigh(Along(0, 0.5f, 1))).folds().certified());
  ASSERT_OK(Apply(Shift(-0.05)));  // in all -1.95
  EXPECT_TRUE(Applied(Weigh(Along(1, 0.5f, 0))).folds().certified());
  v1::EditBatch clear = Alone();
  clear.add_edits()->mutable_set_weights()->set_clear(true);
  EXPECT_TRUE(Applied(clear).folds().certified());
}

TEST_F(ReplannedFoldsTest, WeightsThatRevealAFoldAreRefused) {
  ASSERT_OK(Apply(Weigh(std::vector<float>(9, 0))));
  ASSERT_OK(Apply(Push(kFoldPoint, kFolding)));  // at weight 0 nothing moves
  v1::EditBatch clear = Alone();
  clear.add_edits()->mutable_set_weights()->set_clear(true);
  ExpectNewFold(clear);
  EXPECT_TRUE(Get().weighted());
}

// The two boxes of x < 1 fold, those of x > 1 do not.
TEST_F(ReplannedFoldsTest, WeightsMayLeaveAndMendAnOldFoldAndMakeNoneElsewhere) {
  ASSERT_OK(Apply(Shift(-3)));
  ASSERT_EQ(Applied(Weigh(Along(0, 1, 1), false)).folds().folded(), 2u);

  EXPECT_EQ(Applied(Weigh(Along(0, 0.9f, 0.9f))).folds().folded(), 2u);
  ExpectNewFold(Weigh(Along(0, 0, 1)));
  ExpectNewFold(Weigh(Along(0, 0.5f, 1)));
  EXPECT_TRUE(Applied(Weigh(Along(0.5f, 0.5f, 0.5f))).folds().certified());
  ExpectNewFold(Weigh(Along(0, 0.9f, 0.9f)));
}

TEST_F(ReplannedFoldsTest, UndoAndRedoOfWeightsPass) {
  ASSERT_OK(Apply(Shift(-3)));
  ASSERT_OK(Apply(Weigh(Along(0, 0.5f, 1), false)));
  v1::EditBatch undo = Alone();
  undo.add_edits()->mutable_undo();
  EXPECT_TRUE(Applied(undo).folds().certified());
  v1::EditBatch redo = Alone();
  redo.add_edits()->mutable_redo();
  EXPECT_EQ(Applied(redo).folds().folded(), 4u);
}

// The new boxes lie in the old ones.
TEST_F(ReplannedFoldsTest, AFinerLatticeMayKeepAFoldAndMakesNoneElsewhere) {
  ASSERT_OK(Apply(Push(kFoldPoint, 3.4, false)));
  const uint64_t folded = Certify().folded();
  ASSERT_GT(folded, 0u);
  ASSERT_LT(folded, 4u) << "the test needs a box that is not folded";
  v1::Lattice mirrored = Finer();
  const auto structure = StructureFromProto(mirrored, "lattice");
  ASSERT_OK(structure);
  for (const Vec3d p : IdentityControlPoints(*structure)) {
    for (int a = 0; a < 3; ++a) mirrored.add_control_points(a == 0 ? -p[a] : p[a]);
  }

  ExpectNewFold(Replace(mirrored));
  v1::EditBatch fit = Replace(Finer());
  fit.mutable_edits(0)->mutable_replace_lattice()->set_keep_shape(true);
  const v1::EditResult kept = Applied(fit);
  EXPECT_LT(kept.drag_residual(), 1e-9);
  EXPECT_EQ(kept.folds().boxes(), 16u);
  EXPECT_GT(kept.folds().folded(), 0u);
  EXPECT_TRUE(Applied(Replace(Finer())).folds().certified());
  ExpectNewFold(Replace(mirrored));
}

}  // namespace
}  // namespace latticed::testing
