// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Folds under random edits.
#include <array>
#include <map>
#include <random>
#include <string>

#include "tests/server/edits/folds_fixture.h"

namespace latticed::testing {
namespace {

using RandomFoldsTest = FoldsTest;

// Two editors push, drag, undo, redo, reset and insert knots, with and without refuse_folds, and the server starts again.
TEST_F(RandomFoldsTest, RandomEditsKeepReportsRightAndMakeNoNewFoldsUnlessTheyMay) {
  constexpr uint32_t kSeed = 26;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  const auto below = [&](uint32_t n) { return static_cast<uint32_t>(random() % n); };
  using States = std::map<std::array<int, 3>, int>;
  const auto states = [&] {
    States result;
    const v1::FoldReport report = Certify();
    for (const v1::FoldedBox& place : report.places()) {
      result[{place.box().u(), place.box().v(), place.box().w()}] =
          place.state() == v1::FOLD_STATE_FOLDED ? 2 : 1;
    }
    return result;
  };
  std::map<std::string, uint64_t> gestures;  // of each editor: the number of the open one, or 0
  int refused = 0, folded = 0, knots = 0;
  for (int step = 0; step < 240; ++step) {
    if (step % 60 == 59) Restart();
    const std::string editor = below(2) == 0 ? "ann" : "bob";
    const States before = states();
    const auto size = Lattice().lattice().size();
    const auto count = static_cast<uint32_t>(size.u() * size.v() * size.w());
    v1::EditBatch batch = Push(below(count), 0.02 * below(400) - 4, below(3) > 0, editor);
    const uint32_t kind = below(12);
    uint64_t& gesture = gestures[editor];
    if (kind == 0) batch.mutable_edits(0)->mutable_undo();
    if (kind == 1) batch.mutable_edits(0)->mutable_redo();
    if (kind == 2) batch.mutable_edits(0)->mutable_reset();
    if (kind == 3 && knots < 4) {
      batch.mutable_edits(0)->mutable_insert_knot()->set_axis(
          static_cast<v1::LatticeAxis>(1 + below(3)));
      batch.mutable_edits(0)->mutable_insert_knot()->set_value(0.1 + 0.018 * below(100));
      ++knots;
    }
    if (kind > 6) {
      if (gesture == 0) gesture = sequence_;
      batch.set_gesture_id(std::to_string(gesture));
      batch.set_gesture_phase(kind == 11   ? v1::GESTURE_PHASE_CANCEL
                              : kind == 10 ? v1::GESTURE_PHASE_COMMIT
                                           : v1::GESTURE_PHASE_UPDATE);
      if (kind == 11) batch.clear_edits();
    }
    v1::EditResult result;
    const absl::Status applied = Apply(batch, &result);
    if (kind <= 3 || kind >= 10) gesture = 0;
    const v1::FoldReport now = Certify();
    if (!applied.ok()) {
      const std::string reason = Reason(applied);
      EXPECT_THAT(reason,
                  ::testing::AnyOf("FOLD", "NOTHING_TO_UNDO", "NOTHING_TO_REDO", "UNDO_CONFLICT"))
          << applied;
      EXPECT_EQ(states(), before);
      refused += reason == "FOLD" ? 1 : 0;
      if (reason == "FOLD") {
        EXPECT_TRUE(batch.refuse_folds());
      }
      continue;
    }
    ASSERT_EQ(result.folds().SerializeAsString(), now.SerializeAsString()) << "step " << step;
    folded += now.folded() > 0 ? 1 : 0;
    const bool always_passes = kind <= 1 || kind == 3 || kind == 11;
    if (!batch.refuse_folds() || always_passes) continue;
    for (const auto& [box, state] : states()) {
      const auto was = before.find(box);
      EXPECT_LE(state, was == before.end() ? 0 : was->second) << "step " << step;
    }
  }
  EXPECT_GT(refused, 10);
  EXPECT_GT(folded, 10);
}

}  // namespace
}  // namespace latticed::testing
