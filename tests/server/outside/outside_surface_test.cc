// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes whose lattice goes on outside its frame: the surface, its measures, and what edits do.
#include <cmath>
#include <random>

#include "tests/server/outside/outside_fixture.h"
#include "tests/server/points/point_set_client.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

constexpr uint32_t kOutsideSeed = 31;
constexpr char kFixed[] = "fixed-scene";

TEST_F(OutsideSceneTest, TheInsideIsThatOfAFixedLattice) {
  ASSERT_OK(Create(RequestFor(HalfLattice(), kFixed)));
  ASSERT_OK(Create(RequestFor(Falloff(0.5))));
  std::mt19937 random(kOutsideSeed);
  std::uniform_real_distribution<double> move(-0.2, 0.2), x(-0.1, kFaceAt), yz(-0.1, 1.1);
  for (uint32_t point = 0; point < 64; ++point) {
    v1::EditBatch batch = MoveOne("ann", point + 1, point, {move(random), move(random), 0.1});
    ASSERT_OK(Apply(batch));
    batch.set_scene(kFixed);
    ASSERT_OK(Apply(batch));
  }
  std::vector<Vec3d> world;
  for (int n = 0; n < 200; ++n) world.push_back({x(random), yz(random), yz(random)});
  const auto fixed = Evaluate(world, kFixed), falloff = Evaluate(world);
  for (size_t n = 0; n < world.size(); ++n) {
    EXPECT_LE(Norm(fixed[n] - falloff[n]), 1e-14) << n << ", seed " << kOutsideSeed;
  }
}

TEST_F(OutsideSceneTest, AFalloffLeavesNoTearAndEnds) {
  ASSERT_OK(Create(RequestFor(HalfLattice(), kFixed)));
  ASSERT_OK(Create(RequestFor(Falloff(0.5))));
  EXPECT_GT(Get(kFixed).patches_on_faces(), 0u);
  EXPECT_EQ(Get().patches_on_faces(), 0u);
  ASSERT_OK(Apply(MoveFace(1, {0, 0, 0.25})));
  ASSERT_OK(Apply(MoveFace(1, {0, 0, 0.25}, kFixed)));

  EXPECT_NEAR(Evaluate({kFaceAt, 0.5, 0.5}).z, 0.75, 1e-12);
  EXPECT_NEAR(Evaluate({kFaceAt + 1e-9, 0.5, 0.5}).z, 0.75, 1e-6);
  EXPECT_EQ(Evaluate({kFaceAt + 1e-9, 0.5, 0.5}, kFixed).z, 0.5);
  const double middle = Evaluate({kFaceAt + 0.1, 0.5, 0.5}).z;
  EXPECT_GT(middle, 0.52);
  EXPECT_LT(middle, 0.75);
  EXPECT_EQ(Evaluate({kFaceAt + 0.5 * 0.6 + 1e-9, 0.5, 0.5}).z, 0.5);

  v1::MeasureSceneResponse got;
  EXPECT_OK(Volume(&got));
  auto torn = For<v1::MeasureSceneRequest>(kFixed);
  torn.add_measures(v1::MEASURE_VOLUME);
  ExpectRefused(Call(&Scenes::MeasureScene, torn), Code::kFailedPrecondition, "OPEN_SURFACE");
}

TEST_F(OutsideSceneTest, ALinearContinuationReachesTheWholeMesh) {
  ASSERT_OK(Create(RequestFor(Linear())));
  const v1::LatticeOutside outside = Lattice().lattice().outside();
  EXPECT_EQ(outside.mode(), v1::OUTSIDE_MODE_LINEAR);
  ASSERT_EQ(outside.widths_size(), 6);
  EXPECT_NEAR(outside.widths(1), 17. / 16 * 0.5 / 0.6, 1e-12);
  EXPECT_EQ(outside.widths(0), 0);
  EXPECT_EQ(Get().patches_outside(), 0u);
  EXPECT_EQ(Get().patches_on_faces(), 0u);
  // A shear, which goes on as it is.
  v1::EditBatch shear = MoveOne("ann", 1, 0, {});
  auto& transform = *shear.mutable_edits(0)->mutable_transform_control_points();
  for (uint32_t i = 0; i < 64; ++i) transform.add_indices(i);
  for (const double m : {1., 0., 0.5, 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.}) {
    transform.add_matrix(m);
  }
  ASSERT_OK(Apply(shear));
  const Vec3d corner = Evaluate({1, 1, 1});
  EXPECT_LE(Norm(corner - Vec3d{1, 1, 1.5}), 1e-12);
  v1::MeasureSceneResponse got;
  ASSERT_OK(Volume(&got));
  EXPECT_NEAR(got.volume(), 1, 1e-12);
}

TEST_F(OutsideSceneTest, ALinearContinuationOfAnEnclosedMeshIsFixed) {
  v1::Lattice lattice = Linear();
  SetFrame(*lattice.mutable_frame(), {-1, -1, -1}, {3, 3, 3});
  ASSERT_OK(Create(RequestFor(lattice)));
  EXPECT_FALSE(Lattice().lattice().has_outside());
}

TEST_F(OutsideSceneTest, MeasuresAndTheirGradientsAreOfTheWholeSurface) {
  ASSERT_OK(Create(RequestFor(Falloff(0.7))));
  ASSERT_OK(Apply(MoveFace(1, {0.1, 0.05, 0.2})));
  constexpr uint32_t kPoint = 3 + 4 * 5;  // in the face
  constexpr double kMove = 1e-5;
  auto request = For<v1::MeasureSceneRequest>();
  for (const auto m : {v1::MEASURE_VOLUME, v1::MEASURE_AREA, v1::MEASURE_CENTROID}) {
    request.add_measures(m);
  }
  request.set_with_gradient(true);
  request.set_area_tolerance(1e-10);
  v1::MeasureSceneResponse before, after;
  ASSERT_OK(Call(&Scenes::MeasureScene, request, &before));
  ASSERT_EQ(before.volume_gradient_size(), 3 * 64);
  ASSERT_EQ(before.area_gradient_size(), 3 * 64);
  ASSERT_EQ(before.centroid_gradient_size(), 9 * 64);
  ASSERT_OK(Apply(MoveOne("ann", 2, kPoint, {0, 0, kMove})));
  ASSERT_OK(Call(&Scenes::MeasureScene, request, &after));
  EXPECT_NEAR((after.volume() - before.volume()) / kMove, before.volume_gradient(3 * kPoint + 2),
              1e-4);
  EXPECT_NEAR((after.area() - before.area()) / kMove, before.area_gradient(3 * kPoint + 2), 1e-3);
  EXPECT_NEAR((after.centroid().z() - before.centroid().z()) / kMove,
              before.centroid_gradient(9 * kPoint + 8), 1e-3);
  EXPECT_GT(std::abs(before.area_gradient(3 * kPoint + 2)), 1e-4);
}

TEST_F(OutsideSceneTest, EditsKeepTheVolume) {
  ASSERT_OK(Create(RequestFor(Falloff(0.7))));
  v1::EditBatch keep = MoveOne("ann", 1, 0, {});
  keep.mutable_edits(0)->mutable_set_constraints()->mutable_constraints()->mutable_volume();
  ASSERT_OK(Apply(keep));
  ASSERT_OK(Apply(MoveFace(2, {0.1, 0, 0.1})));
  v1::MeasureSceneResponse got;
  ASSERT_OK(Volume(&got));
  EXPECT_NEAR(got.volume(), 1, 1e-11);
  EXPECT_NE(Evaluate({0.7, 0.5, 0.5}).z, 0.5);
}

TEST_F(OutsideSceneTest, PointsBeyondTheFaceAreDragged) {
  ASSERT_OK(Create(RequestFor(Falloff(1))));
  // On the cube's face z = 0, at x = 0.7.
  v1::EditBatch batch = MoveOne("ann", 1, 0, {});
  auto& drag = *batch.mutable_edits(0)->mutable_drag_points();
  auto& point = *drag.add_points();
  point.set_face(0);
  for (const uint32_t corner : {0u, 2u, 3u}) point.add_corners(corner);  // (0,1) (1,0) (0,0)
  for (const double b : {0.2, 0.7, 0.1}) point.add_barycentrics(b);
  for (const double x : {0.7, 0.2, -0.1}) drag.add_targets(x);
  v1::EditResult result;
  ASSERT_OK(Apply(batch, &result));
  EXPECT_LE(result.drag_residual(), 1e-12);
  EXPECT_LE(Norm(Evaluate({0.7, 0.2, 0}) - Vec3d{0.7, 0.2, -0.1}), 1e-12);
}

TEST_F(OutsideSceneTest, KnotsUndoAndReplacementsKeepTheirShape) {
  ASSERT_OK(Create(RequestFor(Falloff(0.5))));
  ASSERT_OK(Apply(MoveFace(1, {0.05, 0, 0.2})));
  std::vector<Vec3d> world;
  for (int n = 0; n < 40; ++n) world.push_back({-0.1 + n * 0.03, 0.3, 0.02 * n});
  const auto start = Evaluate(world);
  const auto expect_start = [&](const char* when) {
    const auto now = Evaluate(world);
    for (size_t n = 0; n < world.size(); ++n) {
      EXPECT_LE(Norm(now[n] - start[n]), 1e-12) << when << ' ' << n;
    }
  };
  v1::EditBatch knot = MoveOne("ann", 2, 0, {});
  knot.mutable_edits(0)->mutable_insert_knot()->set_value(
      1.9);  // in the last span, which has an end
  ASSERT_OK(Apply(knot));
  expect_start("after a knot");
  EXPECT_EQ(Lattice().lattice().size().u(), 5);

  ASSERT_OK(Apply(Replace(3, HalfLattice(), 2)));
  EXPECT_FALSE(Lattice().lattice().has_outside());
  EXPECT_GT(Get().patches_on_faces(), 0u);
  ASSERT_OK(Apply(UndoMine("ann", 4)));
  expect_start("after a replacement that was undone");
  EXPECT_TRUE(Lattice().lattice().has_outside());
  ASSERT_OK(Apply(UndoMine("ann", 5)));
  ASSERT_OK(Apply(UndoMine("ann", 6)));
  EXPECT_NEAR(Evaluate({0.6, 0.5, 0.5}).z, 0.5, 1e-15);
}

TEST_F(OutsideSceneTest, FoldsOutsideAreFoundAndRefused) {
  v1::CreateSceneRequest request = RequestFor(Falloff(0.2));
  request.set_fold_watch(true);
  ASSERT_OK(Create(request));
  const auto certify = [this] {
    auto ask = For<v1::CertifyFoldsRequest>();
    ask.set_scope(v1::FOLD_SCOPE_SURFACE);
    v1::FoldReport report;
    EXPECT_OK(Call(&Scenes::CertifyFolds, ask, &report));
    return report;
  };
  // The face moves by more than the falloff is wide: what is between folds, and nothing inside.
  v1::EditBatch batch = MoveFace(1, {0.4, 0, 0});
  batch.set_refuse_folds(true);
  ExpectRefused(Apply(batch), Code::kFailedPrecondition, "FOLD");
  batch.set_refuse_folds(false);
  batch.set_sequence(2);
  v1::EditResult result;
  ASSERT_OK(Apply(batch, &result));
  EXPECT_GT(result.folds().folded(), 0u);
  EXPECT_EQ(result.folds().SerializeAsString(), certify().SerializeAsString());
  for (const auto& place : result.folds().places())
    EXPECT_GT(place.rest_point().x(), kFaceAt - 1e-9);
  ASSERT_OK(Apply(UndoMine("ann", 3), &result));
  EXPECT_EQ(result.folds().folded(), 0u);
  EXPECT_EQ(result.folds().SerializeAsString(), certify().SerializeAsString());
}

TEST_F(OutsideSceneTest, DerivativesOfPointSetsAreByTheGivenControlPoints) {
  ASSERT_OK(Create(RequestFor(Falloff(0.6))));
  ASSERT_OK(Apply(MoveFace(1, {0, 0.1, 0.2})));
  PointSetClient client(server_->channel());
  const std::vector<Vec3d> world{{0.3, 0.3, 0.4}, {0.6, 0.5, 0.5}, {0.7, 0.2, 0.9}, {3, 3, 3}};
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client.CreateWorld(world));
  EXPECT_EQ(set.points_outside(), 1u);
  ASSERT_OK_AND_ASSIGN(const auto before, client.Deform(set));
  const auto evaluated = Evaluate(world);
  for (size_t n = 0; n < world.size(); ++n) {
    EXPECT_LE(Norm(before.vectors[n] - evaluated[n]), 1e-14);
  }

  std::mt19937 random(kOutsideSeed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Vec3d> tangents(2 * 64), cotangents(2 * world.size());
  for (Vec3d& v : tangents) v = {uniform(random), uniform(random), uniform(random)};
  for (Vec3d& v : cotangents) v = {uniform(random), uniform(random), uniform(random)};
  auto forward = For<v1::ApplyJacobianRequest>();
  forward.set_point_set(set.id());
  forward.set_tangents(BytesOf(tangents));
  ASSERT_OK_AND_ASSIGN(const auto moves, client.ApplyJacobian(forward));
  ASSERT_EQ(moves.vectors.size(), 2 * world.size());
  auto header = For<v1::CotangentHeader>();
  header.set_point_set(set.id());
  header.set_directions(2);
  ASSERT_OK_AND_ASSIGN(const auto sums, client.ApplyTranspose(header, BytesOf(cotangents)));
  const std::vector<Vec3d> gradients = VectorsOf(sums.gradients());
  ASSERT_EQ(gradients.size(), tangents.size());
  for (size_t d = 0; d < 2; ++d) {
    double left = 0, right = 0;
    for (size_t n = 0; n < world.size(); ++n) {
      left += Dot(moves.vectors[d * world.size() + n], cotangents[d * world.size() + n]);
    }
    for (size_t n = 0; n < 64; ++n) right += Dot(tangents[d * 64 + n], gradients[d * 64 + n]);
    EXPECT_NEAR(left, right, 1e-12);
    EXPECT_NE(left, 0);
  }
  // Against the definition: a move of all control points by the first tangents.
  constexpr double kStep = 1e-6;
  v1::EditBatch batch = MoveOne("ann", 2, 0, {});
  auto& replace = *batch.mutable_edits(0)->mutable_replace_control_points();
  const v1::Lattice lattice = Lattice().lattice();
  for (int n = 0; n < 3 * 64; ++n) {
    replace.add_control_points(lattice.control_points(n) +
                               kStep * tangents[static_cast<size_t>(n / 3)][n % 3]);
  }
  ASSERT_OK(Apply(batch));
  const auto after = Evaluate(world);
  for (size_t n = 0; n < world.size(); ++n) {
    EXPECT_LE(Norm((after[n] - before.vectors[n]) / kStep - moves.vectors[n]), 1e-6) << n;
  }
}

TEST_F(OutsideSceneTest, AWatcherHasWhatANewOneGets) {
  for (const auto& lattice : {Falloff(0.4), Falloff(0.4, v1::OUTSIDE_CONTINUITY_C0), Linear()}) {
    ASSERT_OK(Create(RequestFor(lattice)));
    auto watch = For<v1::WatchRequest>();
    watch.mutable_view()->set_segments(4);
    watch.mutable_view()->set_encoding(v1::ENCODING_QUANTISED);
    watch.set_editor_id("ann");
    watch.set_max_unacked_updates(0);
    DeformClient watcher(*scenes_, watch);
    watcher.ReadUntilRevision(0);
    std::mt19937 random(kOutsideSeed);
    std::uniform_real_distribution<double> move(-0.05, 0.05);
    for (uint32_t n = 1; n <= 20; ++n) {
      const auto point = static_cast<uint32_t>(random() % 64);
      ASSERT_TRUE(
          watcher.Send(MoveOne("ann", n, point, {move(random), move(random), move(random)})));
      watcher.ReadUntilRevision(n);
    }
    auto request = For<v1::GetUpdateRequest>();
    *request.mutable_view() = watch.view();
    EventLog now;
    ASSERT_OK(Update(request, now));
    EXPECT_EQ(watcher.log.chunks.size(), now.chunks.size());
    EXPECT_TRUE(watcher.log.chunks == now.chunks) << "seed " << kOutsideSeed;
    ASSERT_OK(DeleteScene());
  }
}

TEST_F(OutsideSceneTest, ARestartKeepsIt) {
  ASSERT_OK(Create(RequestFor(Falloff(0.5, v1::OUTSIDE_CONTINUITY_C0))));
  ASSERT_OK(Apply(MoveFace(1, {0.05, 0, 0.2})));
  ASSERT_OK(Apply(Replace(2, Linear())));
  const v1::LatticeState linear = Lattice();
  EXPECT_EQ(linear.lattice().outside().mode(), v1::OUTSIDE_MODE_LINEAR);
  Restart();
  EXPECT_EQ(Lattice().SerializeAsString(), linear.SerializeAsString());
  ASSERT_OK(Apply(UndoMine("ann", 3)));
  const v1::LatticeState falloff = Lattice();
  EXPECT_EQ(falloff.lattice().outside().continuity(), v1::OUTSIDE_CONTINUITY_C0);
  EXPECT_EQ(falloff.lattice().outside().steps_size(), 6);
  const std::string ply = Ply();
  Restart();
  EXPECT_EQ(Lattice().SerializeAsString(), falloff.SerializeAsString());
  EXPECT_EQ(Ply(), ply);
}

}  // namespace
}  // namespace latticed::testing
