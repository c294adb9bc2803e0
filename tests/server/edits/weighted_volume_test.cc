// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// set_weights and set_strength in a scene that keeps its volume, through the stub: the volume is what it was at rest, after
// undo, redo and a restart too; what cannot be kept is refused and changes nothing.
#include <cmath>
#include <string>
#include <vector>

#include "tests/server/support/server_test.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

// The vertices of the last face are its own, at the places of the first ones.
constexpr char kSplitBoxObj[] =
    "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nv 0 0 1\nv 2 0 1\nv 2 1 1\nv 0 1 1\nv 0 0 0\nv 0 1 0\nv 0 "
    "1 1\nv 0 0 1\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 10 9 12 11\n";
constexpr double kSplitBoxVolume = 2;
constexpr double kVolumeSlack = 1e-12;  // relative
const std::vector<float> kSplitBoxWeights = {0, 1, 0.75f, 0.25f, 0.5f, 1, 1, 0, 0, 0.25f, 0, 0.5f};

class WeightedVolumeTest : public SceneFixture {
 protected:
  void SetUp() override {
    Restart();
    mesh_ = Upload(kSplitBoxObj);
    ASSERT_OK(Create(SceneRequest()));
  }
  void Restart() {
    server_.reset();
    Options options;
    options.data_dir = folder_.Path("data");
    SceneFixture::StartServer(options);
  }
  v1::EditBatch Batch() {
    v1::EditBatch batch = MoveOne("ann", ++sequence_, 0, {});
    batch.set_structure_id(Get().structure_id());
    batch.clear_edits();
    return batch;
  }
  v1::EditBatch Keep(const v1::Constraints& constraints) {
    v1::EditBatch batch = Batch();
    *batch.add_edits()->mutable_set_constraints()->mutable_constraints() = constraints;
    return batch;
  }
  v1::EditBatch KeepVolume() {
    v1::Constraints constraints;
    constraints.mutable_volume();
    return Keep(constraints);
  }
  v1::EditBatch Pull(double x) {
    v1::EditBatch batch = Batch();
    auto& move = *batch.add_edits()->mutable_move_control_points();
    move.add_indices(42);
    move.mutable_offset()->set_x(x);
    return batch;
  }
  v1::EditBatch Weigh(const std::vector<float>& weights) {
    v1::EditBatch batch = Batch();
    batch.add_edits()->mutable_set_weights()->set_values(
        reinterpret_cast<const char*>(weights.data()), weights.size() * sizeof(float));
    return batch;
  }
  v1::EditBatch ClearWeights() {
    v1::EditBatch batch = Batch();
    batch.add_edits()->mutable_set_weights()->set_clear(true);
    return batch;
  }
  v1::EditBatch Strength(double strength) {
    v1::EditBatch batch = Batch();
    batch.add_edits()->mutable_set_strength()->set_strength(strength);
    return batch;
  }
  absl::Status Undo() { return Apply(UndoMine("ann", ++sequence_)); }
  absl::Status Redo() {
    v1::EditBatch batch = Batch();
    batch.add_edits()->mutable_redo();
    return Apply(batch);
  }
  // The volume over that at rest, minus 1.
  double Excess() { return MeasuredVolume() / kSplitBoxVolume - 1; }
  void ExpectKept(const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
    const ::testing::ScopedTrace trace(file, line, "the caller");
    EXPECT_LE(std::abs(Excess()), kVolumeSlack);
  }
  std::vector<double> Points() {
    const v1::LatticeState state = Lattice();
    const auto& points = state.lattice().control_points();
    return {points.begin(), points.end()};
  }

  TemporaryFolder folder_;
  uint64_t sequence_ = 0;
};

TEST_F(WeightedVolumeTest, WithoutAKeptVolumeWeightsMoveNothing) {
  ASSERT_OK(Apply(Pull(0.5)));
  const auto before = Points();
  ASSERT_OK(Apply(Weigh(kSplitBoxWeights)));
  EXPECT_EQ(Points(), before);
  EXPECT_GT(std::abs(Excess()), 1e-4);
}

TEST_F(WeightedVolumeTest, WeightsKeepItAndSoDoUndoAndRedo) {
  ASSERT_OK(Apply(KeepVolume()));
  ASSERT_OK(Apply(Pull(0.5)));
  const auto bent = Points();

  ASSERT_OK(Apply(Weigh(kSplitBoxWeights)));
  ExpectKept();
  const auto weighted = Points();
  EXPECT_NE(weighted, bent);
  ASSERT_OK(Apply(ClearWeights()));
  ExpectKept();

  ASSERT_OK(Undo());
  EXPECT_EQ(Points(), weighted);
  ExpectKept();
  ASSERT_OK(Undo());
  EXPECT_FALSE(Get().weighted());
  EXPECT_EQ(Points(), bent);
  ExpectKept();
  ASSERT_OK(Redo());
  EXPECT_TRUE(Get().weighted());
  EXPECT_EQ(Points(), weighted);
  ExpectKept();
}

// As all undo, that of weights takes out one step and moves nothing else (edit_history.h).
TEST_F(WeightedVolumeTest, UndoBelowAnothersEditLeavesItToTheNextEdit) {
  ASSERT_OK(Apply(KeepVolume()));
  ASSERT_OK(Apply(Weigh(kSplitBoxWeights)));  // at rest: moves no points
  v1::EditBatch pull = Pull(0.5);
  pull.set_editor_id("bob");
  pull.set_sequence(1);
  ASSERT_OK(Apply(pull));
  ExpectKept();
  const auto pulled = Points();

  ASSERT_OK(Undo());
  EXPECT_FALSE(Get().weighted());
  EXPECT_EQ(Points(), pulled);
  EXPECT_GT(std::abs(Excess()), 1e-4);
  ASSERT_OK(Apply(Pull(0.25)));
  ExpectKept();
}

TEST_F(WeightedVolumeTest, ABatchKeepsItByItself) {
  ASSERT_OK(Apply(Pull(0.5)));
  v1::EditBatch batch = Weigh(kSplitBoxWeights);
  batch.mutable_keep_volume()->set_axis(v1::LATTICE_AXIS_W);
  const auto before = Points();
  ASSERT_OK(Apply(batch));
  ExpectKept();
  const auto after = Points();
  for (size_t i = 0; i < after.size(); ++i) {  // along z only
    if (i % 3 != 2) {
      EXPECT_EQ(after[i], before[i]);
    }
  }
}

TEST_F(WeightedVolumeTest, ARestartHasTheSamePoints) {
  ASSERT_OK(Apply(KeepVolume()));
  ASSERT_OK(Apply(Pull(0.5)));
  const auto bent = Points();
  for (int n = 0; n < 70; ++n) {  // from a snapshot and from records
    std::vector<float> weights = kSplitBoxWeights;
    weights[1] = static_cast<float>(n) / 100;
    ASSERT_OK(Apply(Weigh(weights)));
    if (n != 35 && n != 69) continue;
    const auto before = Points();
    Restart();
    EXPECT_EQ(Points(), before);
    ExpectKept();
  }
  for (int n = 0; n < 70; ++n) ASSERT_OK(Undo());
  EXPECT_EQ(Points(), bent);
  ExpectKept();
}

TEST_F(WeightedVolumeTest, WatchersAreToldOfTheMovedPoints) {
  ASSERT_OK(Apply(KeepVolume()));
  ASSERT_OK(Apply(Pull(0.5)));
  WatchClient watcher(*scenes_, For<v1::WatchRequest>());
  watcher.ReadUpdates(1);
  ASSERT_OK(Apply(Weigh(kSplitBoxWeights)));
  watcher.ReadUntilRevision(3);
  const auto& points = watcher.log.lattice.lattice().control_points();
  EXPECT_EQ(std::vector<double>(points.begin(), points.end()), Points());
}

TEST_F(WeightedVolumeTest, StrengthKeepsItToo) {
  ASSERT_OK(Apply(KeepVolume()));
  ASSERT_OK(Apply(Weigh(kSplitBoxWeights)));
  ASSERT_OK(Apply(Pull(0.5)));
  ASSERT_OK(Apply(Strength(0.4)));
  ExpectKept();
  ASSERT_OK(Apply(Weigh(std::vector<float>(12, 0.5f))));
  ExpectKept();
  ASSERT_OK(Undo());
  ExpectKept();
  ASSERT_OK(Undo());
  EXPECT_FALSE(Lattice().has_strength());
  ExpectKept();
}

TEST_F(WeightedVolumeTest, AllAtRestHaveTheVolumeAtRest) {
  ASSERT_OK(Apply(KeepVolume()));
  ASSERT_OK(Apply(Pull(0.5)));
  const auto before = Points();
  ASSERT_OK(Apply(Weigh(std::vector<float>(12, 0))));
  EXPECT_EQ(Points(), before);
  ExpectKept();
}

TEST_F(WeightedVolumeTest, WeightsThatFoldUnderTheRestoredPointsAreRefused) {
  ASSERT_OK(Apply(KeepVolume()));
  v1::EditBatch shift = Pull(3);
  auto& all = *shift.mutable_edits(0)->mutable_move_control_points()->mutable_indices();
  all.Clear();
  for (uint32_t i = 0; i < 64; ++i) all.Add(i);
  ASSERT_OK(Apply(shift));
  const auto shifted = Points();
  std::vector<float> weights(12, 1);
  weights[6] = 0;  // at x = 2: det J is 1 - 3 / 2 there
  v1::EditBatch careful = Weigh(weights);
  careful.set_refuse_folds(true);
  ExpectRefused(Apply(careful), Code::kFailedPrecondition, "FOLD");
  EXPECT_FALSE(Get().weighted());
  EXPECT_EQ(Points(), shifted);
  ExpectKept();

  weights[6] = 0.95f;
  careful = Weigh(weights);
  careful.set_refuse_folds(true);
  ASSERT_OK(Apply(careful));
  EXPECT_NE(Points(), shifted);
  ExpectKept();
}

TEST_F(WeightedVolumeTest, WhatCannotBeKeptIsRefusedAndChangesNothing) {
  const auto refused = [&](const v1::EditBatch& batch, const std::string& reason) {
    const std::string before = Lattice().SerializeAsString();
    ExpectRefused(Apply(batch), Code::kFailedPrecondition, reason);
    EXPECT_EQ(Lattice().SerializeAsString(), before);
    EXPECT_FALSE(Get().weighted());
  };
  v1::Constraints constraints;
  constraints.mutable_volume();
  ASSERT_OK(Apply(Pull(0.5)));
  for (uint32_t i = 0; i < 64; ++i) constraints.add_held(i);
  ASSERT_OK(Apply(Keep(constraints)));
  refused(Weigh(kSplitBoxWeights), "VOLUME_NOT_KEPT");
  refused(Strength(0.5), "VOLUME_NOT_KEPT");
  constraints.clear_held();
  constraints.mutable_volume()->set_volume(3);
  ASSERT_OK(Apply(Keep(constraints)));
  refused(Weigh(std::vector<float>(12, 0)), "VOLUME_NOT_KEPT");
  std::vector<float> torn = kSplitBoxWeights;
  torn[8] = 1;  // where vertex 0 rests
  refused(Weigh(torn), "OPEN_SURFACE");
  v1::EditBatch bad = Weigh(kSplitBoxWeights);
  bad.mutable_keep_volume()->set_volume(0);
  ExpectRefused(Apply(bad), Code::kInvalidArgument, "INVALID_FIELD", "keep_volume.volume");
  EXPECT_FALSE(Get().weighted());
}

}  // namespace
}  // namespace latticed::testing
