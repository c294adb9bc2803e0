// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A history that applies the records of another one is the same, bit by bit; so is one that goes on from an image. What is
// damaged is refused.
#include <cmath>

#include "tests/core/ffd/history/edit_sessions.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::HasSubstr;

TEST(EditRecord, ALogOfRandomSessionsLeadsToTheSameHistory) {
  size_t records = 0, refusals = 0, structures = 0, absences = 0, weighings = 0, restorations = 0;
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    EditHistory copy(UnitLattice());
    ASSERT_OK(copy.MadeWith(nullptr, 8));
    RunSession(seed, 250, [&](const EditHistory& history, const EditRecord& record) {
      ++records;
      weighings += SetsWeights(record.batch) ? 1u : 0u;
      restorations += SetsWeights(record.batch) && record.batch.edits.size() == 2 ? 1u : 0u;
      refusals += record.result.status.ok() ? 0u : 1u;
      structures += record.made.has_value() ? 1u : 0u;
      absences += history.absent() ? 1u : 0u;
      ASSERT_OK(copy.ApplyRecord(record));
      if (copy.records() % 20 == 0) ExpectSame(copy, history);
    });
    if (::testing::Test::HasFailure()) return;
  }
  EXPECT_GT(records, 9000u);
  EXPECT_GT(refusals, 1000u);
  EXPECT_GT(structures, 300u);
  EXPECT_GT(absences, 100u);
  EXPECT_GT(weighings, 100u);
  EXPECT_GT(restorations, 20u);
}

TEST(EditRecord, AHistoryGoesOnFromItsImage) {
  for (uint32_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    EditHistory copy(UnitLattice());
    ASSERT_OK(copy.MadeWith(nullptr, 8));
    RunSession(seed, 250, [&](const EditHistory& history, const EditRecord& record) {
      ASSERT_OK(copy.ApplyRecord(record));
      if (copy.records() % 40 != 0) return;
      ASSERT_OK_AND_ASSIGN(copy, EditHistory::FromImage(copy.image()));
      ASSERT_OK(copy.MadeWith(nullptr, 8));
      ExpectSame(copy, history);
    });
    if (::testing::Test::HasFailure()) return;
  }
}

TEST_F(EditHistoryTest, ARecordThatDoesNotFitIsRefused) {
  ASSERT_OK(Do("ann", Move({3}, 0.25)));
  const EditBatch batch{
      .editor_id = "ann", .sequence = 2, .structure_id = 1, .edits = {Move({3}, 0.25)}};
  ASSERT_OK(history_.Apply(batch, now_, [](const auto&) { return absl::OkStatus(); }));
  const EditRecord record = history_.LastRecord(batch, now_);

  EditHistory first(UnitLattice());  // lacks the record before
  EXPECT_THAT(first.ApplyRecord(record),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("revision 2")));
  EditRecord other = record;
  std::get<SetControlPoints>(other.batch.edits[0]).indices[0] = 64;
  EditHistory second(UnitLattice());
  EXPECT_THAT(second.ApplyRecord(other), StatusIs(absl::StatusCode::kDataLoss));
}

TEST_F(EditHistoryTest, AnImageThatCannotBeIsRefused) {
  ASSERT_OK(Drag("ann", "g", {3, 5}, 0.25));
  ASSERT_OK(Do("bob", InsertKnot{0, 0.3}));
  ASSERT_OK(Do("bob", Move({7}, 0.5)));
  ASSERT_OK(Do("bob", Undo{}));
  const EditHistoryImage image = history_.image();
  ASSERT_EQ(image.steps.size(), 2u);
  const auto refuses = [&](const char* what, auto damage) {
    EditHistoryImage damaged = image;
    damage(damaged);
    EXPECT_THAT(EditHistory::FromImage(damaged).status(),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr(what)));
  };
  refuses("indices", [](auto& i) { i.steps[0].indices[1] = 64; });
  refuses("indices", [](auto& i) { i.steps[0].indices = {5, 3}; });
  refuses("points", [](auto& i) { i.steps[0].positions.pop_back(); });
  refuses("position", [](auto& i) { i.steps[0].positions[0].x = NAN; });
  refuses("indices", [](auto& i) {
    i.steps[0].start = {{64, {}}};
    i.steps[0].start.emplace(64, Vec3d{});
  });
  refuses("structure", [](auto& i) { i.steps[0].structure_step = 9; });
  refuses("id", [](auto& i) { i.steps[1].id = 0; });
  refuses("control", [](auto& i) { i.steps[1].positions.pop_back(); });
  refuses("indices", [](auto& i) { i.undone[0].step.indices = {80}; });
  refuses("control", [](auto& i) { i.base.base.control_points.clear(); });
}

}  // namespace
}  // namespace latticed
