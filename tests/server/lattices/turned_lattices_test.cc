// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lattices that are turned against each other, through the stub: they come and go, the surface is picked where it is, and what
// does not take them says so. SumsTest has what they share with parallel ones.
#include "tests/server/lattices/removed_fixture.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

class TurnedLatticesTest : public RemovedLatticesTest {
 protected:
  v1::CreateSceneRequest WatchedRequestOf(const std::vector<v1::Lattice>& lattices) const {
    v1::CreateSceneRequest request = RequestOf(lattices);
    request.set_fold_watch(true);
    return request;
  }
  v1::FoldReport Certify(v1::FoldScope scope = v1::FOLD_SCOPE_SURFACE) {
    auto request = For<v1::CertifyFoldsRequest>();
    request.set_scope(scope);
    v1::FoldReport report;
    EXPECT_OK(Call(&Scenes::CertifyFolds, request, &report));
    return report;
  }
  // Applies it, and checks that the report in the answer is that of CertifyFolds.
  v1::FoldReport FoldsAfter(const v1::EditBatch& batch) {
    v1::EditResult result;
    EXPECT_OK(Apply(batch, &result));
    EXPECT_TRUE(result.has_folds());
    EXPECT_EQ(result.folds().SerializeAsString(), Certify().SerializeAsString());
    return result.folds();
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
  void ExpectNewFold(v1::EditBatch batch) {
    const uint64_t before = Get().revision();
    batch.set_refuse_folds(true);
    ExpectRefused(Apply(batch), Code::kFailedPrecondition, "FOLD");
    EXPECT_EQ(Get().revision(), before);
  }
  v1::WatchRequest WatchTo(double tolerance) const {
    v1::WatchRequest watch = For<v1::WatchRequest>();
    watch.mutable_view()->set_tolerance(tolerance);
    watch.set_max_unacked_updates(10);
    return watch;
  }
};

TEST_F(TurnedLatticesTest, OneComesAndGoes) {
  const v1::Lattice one = Shaken(Whole()), turned = Shaken(TurnedSpot({1, 2, 3}));
  constexpr char kBoth[] = "both-scene";
  ASSERT_OK(Create(RequestOf({one})));
  ASSERT_OK(Create(RequestOf({one, turned}, kBoth)));
  const auto alone = Chunks();
  ASSERT_OK(Apply(Put(1, turned)));
  EXPECT_TRUE(Chunks() == Chunks(kBoth));
  EXPECT_EQ(Get().patches(), Get(kBoth).patches());
  EXPECT_EQ(Get().patches_on_faces(), 0u);
  EXPECT_EQ(Get().pipeline(), v1::PIPELINE_GEMM);
  ASSERT_OK(Apply(Remove(1)));
  EXPECT_TRUE(Chunks() == alone);
  EXPECT_EQ(Get().pipeline(), v1::PIPELINE_FUSED);
  ASSERT_OK(Apply(Undo(1)));
  EXPECT_TRUE(Chunks() == Chunks(kBoth));
  Restart();
  EXPECT_TRUE(Chunks() == Chunks(kBoth));
}

// The frames are where they are: neither order nor the other lattice's parameters matter.
TEST_F(TurnedLatticesTest, TheFirstMayBeTheTurnedOne) {
  constexpr char kOther[] = "other-scene";
  const v1::Lattice one = Shaken(Whole()), turned = Shaken(TurnedSpot());
  ASSERT_OK(Create(RequestOf({turned, one})));
  ASSERT_OK(Create(RequestOf({one, turned}, kOther)));
  const std::vector<Vec3d> world = SomePoints(200);
  const auto first = Evaluate(world), second = Evaluate(world, kOther);
  for (size_t n = 0; n < world.size(); ++n) EXPECT_LE(Norm(first[n] - second[n]), 1e-13);
  // Beyond the spot, patches of the first lattice's outside are moved by the other one.
  auto request = For<v1::PickRequest>();
  *request.mutable_ray()->mutable_origin() = ToVec3({0.93, 0.94, 5});
  *request.mutable_ray()->mutable_direction() = ToVec3({0, 0, -1});
  v1::SurfacePoint point;
  ASSERT_OK(Call(&Scenes::Pick, request, &point));
  request.set_scene(kOther);
  v1::SurfacePoint other;
  ASSERT_OK(Call(&Scenes::Pick, request, &other));
  EXPECT_NEAR(point.position().z(), other.position().z(), 1e-9);
  EXPECT_GT(std::abs(point.position().z() - 1), 1e-4);
}

TEST_F(TurnedLatticesTest, APickFindsWhatEvaluatePointsHas) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole()), Shaken(TurnedSpot())})));
  for (const Vec3d target : {Vec3d{0.5, 0.5, 0}, {0.45, 0.4, 0}, {0.9, 0.8, 0}, {0.1, 0.9, 1}}) {
    const Vec3d origin{0.4, 0.3, -7}, direction = target - origin;
    auto request = For<v1::PickRequest>();
    *request.mutable_ray()->mutable_origin() = ToVec3(origin);
    *request.mutable_ray()->mutable_direction() = ToVec3(direction);
    v1::SurfacePoint point;
    ASSERT_OK(Call(&Scenes::Pick, request, &point));
    auto points = For<v1::EvaluatePointsRequest>();
    *points.mutable_surface_points()->add_points() = point;
    v1::EvaluatePointsResponse at;
    ASSERT_OK(Call(&Scenes::EvaluatePoints, points, &at));
    const Vec3d d = Vec3d{at.positions(0), at.positions(1), at.positions(2)} - origin;
    EXPECT_LE(Norm(Cross(d, direction)), 1e-9 * Norm(d) * Norm(direction));
    EXPECT_NEAR(point.position().z(), at.positions(2), 1e-12);
  }
}

TEST_F(TurnedLatticesTest, TheQuantisationBoxHoldsWhatBothMove) {
  ASSERT_OK(Create(RequestOf({Whole(), TurnedSpot()})));
  v1::WatchRequest watch = For<v1::WatchRequest>();
  watch.mutable_view()->set_encoding(v1::ENCODING_QUANTISED);
  watch.set_max_unacked_updates(10);
  WatchClient watcher(*scenes_, watch);
  watcher.ReadUpdates(1);
  for (const uint32_t number : {0u, 1u}) {
    v1::EditBatch batch = Batch(number);
    auto& move = *batch.add_edits()->mutable_move_control_points();
    for (uint32_t i = 0; i < 64; ++i) move.add_indices(i);
    *move.mutable_offset() = ToVec3({3, 0, 0});
    ASSERT_OK(Apply(batch));
  }
  watcher.ReadUntilRevision(2);
  // (0.5, 0.4, 0) is in both, and has moved by 6.
  EXPECT_NEAR(Evaluate(Vec3d{0.5, 0.4, 0}).x, 6.5, 1e-9);
  const v1::Quantisation& box = watcher.log.quantisations.back();
  EXPECT_GE(box.origin().x() + box.step() * ((1 << box.bits()) - 1), 6.5);
}

TEST_F(TurnedLatticesTest, PatchesAreRefused) {
  ASSERT_OK(Create(RequestOf({Whole(), TurnedSpot()})));
  v1::WatchRequest patches = For<v1::WatchRequest>();
  patches.mutable_view()->set_encoding(v1::ENCODING_PATCHES);
  WatchClient watcher(*scenes_, patches);
  ExpectRefused(watcher.Finish(), Code::kInvalidArgument, "UNSUPPORTED", "view.encoding");
}

// A turned lattice comes, moves and goes; each update has a certificate.
TEST_F(TurnedLatticesTest, AWatcherWithAToleranceGoesOn) {
  constexpr double kTolerance = 0.01;
  ASSERT_OK(Create(RequestOf({Whole()})));
  WatchClient watcher(*scenes_, WatchTo(kTolerance));
  watcher.ReadUpdates(1);
  ASSERT_OK(Apply(Put(1, TurnedSpot())));
  watcher.ReadUntilRevision(1);
  v1::EditBatch batch = Batch(1);
  auto& move = *batch.add_edits()->mutable_move_control_points();
  move.add_indices(21);
  *move.mutable_offset() = ToVec3({0, 0, 0.3});
  ASSERT_OK(Apply(batch));
  watcher.ReadUntilRevision(2);
  EXPECT_GT(watcher.log.ends.back().certified_error(), 0);
  ASSERT_OK(Apply(Remove(1)));
  watcher.ReadUntilRevision(3);
  for (const auto& end : watcher.log.ends) EXPECT_LE(end.certified_error(), kTolerance);
}

// Folds inside the volume, and in the part of the turned frame outside the first one, as EvaluatePoints has them.
TEST_F(TurnedLatticesTest, FoldsOfTheVolumeAreThoseOfBothLattices) {
  ASSERT_OK(Create(RequestOf({Whole(), TurnedSpot()})));
  const v1::FoldReport rest = Certify(v1::FOLD_SCOPE_VOLUME);
  EXPECT_TRUE(rest.certified());
  EXPECT_GE(rest.boxes(), Certify().boxes());
  for (const uint32_t number : {0u, 1u}) {
    ASSERT_OK(Apply(Push(number, 21, {0.05, 0, 0})));
    EXPECT_TRUE(Certify(v1::FOLD_SCOPE_VOLUME).certified());
    ASSERT_OK(Apply(Push(number, 21, {4, 1, 0})));

    const v1::FoldReport folded = Certify(v1::FOLD_SCOPE_VOLUME);

    EXPECT_EQ(folded.boxes(), rest.boxes());
    ASSERT_GT(folded.folded(), 0u);
    EXPECT_EQ(folded.undecided(), 0u);
    for (const v1::FoldedBox& place : folded.places()) {
      EXPECT_LE(place.determinant(), 0);
      EXPECT_NEAR(DeterminantAt(place.rest_point()), place.determinant(), 1e-9);
    }
    ASSERT_OK(Apply(Push(number, 21, {-4, -1, 0})));
    EXPECT_TRUE(Certify(v1::FOLD_SCOPE_VOLUME).certified());
  }
}

TEST_F(TurnedLatticesTest, FoldsOfTheVolumeOutsideTheFirstLatticeAreFound) {
  ASSERT_OK(Create(RequestOf({TurnedSpot(), Whole()})));
  const v1::FoldReport rest = Certify(v1::FOLD_SCOPE_VOLUME);
  EXPECT_TRUE(rest.certified());
  ASSERT_OK(Apply(Push(1, 0, {3, 3, 3})));  // a corner, which is outside the spot's frame

  const v1::FoldReport report = Certify(v1::FOLD_SCOPE_VOLUME);

  EXPECT_EQ(report.boxes(), rest.boxes());
  ASSERT_GT(report.folded(), 0u);
  EXPECT_EQ(report.undecided(), 0u);
  const v1::FoldedBox& outside = report.places(report.places_size() - 1);
  EXPECT_EQ(outside.box().u(), -1);
  EXPECT_LE(outside.determinant(), 0);
  EXPECT_NEAR(DeterminantAt(outside.rest_point()), outside.determinant(), 1e-9);
}

TEST_F(TurnedLatticesTest, FoldsAreThoseOfBothLattices) {
  ASSERT_OK(Create(WatchedRequestOf({Whole(), TurnedSpot()})));
  const v1::FoldReport rest = Certify();
  EXPECT_TRUE(rest.certified());
  EXPECT_GT(rest.boxes(), 0u);
  for (const uint32_t number : {0u, 1u}) {
    v1::EditBatch gentle = Push(number, 21, {0.05, 0, 0});
    gentle.set_refuse_folds(true);
    EXPECT_TRUE(FoldsAfter(gentle).certified());
    ExpectNewFold(Push(number, 21, {4, 1, 0}));
    const v1::FoldReport folded = FoldsAfter(Push(number, 21, {4, 1, 0}));
    EXPECT_FALSE(folded.certified());
    ASSERT_GT(folded.folded(), 0u);
    EXPECT_LE(folded.places(0).determinant(), 0);
    EXPECT_NEAR(DeterminantAt(folded.places(0).rest_point()), folded.places(0).determinant(), 1e-9);
    EXPECT_EQ(folded.boxes(), rest.boxes());
    EXPECT_TRUE(FoldsAfter(Push(number, 21, {-4, -1, 0})).certified());
  }
}

// What lies outside the first lattice's frame has one place in a report.
TEST_F(TurnedLatticesTest, FoldsOutsideTheFirstLatticeAreFound) {
  ASSERT_OK(Create(WatchedRequestOf({TurnedSpot()})));
  const uint64_t boxes = Certify().boxes();
  ASSERT_OK(Apply(Put(1, Whole())));
  EXPECT_EQ(Certify().boxes(), boxes + 1);
  const auto mirrored = [this] {
    v1::EditBatch batch = Batch(1);
    auto& map = *batch.add_edits()->mutable_transform_control_points();
    for (uint32_t i = 0; i < 64; ++i) map.add_indices(i);
    for (int i = 0; i < 16; ++i) map.add_matrix(i == 0 ? -1 : i % 5 == 0 ? 1 : 0);
    return batch;
  };
  ExpectNewFold(mirrored());
  const v1::FoldReport report = FoldsAfter(mirrored());
  ASSERT_EQ(report.folded(), boxes + 1);
  const v1::FoldedBox& outside = report.places(report.places_size() - 1);
  EXPECT_EQ(outside.box().u(), -1);
  EXPECT_EQ(outside.box().v(), -1);
  EXPECT_EQ(outside.box().w(), -1);
  EXPECT_NEAR(outside.determinant(), -1, 1e-9);
}

TEST_F(TurnedLatticesTest, ALatticeThatFoldsIsRefused) {
  ASSERT_OK(Create(WatchedRequestOf({Whole()})));
  v1::Lattice folding = TurnedSpot();
  for (int i = 0; i < 64; ++i) {  // all in one point
    for (const double x : {0.5, 0.3, 0.1}) folding.add_control_points(x);
  }
  ExpectNewFold(Put(1, folding));
  v1::EditBatch gentle = Put(1, TurnedSpot());
  gentle.set_refuse_folds(true);
  EXPECT_TRUE(FoldsAfter(gentle).certified());
  EXPECT_FALSE(FoldsAfter(Put(1, folding)).certified());
  EXPECT_TRUE(FoldsAfter(Remove(1)).certified());
}

}  // namespace
}  // namespace latticed::testing
