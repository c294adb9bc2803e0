// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Folds through the stub: CertifyFolds, EditResult.folds of scenes with fold_watch, and refuse_folds.
#include "tests/server/edits/folds_fixture.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

TEST_F(FoldsTest, ASceneAtRestIsCertified) {
  const v1::FoldReport surface = Certify(v1::FOLD_SCOPE_UNSPECIFIED);
  const v1::FoldReport volume = Certify(v1::FOLD_SCOPE_VOLUME);

  EXPECT_TRUE(surface.certified());
  EXPECT_EQ(surface.boxes(), 4u);
  EXPECT_EQ(surface.structure_id(), 1u);
  EXPECT_TRUE(volume.certified());
  EXPECT_EQ(volume.boxes(), 8u);
  EXPECT_EQ(volume.folded() + volume.undecided(), 0u);
}

TEST_F(FoldsTest, AFoldHasItsBoxItsPointAndItsDeterminant) {
  ASSERT_OK(Apply(Push(kFoldPoint, kFolding, false)));

  const v1::FoldReport report = Certify();

  EXPECT_FALSE(report.certified());
  EXPECT_EQ(report.revision(), 1u);
  ASSERT_GE(report.folded(), 1u);
  ASSERT_EQ(static_cast<uint64_t>(report.places_size()), report.folded() + report.undecided());
  const v1::FoldedBox& place = report.places(0);
  EXPECT_EQ(place.state(), v1::FOLD_STATE_FOLDED);
  EXPECT_EQ(place.box().w(), 0);
  EXPECT_LE(place.box().u(), 1);
  EXPECT_LE(place.determinant(), 0);
  EXPECT_EQ(place.rest_point().z(), 0);  // the part of the box that has patches is flat
  EXPECT_NEAR(DeterminantAt(place.rest_point()), place.determinant(), 1e-12);
}

TEST_F(FoldsTest, BadRequestsAreRefused) {
  auto request = For<v1::CertifyFoldsRequest>("");
  ExpectRefused(Call(&Scenes::CertifyFolds, request), Code::kInvalidArgument, "INVALID_FIELD",
                "scene");
  request.set_scene("unknown");
  ExpectRefused(Call(&Scenes::CertifyFolds, request), Code::kNotFound, "NOT_FOUND");
  request = For<v1::CertifyFoldsRequest>();
  request.set_scope(static_cast<v1::FoldScope>(7));
  ExpectRefused(Call(&Scenes::CertifyFolds, request), Code::kInvalidArgument, "UNSUPPORTED",
                "scope");
}

TEST_F(FoldsTest, ANewFoldIsRefusedWithItsPlace) {
  const absl::Status refusal = Apply(Push(kFoldPoint, kFolding));

  ExpectRefused(refusal, Code::kFailedPrecondition, "FOLD");
  const auto metadata = error::DetailsOf(refusal).metadata;
  EXPECT_EQ(metadata.at("box").substr(metadata.at("box").size() - 2), " 0");
  EXPECT_FALSE(metadata.at("rest_point").empty());
  EXPECT_LE(std::stod(metadata.at("determinant")), 0);
  EXPECT_EQ(Lattice().revision(), 0u);
  EXPECT_OK(Apply(Push(kFoldPoint, kSafe)));
}

TEST_F(FoldsTest, ARefusalIsRepeatedForTheSameSequence) {
  const v1::EditBatch batch = Push(kFoldPoint, kFolding);
  ExpectNewFold(batch);
  ExpectNewFold(batch);

  Restart();

  ExpectNewFold(batch);
}

TEST_F(FoldsTest, AnOldFoldMayStayDeepenAndMend) {
  ASSERT_OK(Apply(Push(kFoldPoint, kFolding, false)));

  EXPECT_OK(Apply(Push(kFoldPoint, 0)));
  EXPECT_OK(Apply(Push(kFoldPoint, 0.5)));
  EXPECT_OK(Apply(Push(kFoldPoint, -1)));
  ASSERT_OK(Apply(Push(kFoldPoint, 0.5 - kFolding)));
  EXPECT_TRUE(Certify().certified());
  ExpectNewFold(Push(kFoldPoint, kFolding));
}

TEST_F(FoldsTest, AFoldInAnotherBoxIsNew) {
  ASSERT_OK(Apply(Push(kFoldPoint, 3.4, false)));
  const v1::FoldReport one = Certify();
  ASSERT_FALSE(one.certified());
  ASSERT_LT(one.folded(), 4u) << "the test needs a box that is not folded";

  ExpectNewFold(Push(kFoldPoint, 3 * kFolding));
}

TEST_F(FoldsTest, UndoAndRedoAlwaysPass) {
  ASSERT_OK(Apply(Push(kFoldPoint, kFolding, false)));
  ASSERT_OK(Apply(Push(kFoldPoint, -kFolding)));
  ASSERT_TRUE(Certify().certified());
  v1::EditBatch undo = Alone();
  undo.add_edits()->mutable_undo();

  EXPECT_GT(Applied(undo).folds().folded(), 0u);

  undo.set_sequence(++sequence_);
  EXPECT_TRUE(Applied(undo).folds().certified());
  v1::EditBatch redo = Alone();
  redo.add_edits()->mutable_redo();
  EXPECT_GT(Applied(redo).folds().folded(), 0u);
}

TEST_F(FoldsTest, ADragStopsAtTheLastCertifiedState) {
  const auto update = v1::GESTURE_PHASE_UPDATE;
  ASSERT_OK(Apply(InGesture(Push(kFoldPoint, 0.1), update)));
  ASSERT_OK(Apply(InGesture(Push(kFoldPoint, kSafe), update)));
  const v1::LatticeState last = Lattice();

  ExpectNewFold(InGesture(Push(kFoldPoint, kFolding), update));
  ExpectNewFold(InGesture(Push(kFoldPoint, 2 * kFolding), v1::GESTURE_PHASE_COMMIT));
  EXPECT_OK(Apply(InGesture(Alone(), v1::GESTURE_PHASE_COMMIT)));

  EXPECT_EQ(Lattice().lattice().SerializeAsString(), last.lattice().SerializeAsString());
}

// An update leads from the gesture's start: what the last update moved, and this one does not, moves back.
TEST_F(FoldsTest, AGesturesUpdateIsTakenBackBeforeTheNextOneIsJudged) {
  const auto update = v1::GESTURE_PHASE_UPDATE;
  ASSERT_OK(Apply(InGesture(Push(kFoldPoint, kFolding, false), update)));
  ASSERT_FALSE(Certify().certified());

  EXPECT_TRUE(Applied(InGesture(Push(kOtherPoint, kSafe), update)).folds().certified());
}

TEST_F(FoldsTest, CancelAlwaysPasses) {
  ASSERT_OK(Apply(Push(kFoldPoint, kFolding, false)));
  ASSERT_OK(Apply(InGesture(Push(kFoldPoint, -kFolding), v1::GESTURE_PHASE_UPDATE)));
  ASSERT_TRUE(Certify().certified());

  EXPECT_GT(Applied(InGesture(Alone(), v1::GESTURE_PHASE_CANCEL)).folds().folded(), 0u);
}

TEST_F(FoldsTest, ResetAndReplacedControlPointsAreJudgedToo) {
  v1::EditBatch mirror = Alone();
  auto& points = *mirror.add_edits()->mutable_replace_control_points()->mutable_control_points();
  points = Lattice().lattice().control_points();
  for (int i = 0; i < points.size(); i += 3) points[i] = -points[i];
  ExpectNewFold(mirror);
  mirror.set_sequence(++sequence_);
  mirror.set_refuse_folds(false);
  ASSERT_OK(Apply(mirror));
  v1::EditBatch reset = Alone();
  reset.add_edits()->mutable_reset();
  EXPECT_TRUE(Applied(reset).folds().certified());
}

TEST_F(FoldsTest, KnotInsertionPassesAndAReplacedLatticeIsJudgedAsAWhole) {
  ASSERT_OK(Apply(Push(kFoldPoint, kFolding, false)));
  v1::EditBatch knot = Knot("ann", ++sequence_);
  knot.set_refuse_folds(true);
  const v1::EditResult inserted = Applied(knot);
  EXPECT_EQ(inserted.folds().boxes(), 6u);
  EXPECT_GT(inserted.folds().folded(), 0u);

  v1::EditBatch mirror = Alone();
  v1::Lattice& lattice = *mirror.add_edits()->mutable_replace_lattice()->mutable_lattice();
  lattice = Lattice().lattice();
  SetAxes(*lattice.mutable_size(), 3, 3, 3);
  lattice.clear_knots_u();
  lattice.clear_control_points();
  for (int i = 0; i < 27; ++i) {  // mirrored along x
    for (const int c : {1 - i % 3, i / 3 % 3, i / 9 - 1}) lattice.add_control_points(c);
  }
  lattice.clear_knots_v();
  lattice.clear_knots_w();
  EXPECT_GT(Applied(mirror).folds().folded(), 0u);  // the scene was folded before

  v1::EditBatch reset = Alone();
  reset.add_edits()->mutable_reset();
  ASSERT_TRUE(Applied(reset).folds().certified());
  mirror.mutable_edits(0)
      ->mutable_replace_lattice()
      ->mutable_lattice()
      ->mutable_frame()
      ->mutable_origin()
      ->set_x(-0.2);
  mirror.set_structure_id(Lattice().structure_id());
  mirror.set_sequence(++sequence_);
  ExpectNewFold(mirror);
}

TEST_F(FoldsTest, EditResultsOfAWatchedSceneHaveAReport) {
  EXPECT_TRUE(Get().fold_watch());
  EXPECT_TRUE(Applied(Push(kFoldPoint, kSafe, false)).folds().certified());
  EXPECT_GT(Applied(Push(kFoldPoint, kFolding, false)).folds().folded(), 0u);
  EXPECT_GT(Applied(Push(kOtherPoint, kSafe, false, "bob")).folds().folded(), 0u);
  v1::EditBatch undo = Alone(false);
  undo.add_edits()->mutable_undo();
  EXPECT_TRUE(Applied(undo).folds().certified());
}

TEST_F(FoldsTest, ARepeatedResultHasNoReport) {
  const v1::EditBatch batch = Push(kFoldPoint, kSafe, false);
  ASSERT_TRUE(Applied(batch).has_folds());
  v1::EditResult repeated;

  ASSERT_OK(Apply(batch, &repeated));

  EXPECT_EQ(repeated.revision(), 1u);
  EXPECT_FALSE(repeated.has_folds());
}

TEST_F(FoldsTest, OtherScenesHaveNoReportAndRefuseFoldsAllTheSame) {
  ASSERT_OK(Create(SceneRequest("scene-two")));
  EXPECT_FALSE(Get("scene-two").fold_watch());
  v1::EditBatch batch = MoveOne("ann", 1, kFoldPoint, {kSafe, 0, 0});
  batch.set_scene("scene-two");
  batch.set_refuse_folds(true);
  v1::EditResult result;
  ASSERT_OK(Apply(batch, &result));
  EXPECT_FALSE(result.has_folds());
  batch.set_sequence(2);
  batch.mutable_edits(0)->mutable_move_control_points()->mutable_offset()->set_x(kFolding);
  ExpectRefused(Apply(batch), Code::kFailedPrecondition, "FOLD");
}

TEST_F(FoldsTest, FoldWatchIsPartOfWhatASceneIsMadeFrom) {
  ExpectRefused(Create(SceneRequest()), Code::kAlreadyExists, "ALREADY_EXISTS");
  EXPECT_OK(Create(WatchedRequest()));
}

TEST_F(FoldsTest, AServerThatStartsAgainStillWatches) {
  ASSERT_OK(Apply(Push(kFoldPoint, kFolding, false)));

  Restart();

  EXPECT_TRUE(Get().fold_watch());
  EXPECT_GT(Certify().folded(), 0u);
  EXPECT_GT(Applied(Push(kOtherPoint, 0)).folds().folded(), 0u);
  EXPECT_TRUE(Applied(Push(kFoldPoint, -kFolding)).folds().certified());
  ExpectNewFold(Push(kFoldPoint, kFolding));
}

TEST_F(FoldsTest, AStreamAnswersWithReportsAndRefusals) {
  auto watch = For<v1::WatchRequest>();
  watch.set_editor_id("ann");
  DeformClient stream(*scenes_, watch);
  stream.ReadUntilRevision(0);
  ASSERT_TRUE(stream.Send(Push(kFoldPoint, kSafe)));
  ASSERT_TRUE(stream.Send(Push(kFoldPoint, kFolding)));
  v1::EditBatch mirror = Alone();  // a worker looks at so many control points
  auto& points = *mirror.add_edits()->mutable_replace_control_points()->mutable_control_points();
  points = Lattice().lattice().control_points();
  for (int i = 0; i < points.size(); i += 3) points[i] = -points[i];
  ASSERT_TRUE(stream.Send(mirror));
  ASSERT_TRUE(stream.Send(Push(kFoldPoint, kFolding, false)));

  stream.ReadUntil([&] { return stream.log.results.size() == 4; });

  EXPECT_TRUE(stream.log.results[0].folds().certified());
  EXPECT_EQ(stream.log.results[1].status().code(), static_cast<int>(Code::kFailedPrecondition));
  EXPECT_FALSE(stream.log.results[1].has_folds());
  EXPECT_EQ(stream.log.results[2].status().code(), static_cast<int>(Code::kFailedPrecondition));
  EXPECT_GT(stream.log.results[3].folds().folded(), 0u);
  EXPECT_EQ(stream.log.results[3].folds().revision(), 2u);
}

}  // namespace
}  // namespace latticed::testing
