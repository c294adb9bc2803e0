// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Point sets of scenes with vertex weights, through the stub.
#include <cmath>
#include <cstring>
#include <random>

#include "tests/server/points/point_set_client.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kWeightedSetSeed = 62;
constexpr int kSurfacePoints = 40;

class WeightedPointSets : public SceneFixture {
 protected:
  void SetUp() override {
    SceneFixture::SetUp();
    mesh_ = Upload(kGridObj);
    v1::CreateSceneRequest request = SceneRequest();
    // kGridObj has 3 x 3 vertices on [0,2]^2: those at x = 0 rest, those at x = 2 follow.
    const std::vector<float> weights = {0, 0.5f, 1, 0, 0.5f, 1, 0, 0.5f, 1};
    request.mutable_weights()->set_values(
        std::string(reinterpret_cast<const char*>(weights.data()), weights.size() * sizeof(float)));
    ASSERT_OK(Create(request));
    client_ = std::make_unique<PointSetClient>(server_->channel());
  }
  void MoveSome() {
    for (uint32_t i = 0; i < 64; ++i) {
      ASSERT_OK(Apply(Move("ann", i + 1, i, 0.1 * uniform_(random_))));
    }
  }
  // Points of the second face, as point sets and as EvaluatePoints take them.
  absl::StatusOr<v1::PointSet> CreateOnSurface(v1::EvaluatePointsRequest& request) {
    request = For<v1::EvaluatePointsRequest>();
    std::string data;
    for (int i = 0; i < kSurfacePoints; ++i) {
      const double a = 0.5 + 0.5 * uniform_(random_), b = (1 - a) * 0.5 * (1 + uniform_(random_));
      const double barycentrics[3] = {a, b, 1 - a - b};
      const uint32_t integers[4] = {1, 4, 5, 6};
      auto* point = request.mutable_surface_points()->add_points();
      point->set_face(1);
      point->mutable_corners()->Add(integers + 1, integers + 4);
      point->mutable_barycentrics()->Add(barycentrics, barycentrics + 3);
      data.append(reinterpret_cast<const char*>(integers), sizeof(integers));
      data.append(reinterpret_cast<const char*>(barycentrics), sizeof(barycentrics));
    }
    auto header = For<v1::PointSetHeader>();
    header.mutable_surface()->set_points(kSurfacePoints);
    return client_->Create(header, data);
  }
  void ExpectAsEvaluated(const v1::EvaluatePointsRequest& request, const v1::PointSet& set) {
    v1::EvaluatePointsResponse expected;
    ASSERT_OK(Call(&Scenes::EvaluatePoints, request, &expected));
    ASSERT_OK_AND_ASSIGN(const auto values, client_->Deform(set, true));
    ASSERT_EQ(values.vectors.size(), 2u * kSurfacePoints);
    for (int i = 0; i < kSurfacePoints; ++i) {
      for (int c = 0; c < 3; ++c) {
        const auto n = static_cast<size_t>(i);
        ASSERT_NEAR(values.vectors[n][c], expected.positions(3 * i + c), 1e-13) << i;
        ASSERT_NEAR(values.vectors[kSurfacePoints + n][c], expected.normals(3 * i + c), 1e-12) << i;
      }
    }
  }
  std::vector<Vec3d> Random(size_t count) {
    std::vector<Vec3d> vectors(count);
    for (Vec3d& v : vectors) v = {uniform_(random_), uniform_(random_), uniform_(random_)};
    return vectors;
  }

  std::mt19937 random_{kWeightedSetSeed};
  std::uniform_real_distribution<double> uniform_{-1, 1};
  std::unique_ptr<PointSetClient> client_;
};

TEST_F(WeightedPointSets, SurfacePointsAreThoseThatAreEvaluated) {
  SCOPED_TRACE(kWeightedSetSeed);
  v1::EvaluatePointsRequest request;
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, CreateOnSurface(request));
  MoveSome();
  ExpectAsEvaluated(request, set);
  // Sorted again, they keep their weights.
  ASSERT_OK(Apply(Knot("bob", 1)));
  ExpectAsEvaluated(request, set);
}

TEST_F(WeightedPointSets, AViewsPointsGoAsFarAsTheirWeights) {
  v1::EditBatch lift = Move("ann", 1, 0, 0);
  auto* all = lift.mutable_edits(0)->mutable_move_control_points();
  all->clear_indices();
  for (uint32_t i = 0; i < 64; ++i) all->add_indices(i);
  all->mutable_offset()->set_z(3);
  ASSERT_OK(Apply(lift));
  auto header = For<v1::PointSetHeader>();
  header.mutable_view()->set_segments(4);
  header.mutable_view()->set_normals(v1::NORMAL_MODE_FACET);

  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client_->Create(header, ""));
  ASSERT_OK_AND_ASSIGN(const auto values, client_->Deform(set, true));

  EXPECT_EQ(set.points(), Get().patches() * 15);
  EXPECT_GE(set.bytes(), set.points() * 84);
  for (size_t i = 0; i < set.points(); ++i) {
    const Vec3d p = values.vectors[i], n = values.vectors[set.points() + i];
    ASSERT_NEAR(p.z, 1.5 * p.x, 1e-12) << i;
    ASSERT_NEAR(n.x, -1.5 / std::sqrt(3.25), 1e-12) << i;
    ASSERT_NEAR(n.z, 1 / std::sqrt(3.25), 1e-12) << i;
  }
}

TEST_F(WeightedPointSets, ForwardAndReverseModeAreAdjoint) {
  SCOPED_TRACE(kWeightedSetSeed);
  MoveSome();
  v1::EvaluatePointsRequest request;
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, CreateOnSurface(request));
  const std::vector<Vec3d> tangents = Random(64), cotangents = Random(2 * kSurfacePoints);
  auto forward = For<v1::ApplyJacobianRequest>();
  forward.set_point_set(set.id());
  forward.set_with_normals(true);
  forward.set_tangents(BytesOf(tangents));
  auto header = For<v1::CotangentHeader>();
  header.set_point_set(set.id());
  header.set_with_normals(true);

  ASSERT_OK_AND_ASSIGN(const auto moved, client_->ApplyJacobian(forward));
  ASSERT_OK_AND_ASSIGN(const auto reverse, client_->ApplyTranspose(header, BytesOf(cotangents)));

  const std::vector<Vec3d> gradients = VectorsOf(reverse.gradients());
  double by_points = 0, by_control_points = 0, size = 0;
  for (size_t i = 0; i < cotangents.size(); ++i) {
    by_points += Dot(moved.vectors[i], cotangents[i]);
    size += Norm(moved.vectors[i]) * Norm(cotangents[i]);
  }
  for (size_t i = 0; i < tangents.size(); ++i) by_control_points += Dot(gradients[i], tangents[i]);
  EXPECT_GT(size, 1);
  EXPECT_NEAR(by_points, by_control_points, 1e-12 * size);
}

TEST_F(WeightedPointSets, PointsOfTheWorldFollowTheLattice) {
  MoveSome();
  const std::vector<Vec3d> world = {{0.5, 0.5, 0}, {0, 1.5, 0}};
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client_->CreateWorld(world));
  ASSERT_OK_AND_ASSIGN(const auto values, client_->Deform(set));

  auto request = For<v1::EvaluatePointsRequest>();
  for (const Vec3d p : world) {
    for (int c = 0; c < 3; ++c) request.mutable_world_points()->add_positions(p[c]);
  }
  v1::EvaluatePointsResponse expected;
  ASSERT_OK(Call(&Scenes::EvaluatePoints, request, &expected));
  for (int i = 0; i < 2; ++i) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(values.vectors[static_cast<size_t>(i)][c], expected.positions(3 * i + c), 1e-13);
    }
  }
  EXPECT_GT(Norm(values.vectors[1] - world[1]), 1e-3) << "the surface rests at x = 0";
}

}  // namespace
}  // namespace latticed::testing
