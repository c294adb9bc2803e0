// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes with vertex weights whose lattices are turned against each other, through the stub: both come and go in any order, and
// what follows the surface is of both.
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "tests/server/lattices/removed_fixture.h"
#include "tests/server/points/point_set_client.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

// Of the unit cube.
const std::vector<float> kCubeWeights = {1, 0.5f, 1, 0.75f, 0, 1, 0.25f, 1};

class WeightedTurnedTest : public RemovedLatticesTest {
 protected:
  static constexpr char kOther[] = "other-scene";

  static std::string BytesOfWeights(const std::vector<float>& weights) {
    return {reinterpret_cast<const char*>(weights.data()), weights.size() * sizeof(float)};
  }
  v1::CreateSceneRequest WeightedRequest(const std::vector<v1::Lattice>& lattices,
                                         const std::string& id = kScene) const {
    v1::CreateSceneRequest request = RequestOf(lattices, id);
    request.mutable_weights()->set_values(BytesOfWeights(kCubeWeights));
    return request;
  }
  v1::EditBatch Paint(const std::vector<float>& weights = kCubeWeights) {
    v1::EditBatch batch = Batch(0);
    batch.add_edits()->mutable_set_weights()->set_values(BytesOfWeights(weights));
    return batch;
  }
  // On all faces.
  static std::vector<v1::SurfacePoint> PointsOfFaces() {
    std::vector<v1::SurfacePoint> points;
    for (int n = 0; n < 60; ++n) {
      v1::SurfacePoint& point = points.emplace_back();
      const auto face = static_cast<uint32_t>(n % 6);
      const double along = (n + 0.5) / 60;
      point.set_face(face);
      for (uint32_t c = 0; c < 3; ++c) point.add_corners(4 * face + c);
      for (const double b : {0.6 * along, 0.4 * along, 1 - along}) point.add_barycentrics(b);
    }
    return points;
  }
  v1::EvaluatePointsResponse At(const std::vector<v1::SurfacePoint>& points,
                                const std::string& scene = kScene) {
    auto request = For<v1::EvaluatePointsRequest>(scene);
    for (const auto& point : points) *request.mutable_surface_points()->add_points() = point;
    v1::EvaluatePointsResponse response;
    EXPECT_OK(Call(&Scenes::EvaluatePoints, request, &response));
    return response;
  }
  // Positions, Jacobians and normals of the points above.
  std::string Surface(const std::string& scene = kScene) {
    v1::EvaluatePointsResponse at = At(PointsOfFaces(), scene);
    at.clear_revision();
    return at.SerializeAsString();
  }
  v1::MeasureSceneResponse Measured(uint32_t lattice = 0) {
    auto request = For<v1::MeasureSceneRequest>();
    for (const auto measure :
         {v1::MEASURE_VOLUME, v1::MEASURE_AREA, v1::MEASURE_CENTROID, v1::MEASURE_BOUNDS}) {
      request.add_measures(measure);
    }
    request.set_area_tolerance(1e-10);
    request.set_with_gradient(true);
    request.set_lattice(lattice);
    v1::MeasureSceneResponse response;
    EXPECT_OK(Call(&Scenes::MeasureScene, request, &response));
    return response;
  }
};

TEST_F(WeightedTurnedTest, WeightsComeToTurnedLatticesAndGo) {
  const v1::Lattice one = Shaken(Whole()), turned = Shaken(TurnedSpot({1, 2, 3}));
  ASSERT_OK(Create(RequestOf({one, turned})));
  ASSERT_OK(Create(WeightedRequest({one, turned}, kOther)));
  const std::string plain = Surface();
  EXPECT_NE(plain, Surface(kOther));
  ASSERT_OK(Apply(Paint()));
  EXPECT_TRUE(Get().weighted());
  EXPECT_EQ(Surface(), Surface(kOther));
  EXPECT_TRUE(Chunks() == Chunks(kOther));
  Restart();
  EXPECT_EQ(Surface(), Surface(kOther));
  ASSERT_OK(Apply(Undo(0)));
  EXPECT_EQ(Surface(), plain);
  ASSERT_OK(Apply(Redo(0)));
  EXPECT_EQ(Surface(), Surface(kOther));
}

TEST_F(WeightedTurnedTest, ATurnedLatticeComesToWeightsAndGoes) {
  const v1::Lattice one = Shaken(Whole()), turned = Shaken(TurnedSpot());
  ASSERT_OK(Create(WeightedRequest({one})));
  ASSERT_OK(Create(WeightedRequest({one, turned}, kOther)));
  const std::string alone = Surface();
  ASSERT_OK(Apply(Put(1, turned)));
  EXPECT_EQ(Get().pipeline(), v1::PIPELINE_GEMM);
  EXPECT_EQ(Surface(), Surface(kOther));
  ASSERT_OK(Apply(Remove(1)));
  EXPECT_EQ(Get().pipeline(), v1::PIPELINE_FUSED);
  EXPECT_EQ(Surface(), alone);
  ASSERT_OK(Apply(Undo(1)));
  EXPECT_EQ(Surface(), Surface(kOther));
  Restart();
  EXPECT_EQ(Surface(), Surface(kOther));
  // The first of them may go, too.
  ASSERT_OK(Apply(Remove(0)));
  EXPECT_TRUE(Get().weighted());
  EXPECT_NE(Surface(), Surface(kOther));
}

// A vertex of weight 0 rests, one of weight 1 follows all lattices, one between goes a part of the way.
TEST_F(WeightedTurnedTest, AVertexGoesThePartOfTheWayThatItsWeightSays) {
  ASSERT_OK(Create(WeightedRequest({Shaken(Whole()), Shaken(TurnedSpot())})));
  const std::vector<std::vector<uint32_t>> faces = {{3, 2, 1, 0}, {4, 5, 6, 7}};
  const std::vector<Vec3d> vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                       {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  const std::vector<Vec3d> followed = Evaluate(vertices);
  for (uint32_t face = 0; face < 2; ++face) {
    for (uint32_t c = 0; c < 3; ++c) {
      v1::SurfacePoint point;
      point.set_face(face);
      for (uint32_t k = 0; k < 3; ++k) {
        point.add_corners(4 * face + k);
        point.add_barycentrics(k == c ? 1 : 0);
      }
      const auto at = At({point});
      const size_t v = faces[face][c];
      const Vec3d want =
          vertices[v] + static_cast<double>(kCubeWeights[v]) * (followed[v] - vertices[v]);
      for (int a = 0; a < 3; ++a) EXPECT_NEAR(at.positions(a), want[a], 1e-13) << v;
    }
  }
}

TEST_F(WeightedTurnedTest, GradientsOfMeasuresAreTheDifferencesOfEdits) {
  constexpr double kStep = 1e-4;
  ASSERT_OK(Create(WeightedRequest({Shaken(Whole()), Shaken(TurnedSpot({3, 2, 1}))})));
  for (const uint32_t lattice : {0u, 1u}) {
    const Vec3d direction{0.3, -0.8, 0.5};
    const v1::MeasureSceneResponse here = Measured(lattice);
    const auto along = [&](const auto& gradient) {
      return direction.x * gradient[66] + direction.y * gradient[67] + direction.z * gradient[68];
    };
    ASSERT_OK(Apply(Push(lattice, 22, kStep * direction)));
    const v1::MeasureSceneResponse after = Measured();
    ASSERT_OK(Apply(Push(lattice, 22, -2 * kStep * direction)));
    const v1::MeasureSceneResponse before = Measured();

    const double volume = (after.volume() - before.volume()) / (2 * kStep);
    const double area = (after.area() - before.area()) / (2 * kStep);
    EXPECT_NEAR(along(here.volume_gradient()), volume, 1e-6) << lattice;
    EXPECT_NEAR(along(here.area_gradient()), area, 1e-5) << lattice;
    EXPECT_GT(std::abs(volume), 1e-4) << lattice;
  }
}

TEST_F(WeightedTurnedTest, BoundsHoldPointsOfTheSurface) {
  ASSERT_OK(Create(WeightedRequest({Shaken(Whole()), Shaken(TurnedSpot())})));
  const v1::MeasureSceneResponse got = Measured();
  const auto at = At(PointsOfFaces());
  for (int i = 0; i + 2 < at.positions_size(); i += 3) {
    EXPECT_GE(at.positions(i), got.least().x() - 1e-8);
    EXPECT_LE(at.positions(i), got.greatest().x() + 1e-8);
    EXPECT_GE(at.positions(i + 2), got.least().z() - 1e-8);
    EXPECT_LE(at.positions(i + 2), got.greatest().z() + 1e-8);
  }
}

TEST_F(WeightedTurnedTest, PaintingAndMovesKeepAVolume) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole()), Shaken(TurnedSpot())})));
  for (const uint32_t lattice : {0u, 1u}) {
    v1::EditBatch keep = Batch(lattice);
    keep.add_edits()->mutable_set_constraints()->mutable_constraints()->mutable_volume();
    ASSERT_OK(Apply(keep));
  }
  const std::string turned = LatticeAt(1).lattice().SerializeAsString();
  ASSERT_OK(Apply(Paint()));
  EXPECT_NEAR(Measured().volume(), 1, 1e-12);
  EXPECT_EQ(LatticeAt(1).lattice().SerializeAsString(), turned);
  for (const uint32_t lattice : {1u, 0u}) {
    ASSERT_OK(Apply(Push(lattice, 21, {0.1, 0.05, -0.2})));
    EXPECT_NEAR(Measured().volume(), 1, 1e-12) << lattice;
  }
  ASSERT_OK(Apply(Undo(1)));
  const std::string before = Surface();
  ASSERT_OK(Apply(Paint({0, 1, 0, 1, 1, 0.5f, 1, 0})));
  EXPECT_NEAR(Measured().volume(), 1, 1e-12);
  Restart();
  EXPECT_NEAR(Measured().volume(), 1, 1e-12);
  ASSERT_OK(Apply(Undo(0)));
  EXPECT_EQ(Surface(), before);
}

TEST_F(WeightedTurnedTest, APickFindsWhatEvaluatePointsHas) {
  ASSERT_OK(Create(WeightedRequest({Shaken(Whole()), Shaken(TurnedSpot())})));
  for (const Vec3d target : {Vec3d{0.5, 0.5, 0}, {0.45, 0.4, 0}, {0.8, 0.7, 0}, {0.2, 0.8, 1}}) {
    const Vec3d origin{0.4, 0.3, -7}, direction = target - origin;
    auto request = For<v1::PickRequest>();
    *request.mutable_ray()->mutable_origin() = ToVec3(origin);
    *request.mutable_ray()->mutable_direction() = ToVec3(direction);
    v1::SurfacePoint point;
    ASSERT_OK(Call(&Scenes::Pick, request, &point));
    const v1::EvaluatePointsResponse at = At({point});
    const Vec3d d = Vec3d{at.positions(0), at.positions(1), at.positions(2)} - origin;
    EXPECT_LE(Norm(Cross(d, direction)), 1e-9 * Norm(d) * Norm(direction));
  }
}

TEST_F(WeightedTurnedTest, ADragOfEitherLatticeTakesThePointToItsTarget) {
  ASSERT_OK(Create(WeightedRequest({Shaken(Whole()), Shaken(TurnedSpot())})));
  v1::SurfacePoint point;  // of the lower face, in both lattices
  point.set_face(0);
  for (uint32_t c = 0; c < 3; ++c) point.add_corners(c);
  for (const double b : {0.3, 0.2, 0.5}) point.add_barycentrics(b);
  for (const uint32_t lattice : {0u, 1u}) {
    const Vec3d target = Vec3d{0.5, 0.5, -0.1 * (1 + lattice)};
    v1::EditBatch batch = Batch(lattice);
    auto& drag = *batch.add_edits()->mutable_drag_points();
    *drag.add_points() = point;
    for (int a = 0; a < 3; ++a) drag.add_targets(target[a]);
    ASSERT_OK(Apply(batch));
    const v1::EvaluatePointsResponse at = At({point});
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(at.positions(a), target[a], 1e-12) << lattice;
  }
}

TEST_F(WeightedTurnedTest, FoldsAreThoseOfTheWeightedSum) {
  v1::CreateSceneRequest request = WeightedRequest({Whole(), TurnedSpot()});
  request.set_fold_watch(true);
  ASSERT_OK(Create(request));
  const auto certify = [&] {
    v1::FoldReport report;
    EXPECT_OK(Call(&Scenes::CertifyFolds, For<v1::CertifyFoldsRequest>(), &report));
    return report;
  };
  EXPECT_TRUE(certify().certified());
  for (const uint32_t lattice : {0u, 1u}) {
    v1::EditResult result;
    v1::EditBatch refused = Push(lattice, 21, {4, 1, 0});
    refused.set_refuse_folds(true);
    ExpectRefused(Apply(refused), Code::kFailedPrecondition, "FOLD");
    ASSERT_OK(Apply(Push(lattice, 21, {4, 1, 0}), &result));
    EXPECT_GT(result.folds().folded(), 0u);
    EXPECT_EQ(result.folds().SerializeAsString(), certify().SerializeAsString());
    ASSERT_OK(Apply(Undo(lattice), &result));
    EXPECT_TRUE(result.folds().certified());
  }
}

std::string RecordsOf(const std::vector<v1::SurfacePoint>& points) {
  std::string records;
  for (const v1::SurfacePoint& point : points) {
    std::string record(40, '\0');
    const uint32_t face = point.face();
    std::memcpy(record.data(), &face, 4);
    std::memcpy(record.data() + 4, point.corners().data(), 12);
    std::memcpy(record.data() + 16, point.barycentrics().data(), 24);
    records += record;
  }
  return records;
}

TEST_F(WeightedTurnedTest, PointsOfTheSurfaceFollowTheWeightedSum) {
  ASSERT_OK(Create(WeightedRequest({Shaken(Whole()), Shaken(TurnedSpot({3, 2, 1}))})));
  PointSetClient client(server_->channel());
  auto header = For<v1::PointSetHeader>();
  const std::vector<v1::SurfacePoint> points = PointsOfFaces();
  const auto count = points.size();
  header.mutable_surface()->set_points(static_cast<uint32_t>(count));
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client.Create(header, RecordsOf(points)));
  const auto compare = [&] {
    const auto got = client.Deform(set, true);
    ASSERT_OK(got);
    const v1::EvaluatePointsResponse want = At(points);
    for (size_t i = 0; i < count; ++i) {
      for (int a = 0; a < 3; ++a) {
        const int n = 3 * static_cast<int>(i) + a;
        EXPECT_NEAR(got->vectors[i][a], want.positions(n), 1e-13) << i;
        EXPECT_NEAR(got->vectors[count + i][a], want.normals(n), 1e-11) << i;
      }
    }
  };
  compare();
  ASSERT_OK(Apply(Push(1, 22, {0.1, 0.03, -0.04})));
  compare();
  ASSERT_OK(Apply(Push(0, 22, {0, 0.03, -0.04})));
  compare();
}

}  // namespace
}  // namespace latticed::testing
