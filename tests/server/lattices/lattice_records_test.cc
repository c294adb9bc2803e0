// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Records and images of lattices that come and go: those of earlier servers, and what cannot be.
#include <optional>
#include <utility>
#include <vector>

#include "server/engine/lattices/scene_history.h"
#include "tests/core/ffd/history/edit_history_fixture.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::HasSubstr;

class LatticeRecordsTest : public ::testing::Test {
 protected:
  // Applies an edit of one lattice, and returns its record.
  EditRecord Do(uint32_t lattice, Edit edit) {
    EditBatch batch{.lattice = lattice,
                    .editor_id = "ann",
                    .sequence = ++sequence_,
                    .structure_id = history_.structure_id()};
    batch.edits.push_back(std::move(edit));
    EXPECT_OK(history_.Apply(batch, {}, [](const auto&) { return absl::OkStatus(); }));
    return history_.LastRecord(batch, {});
  }

  SceneHistory history_{{UnitLattice()}};
  uint64_t sequence_ = 0;
};

TEST_F(LatticeRecordsTest, OfAnEarlierServerUndoOfAnAdditionLeavesTheLatticeAtRest) {
  EditRecord added = Do(1, ReplaceLattice{UnitLattice()});
  EXPECT_TRUE(added.adds);
  const EditRecord undone = Do(1, Undo{});
  EXPECT_EQ(history_.structures().size(), 1u);
  SceneHistory copy({UnitLattice()});
  ASSERT_OK(copy.ApplyRecord(added));
  ASSERT_OK(copy.ApplyRecord(undone));
  EXPECT_EQ(copy.structures().size(), 1u);

  added.adds = false;
  SceneHistory earlier({UnitLattice()});
  ASSERT_OK(earlier.ApplyRecord(added));
  ASSERT_OK(earlier.ApplyRecord(undone));
  EXPECT_EQ(earlier.structures().size(), 2u);
}

TEST_F(LatticeRecordsTest, ThatLeaveNoLatticeAreRefused) {
  Do(1, ReplaceLattice{UnitLattice()});
  const EditRecord removed = Do(1, RemoveLattice{});
  EXPECT_FALSE(removed.made.has_value());
  SceneHistory lone({UnitLattice()});
  EditRecord last = removed;
  last.batch.lattice = 0;
  last.batch.structure_id = last.result.revision = 1;
  last.result.structure_id = 2;
  EXPECT_THAT(lone.ApplyRecord(last),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("last lattice")));
  std::vector<EditHistoryImage> images = history_.images();
  ASSERT_OK(SceneHistory::FromImages(images));
  images.erase(images.begin());
  EXPECT_THAT(SceneHistory::FromImages(images),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("no lattice")));
}

}  // namespace
}  // namespace latticed
