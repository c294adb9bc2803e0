// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Gestures, undo, redo and whole-lattice edits through Deform. After each, the watcher has the surface of
// a fresh evaluation, and the server's control points.
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kLatticePoints = 125;  // StreamTest's lattice
constexpr uint32_t kInner = 62;

class GesturesTest : public SceneStreamTest {
 protected:
  void SetUp() override {
    SceneStreamTest::SetUp();
    v1::WatchRequest watch = Watch();
    watch.mutable_view()->set_encoding(v1::ENCODING_RAW);  // no grid, which edits may change
    client_ = std::make_unique<DeformClient>(*scenes_, watch);
    client_->ReadUntilRevision(0);
    initial_ = Cage();
  }
  void TearDown() override { client_.reset(); }

  std::vector<double> Cage() const {
    const auto& points = client_->log.lattice.lattice().control_points();
    return {points.begin(), points.end()};
  }
  double Z(uint32_t point) const { return Cage()[3 * point + 2]; }
  double InitialZ(uint32_t point) const { return initial_[3 * point + 2]; }

  v1::EditBatch Batch() {
    v1::EditBatch batch;
    batch.set_sequence(++sequence_);
    batch.set_structure_id(structure_id_);
    return batch;
  }
  v1::EditBatch Lift(double dz, const std::string& gesture = "",
                     v1::GesturePhase phase = v1::GESTURE_PHASE_UPDATE) {
    v1::EditBatch batch = Move(++sequence_, kInner, dz);
    batch.set_gesture_id(gesture);
    batch.set_gesture_phase(phase);
    return batch;
  }
  v1::EditBatch End(const std::string& gesture, v1::GesturePhase phase) {
    v1::EditBatch batch = Batch();
    batch.set_gesture_id(gesture);
    batch.set_gesture_phase(phase);
    return batch;
  }
  v1::EditBatch UndoMine() {
    v1::EditBatch batch = Batch();
    batch.add_edits()->mutable_undo()->set_scope(v1::UNDO_SCOPE_MINE);
    return batch;
  }
  v1::EditBatch Redo() {
    v1::EditBatch batch = Batch();
    batch.add_edits()->mutable_redo();
    return batch;
  }

  // Sends `batch` and returns its result.
  v1::EditResult Answer(const v1::EditBatch& batch) {
    EXPECT_TRUE(client_->Send(batch));
    const size_t answers = client_->log.results.size() + 1;
    client_->ReadUntil([&] { return client_->log.results.size() == answers; });
    return client_->log.results.back();
  }
  // Expects that `batch` is applied and that the stream's update equals a fresh evaluation.
  void MustApply(const v1::EditBatch& batch) {
    const v1::EditResult result = Answer(batch);
    ASSERT_EQ(result.status().code(), 0) << result.status().message();
    ASSERT_EQ(result.revision(), ++revision_) << "one batch, one revision";
    client_->ReadUntilRevision(revision_);
    client_->ReadUntil([&] { return client_->log.lattice.revision() == revision_; });
    EXPECT_EQ(client_->log.ends.back().applied_sequence(), batch.sequence());

    auto request = For<v1::GetUpdateRequest>();
    request.mutable_view()->set_encoding(v1::ENCODING_RAW);
    EventLog fresh;
    ASSERT_OK(Update(request, fresh));
    EXPECT_EQ(fresh.ends.at(0).revision(), revision_);
    EXPECT_TRUE(fresh.chunks == client_->log.chunks) << "another surface than a fresh evaluation";
    EXPECT_EQ(fresh.lattice.lattice().SerializeAsString(),
              client_->log.lattice.lattice().SerializeAsString());
  }

  void MustRefuse(const v1::EditBatch& batch, const Refusal& refusal) {
    const v1::EditResult result = Answer(batch);
    ExpectRefusal(client::FromRpc(result.status()), refusal);
    EXPECT_EQ(result.revision(), revision_);
  }

  static Refusal Nothing(const char* to) {
    return {.code = absl::StatusCode::kFailedPrecondition,
            .reason = std::string("NOTHING_TO_") + to};
  }

  std::unique_ptr<DeformClient> client_;
  std::vector<double> initial_;
  uint64_t sequence_ = 0, revision_ = 0;
};

TEST_F(GesturesTest, AnUpdateReplacesTheUpdateBeforeIt) {
  MustApply(Lift(0.1, "drag"));
  MustApply(Lift(0.2, "drag"));
  EXPECT_DOUBLE_EQ(Z(kInner), InitialZ(kInner) + 0.2) << "0.2 from the begin, not 0.3";

  // An update of another point: the first point goes back to where the gesture found it.
  v1::EditBatch other = Lift(0.3, "drag");
  other.mutable_edits(0)->mutable_move_control_points()->set_indices(0, kInner + 1);
  MustApply(other);
  EXPECT_EQ(Z(kInner), InitialZ(kInner));
  EXPECT_DOUBLE_EQ(Z(kInner + 1), InitialZ(kInner + 1) + 0.3);
}

TEST_F(GesturesTest, CancelRestoresTheStartAndLeavesNothingToUndo) {
  MustApply(Lift(0.1, "drag"));
  MustApply(Lift(0.2, "drag"));
  MustApply(End("drag", v1::GESTURE_PHASE_CANCEL));

  EXPECT_EQ(Cage(), initial_);
  MustRefuse(UndoMine(), Nothing("UNDO"));
}

TEST_F(GesturesTest, ABareCommitKeepsTheLastUpdateAndIsOneUndoStep) {
  MustApply(Lift(0.1, "drag"));
  MustApply(Lift(0.2, "drag"));
  const std::vector<double> dragged = Cage();
  MustApply(End("drag", v1::GESTURE_PHASE_COMMIT));
  EXPECT_EQ(Cage(), dragged);

  MustApply(UndoMine());
  EXPECT_EQ(Cage(), initial_) << "both updates in one step";
  MustRefuse(UndoMine(), Nothing("UNDO"));
  MustApply(Redo());
  EXPECT_EQ(Cage(), dragged);
  MustRefuse(Redo(), Nothing("REDO"));
}

TEST_F(GesturesTest, ACommitWithEditsReplacesTheLastUpdate) {
  MustApply(Lift(0.1, "drag"));
  MustApply(Lift(0.25, "drag", v1::GESTURE_PHASE_COMMIT));
  EXPECT_DOUBLE_EQ(Z(kInner), InitialZ(kInner) + 0.25);
  MustApply(Lift(0.25, "drag"));
  EXPECT_DOUBLE_EQ(Z(kInner), InitialZ(kInner) + 0.5) << "a new gesture of the same name";

  MustApply(UndoMine());
  EXPECT_DOUBLE_EQ(Z(kInner), InitialZ(kInner) + 0.25);
  MustApply(UndoMine());
  EXPECT_EQ(Cage(), initial_);
}

TEST_F(GesturesTest, AnotherGestureCommitsTheOpenOne) {
  MustApply(Lift(0.1, "one"));
  MustApply(Lift(0.1, "two"));
  MustApply(Lift(0.1));
  EXPECT_NEAR(Z(kInner), InitialZ(kInner) + 0.3, 1e-15);

  MustApply(UndoMine());
  MustApply(UndoMine());
  EXPECT_DOUBLE_EQ(Z(kInner), InitialZ(kInner) + 0.1);
  MustApply(UndoMine());
  EXPECT_EQ(Cage(), initial_);
}

TEST_F(GesturesTest, UndoMineLeavesTheEditsOfOthers) {
  MustApply(Lift(0.1));
  v1::EditBatch theirs = Lift(0.2);
  theirs.set_editor_id("bob");
  theirs.set_sequence(1);
  theirs.mutable_edits(0)->mutable_move_control_points()->set_indices(0, kInner + 1);
  theirs.set_scene(kScene);
  ASSERT_OK(Apply(theirs));
  ++revision_;

  MustApply(UndoMine());
  EXPECT_EQ(Z(kInner), InitialZ(kInner));
  EXPECT_DOUBLE_EQ(Z(kInner + 1), InitialZ(kInner + 1) + 0.2);
  MustRefuse(UndoMine(), Nothing("UNDO"));
  MustApply(Redo());
  EXPECT_DOUBLE_EQ(Z(kInner), InitialZ(kInner) + 0.1);
}

TEST_F(GesturesTest, ReplacedTransformedAndResetControlPointsAreSeen) {
  std::vector<double> waves = initial_;
  for (size_t i = 0; i < waves.size(); i += 3) waves[i + 2] += 0.01 * static_cast<double>(i % 11);
  v1::EditBatch replace = Batch();
  replace.add_edits()->mutable_replace_control_points()->mutable_control_points()->Add(
      waves.begin(), waves.end());
  MustApply(replace);
  EXPECT_EQ(Cage(), waves);

  // x' = 2 x + 5, y' = y, z' = z for all points. The matrix is column-major.
  v1::EditBatch transform = Batch();
  auto& map = *transform.add_edits()->mutable_transform_control_points();
  for (uint32_t i = 0; i < kLatticePoints; ++i) map.add_indices(i);
  for (const double entry : {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1}) map.add_matrix(entry);
  MustApply(transform);
  const std::vector<double> mapped = Cage();
  for (size_t i = 0; i < mapped.size(); ++i) {
    EXPECT_DOUBLE_EQ(mapped[i], i % 3 == 0 ? 2 * waves[i] + 5 : waves[i]);
  }

  v1::EditBatch reset = Batch();
  reset.add_edits()->mutable_reset()->set_target(v1::RESET_TARGET_INITIAL);
  MustApply(reset);
  EXPECT_EQ(Cage(), initial_);
  MustApply(UndoMine());
  EXPECT_EQ(Cage(), mapped);
  MustApply(UndoMine());
  EXPECT_EQ(Cage(), waves);
}

TEST_F(GesturesTest, ManyEditsOfOneBatchApplyInOrderAsOneStep) {
  v1::EditBatch batch = Lift(0.5);
  auto& set = *batch.add_edits()->mutable_set_control_points();
  set.add_indices(kInner);
  for (const double x : {0.5, 0.5, 0.25}) set.add_positions(x);
  auto& move = *batch.add_edits()->mutable_move_control_points();
  move.add_indices(kInner);
  move.mutable_offset()->set_z(0.5);
  MustApply(batch);
  EXPECT_EQ(Z(kInner), 0.75);

  MustApply(UndoMine());
  EXPECT_EQ(Cage(), initial_);
}

}  // namespace
}  // namespace latticed::testing
