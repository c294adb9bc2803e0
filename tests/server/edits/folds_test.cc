// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Folds through the stub: CertifyFolds, EditResult.folds of scenes with fold_watch, and refuse_folds.
#include <array>
#include <map>
#include <random>
#include <string>

#include "core/base/vec.h"
#include "tests/server/support/server_test.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

// The default lattice around kGridObj has 4^3 control points and 2^3 knot boxes. The grid lies in the knot plane between
// the layers of boxes, so in the four lower ones. The point 21 is an inner one. A move of 2 along x folds nothing; one of
// 6 does, in two of the boxes at least.
constexpr uint32_t kFoldPoint = 21, kOtherPoint = 26;
constexpr double kSafe = 0.3, kFolding = 6;

class FoldsTest : public SceneFixture {
 protected:
  void SetUp() override {
    Restart();
    ASSERT_OK(Create(WatchedRequest()));
  }
  void Restart() {
    server_.reset();
    Options options;
    options.data_dir = folder_.Path("data");
    SceneFixture::StartServer(options);
  }
  v1::CreateSceneRequest WatchedRequest(const std::string& id = kScene) const {
    v1::CreateSceneRequest request = SceneRequest(id);
    request.set_fold_watch(true);
    return request;
  }
  v1::FoldReport Certify(v1::FoldScope scope = v1::FOLD_SCOPE_SURFACE,
                         const std::string& scene = kScene) {
    auto request = For<v1::CertifyFoldsRequest>(scene);
    request.set_scope(scope);
    v1::FoldReport report;
    EXPECT_OK(Call(&Scenes::CertifyFolds, request, &report));
    return report;
  }
  v1::EditBatch Push(uint32_t point, double x, bool refuse = true,
                     const std::string& editor = "ann") {
    v1::EditBatch batch = Move(editor, ++sequence_, point, x);
    batch.set_structure_id(Lattice().structure_id());
    batch.set_refuse_folds(refuse);
    return batch;
  }
  // Applies it, and checks that the report in the answer is that of CertifyFolds.
  v1::EditResult Applied(const v1::EditBatch& batch) {
    v1::EditResult result;
    EXPECT_OK(Apply(batch, &result));
    EXPECT_EQ(result.folds().SerializeAsString(), Certify().SerializeAsString());
    return result;
  }
  v1::EditBatch InGesture(v1::EditBatch batch, v1::GesturePhase phase) {
    batch.set_gesture_id("drag");
    batch.set_gesture_phase(phase);
    return batch;
  }
  v1::EditBatch Alone(bool refuse = true) {
    v1::EditBatch batch = Push(0, 0, refuse);
    batch.clear_edits();
    return batch;
  }
  void ExpectNewFold(const v1::EditBatch& batch) {
    const std::string before = Lattice().SerializeAsString();
    ExpectRefused(Apply(batch), Code::kFailedPrecondition, "FOLD");
    EXPECT_EQ(Lattice().SerializeAsString(), before);
  }
  double DeterminantAt(const v1::Vec3& point) {
    auto request = For<v1::EvaluatePointsRequest>();
    for (const double x : {point.x(), point.y(), point.z()}) {
      request.mutable_world_points()->add_positions(x);
    }
    v1::EvaluatePointsResponse response;
    EXPECT_OK(Call(&Scenes::EvaluatePoints, request, &response));
    if (response.jacobians_size() != 9) return 0;
    std::array<Vec3d, 3> j;
    for (int i = 0; i < 9; ++i) j[static_cast<size_t>(i / 3)][i % 3] = response.jacobians(i);
    return Dot(j[0], Cross(j[1], j[2]));
  }

  TemporaryFolder folder_;
  uint64_t sequence_ = 0;
};

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

// Two editors push, drag, undo, redo, reset and insert knots, with and without refuse_folds, and the server starts again.
TEST_F(FoldsTest, RandomEditsKeepReportsRightAndMakeNoNewFoldsUnlessTheyMay) {
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
