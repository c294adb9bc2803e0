// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The removal of a history's lattice: what edits do then, what is forgotten, and who may refuse it.
#include "tests/core/ffd/history/edit_history_fixture.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::HasSubstr;

class RemovalTest : public EditHistoryTest {
 protected:
  static Edit Another() { return ReplaceLattice{UnitLattice()}; }
};

TEST_F(RemovalTest, KeepsEverythingForUndo) {
  ASSERT_OK(Do("ann", Move({3}, 0.25)));
  ASSERT_OK(Do("ann", RemoveLattice{}));
  EXPECT_TRUE(history_.absent());
  EXPECT_EQ(history_.structure_id(), 2u);
  EXPECT_EQ(Reason(Do("ann", Move({3}, 0.25))), "LATTICE_REMOVED");
  EXPECT_EQ(Reason(Do("ann", InsertKnot{0, 0.25})), "LATTICE_REMOVED");
  EXPECT_EQ(Reason(Do("ann", RemoveLattice{})), "LATTICE_REMOVED");
  ASSERT_OK(Do("ann", Undo{}));
  EXPECT_FALSE(history_.absent());
  EXPECT_EQ(Moved(3), 0.25);
  EXPECT_EQ(history_.structure_id(), 3u);
  ASSERT_OK(Do("ann", Undo{}));
  EXPECT_TRUE(AtStart());
  ASSERT_OK(Do("ann", Redo{}));
  ASSERT_OK(Do("ann", Redo{}));
  EXPECT_TRUE(history_.absent());
}

TEST_F(RemovalTest, EndsGestures) {
  ASSERT_OK(Drag("bob", "g", {3}, 0.25));
  ASSERT_OK(Do("ann", RemoveLattice{}));
  EXPECT_FALSE(history_.gesture_open());
}

TEST_F(RemovalTest, AForgottenOneCannotBeUndoneAndALatticeCanComeInItsPlace) {
  ASSERT_OK(Do("ann", SetStrength{0.5}));
  ASSERT_OK(Do("ann", RemoveLattice{}));
  ASSERT_OK(Do("ann", Another()));
  EXPECT_FALSE(history_.absent());
  EXPECT_EQ(history_.strength(), 1);
  ASSERT_TRUE(history_.ForgetOldestStep());
  ASSERT_TRUE(history_.ForgetOldestStep());
  EXPECT_TRUE(history_.began_absent());
  EXPECT_FALSE(history_.ForgetOldestStep());
  ASSERT_OK(Do("ann", Undo{}));
  EXPECT_TRUE(history_.absent());
  EXPECT_EQ(Reason(Do("ann", Undo{})), "NOTHING_TO_UNDO");
  ASSERT_OK(Do("ann", Redo{}));
  ASSERT_OK(Do("bob", Move({3}, 0.25)));
  ASSERT_TRUE(history_.ForgetOldestStep());
  EXPECT_FALSE(history_.began_absent());
}

TEST_F(RemovalTest, OneThatBeginsAbsentCountsItsLatticesInMemory) {
  EditHistory history = EditHistory::Absent(UnitLattice());
  EXPECT_TRUE(history.absent());
  EXPECT_EQ(history.MemoryBytes(), 3 * 64 * sizeof(Vec3d));
}

TEST_F(RemovalTest, AnImageWithOtherStepsOfNoLatticeIsRefused) {
  const auto refuses = [](const char* what, EditHistoryImage image) {
    EXPECT_THAT(EditHistory::FromImage(std::move(image)).status(),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr(what)));
  };
  ASSERT_OK(Do("ann", Move({3}, 0.25)));
  EditHistoryImage image = history_.image();
  image.base.absent = true;
  refuses("was removed", image);  // moved without a lattice
  EditHistoryImage with = image;
  with.steps[0].weights.emplace();
  refuses("was removed", with);
  image.steps[0] = {.id = 1, .editor_id = "ann"};
  image.steps[0].strength = 0.5;
  refuses("was removed", image);
  image.steps[0].strength.reset();
  image.steps[0].constraints.emplace();
  refuses("was removed", image);
  image.steps[0].constraints.reset();
  image.steps[0].removes = true;
  refuses("was removed", image);  // twice
  ASSERT_OK(Do("bob", RemoveLattice{}));
  const EditHistoryImage removed = history_.image();
  EXPECT_OK(EditHistory::FromImage(removed).status());
  image = removed;
  image.steps[0].open = true;
  refuses("gesture", image);
  image = removed;
  image.steps[1].strength = 0.5;
  refuses("does more", image);
  image = removed;
  image.steps[1].weights.emplace();
  refuses("does more", image);
  image = removed;
  std::swap(image.steps[0], image.steps[1]);
  refuses("was removed", image);
  ASSERT_OK(Do("bob", Undo{}));
  image = history_.image();
  image.undone[0].step.indices = {3};
  image.undone[0].step.positions = {Vec3d{}};
  refuses("does more", image);
}

TEST_F(RemovalTest, AnImageOfNoLatticeTakesWeightsAndAReplacement) {
  ASSERT_OK(Do("ann", RemoveLattice{}));
  ASSERT_OK(Do("ann", SetWeights{}));
  ASSERT_OK_AND_ASSIGN(EditHistory copy, EditHistory::FromImage(history_.image()));
  EXPECT_TRUE(copy.absent());
  ASSERT_OK(Do("bob", Another()));
  ASSERT_OK(Do("bob", Move({3}, 0.25)));
  EXPECT_OK(EditHistory::FromImage(history_.image()).status());
}

TEST_F(RemovalTest, TheCallerMayRefuseIt) {
  const auto apply = [&](Edit edit, const absl::Status& admission) {
    return history_.Apply(
        {.editor_id = "ann",
         .sequence = ++sequences_["ann"],
         .structure_id = history_.structure_id(),
         .edits = {std::move(edit)}},
        now_, [](const auto&) { return absl::OkStatus(); }, {}, nullptr, {},
        [&] { return admission; });
  };
  const absl::Status no = absl::FailedPreconditionError("no");
  EXPECT_THAT(apply(RemoveLattice{}, no), StatusIs(absl::StatusCode::kFailedPrecondition));
  EXPECT_FALSE(history_.absent());
  ASSERT_OK(apply(RemoveLattice{}, absl::OkStatus()));
  ASSERT_OK(apply(Undo{}, no));  // it comes back
  EXPECT_THAT(apply(Redo{}, no), StatusIs(absl::StatusCode::kFailedPrecondition));
  EXPECT_FALSE(history_.absent());
  ASSERT_OK(apply(Redo{}, absl::OkStatus()));
  ASSERT_OK(apply(Another(), no));
  EXPECT_THAT(apply(Undo{}, no), StatusIs(absl::StatusCode::kFailedPrecondition));
  EXPECT_FALSE(history_.absent());
  ASSERT_OK(apply(Undo{}, absl::OkStatus()));
  EXPECT_TRUE(history_.absent());
}

}  // namespace
}  // namespace latticed
