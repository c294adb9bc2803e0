// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What point sets answer, against EvaluatePoints and against each other.
#include <cmath>
#include <cstring>
#include <random>

#include "tests/server/points/point_set_client.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kPointSetSeed = 26;

std::vector<Vec3d> RandomVectors(size_t count, double low, double high) {
  std::mt19937 random(kPointSetSeed);
  std::uniform_real_distribution<double> uniform(low, high);
  std::vector<Vec3d> vectors(count);
  for (Vec3d& v : vectors) v = {uniform(random), uniform(random), uniform(random)};
  return vectors;
}

double SumOfProducts(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  EXPECT_EQ(a.size(), b.size());
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += Dot(a[i], b[i]);
  return sum;
}

class PointSetTest : public OneSceneTest {
 protected:
  void SetUp() override {
    OneSceneTest::SetUp();
    client_ = std::make_unique<PointSetClient>(server_->channel());
    ASSERT_OK(Apply(Move("ann", 1, 21, 0.25)));
    ASSERT_OK(Apply(Move("ann", 2, 42, -0.125)));
  }
  v1::EvaluatePointsResponse Evaluate(const v1::EvaluatePointsRequest& request) {
    v1::EvaluatePointsResponse response;
    EXPECT_OK(Call(&Scenes::EvaluatePoints, request, &response));
    return response;
  }
  void ExpectPositions(const std::vector<Vec3d>& world, const PointSetClient::Values& values) {
    auto request = For<v1::EvaluatePointsRequest>();
    for (const Vec3d p : world) {
      for (int a = 0; a < 3; ++a) request.mutable_world_points()->add_positions(p[a]);
    }
    const auto expected = Evaluate(request);
    EXPECT_EQ(values.header.revision(), expected.revision());
    for (size_t i = 0; i < world.size(); ++i) {
      for (int a = 0; a < 3; ++a) {
        ASSERT_NEAR(values.vectors[i][a], expected.positions(static_cast<int>(3 * i) + a), 1e-14);
      }
    }
  }

  std::unique_ptr<PointSetClient> client_;
};

TEST_F(PointSetTest, WorldPointsAreDeformedAsByTheDefinition) {
  const std::vector<Vec3d> world = RandomVectors(2'000, -0.3, 2.3);
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client_->CreateWorld(world, {}, 8'000));
  EXPECT_EQ(set.scene(), kScene);
  EXPECT_EQ(set.points(), 2'000u);
  EXPECT_GT(set.points_outside(), 500u);
  EXPECT_LT(set.points_outside(), 2'000u);
  EXPECT_FALSE(set.has_normals());

  ASSERT_OK_AND_ASSIGN(const auto values, client_->Deform(set));

  EXPECT_EQ(values.header.structure_id(), 1u);
  EXPECT_EQ(values.header.points(), 2'000u);
  EXPECT_EQ(values.header.directions(), 1u);
  EXPECT_FALSE(values.header.with_normals());
  ASSERT_EQ(values.vectors.size(), 2'000u);
  ExpectPositions(world, values);
}

TEST_F(PointSetTest, SurfacePointsHaveTheNormalsOfTheSurface) {
  auto request = For<v1::EvaluatePointsRequest>();
  auto* point = request.mutable_surface_points()->add_points();
  point->set_face(1);
  for (const uint32_t corner : {4u, 5u, 6u}) point->add_corners(corner);
  for (const double b : {0.5, 0.25, 0.25}) point->add_barycentrics(b);
  std::string record(40, '\0');
  const uint32_t integers[4] = {1, 4, 5, 6};
  const double barycentrics[3] = {0.5, 0.25, 0.25};
  std::memcpy(record.data(), integers, 16);
  std::memcpy(record.data() + 16, barycentrics, 24);
  auto header = For<v1::PointSetHeader>();
  header.mutable_surface()->set_points(1);

  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client_->Create(header, record));
  ASSERT_OK_AND_ASSIGN(const auto values, client_->Deform(set, true));

  const auto expected = Evaluate(request);
  EXPECT_TRUE(set.has_normals());
  ASSERT_EQ(values.vectors.size(), 2u);
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(values.vectors[0][a], expected.positions(a), 1e-14);
    EXPECT_NEAR(values.vectors[1][a], expected.normals(a), 1e-14);
  }
}

TEST_F(PointSetTest, AViewsTessellationHasItsPointsPatchByPatch) {
  auto header = For<v1::PointSetHeader>();
  header.mutable_view()->set_segments(3);
  header.mutable_view()->set_normals(v1::NORMAL_MODE_FACET);
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client_->Create(header, ""));
  ASSERT_OK_AND_ASSIGN(const auto values, client_->Deform(set, true));

  auto request = For<v1::GetUpdateRequest>();
  request.mutable_view()->set_segments(3);
  request.mutable_view()->set_encoding(v1::ENCODING_RAW);
  request.mutable_view()->set_normals(v1::NORMAL_MODE_FACET);
  EventLog log;
  ASSERT_OK(Update(request, log));
  EXPECT_EQ(set.points(), Get().patches() * 10);
  ASSERT_EQ(values.vectors.size(), 2 * set.points());
  Bounds bounds;
  for (size_t i = 0; i < set.points(); ++i) {
    bounds.Extend(values.vectors[i]);
    EXPECT_NEAR(Norm(values.vectors[set.points() + i]), 1, 1e-12);
  }
  EXPECT_NEAR(bounds.min.x, 0, 0.1);
  EXPECT_NEAR(bounds.max.y, 2, 0.1);
}

TEST_F(PointSetTest, ForwardAndReverseModeAreAdjoint) {
  constexpr size_t kPoints = 5'000, kDirections = 3;
  const std::vector<Vec3d> world = RandomVectors(kPoints, 0, 2);
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client_->CreateWorld(world, world));
  const std::vector<Vec3d> tangents = RandomVectors(64 * kDirections, -1, 1);
  const std::vector<Vec3d> cotangents = RandomVectors(2 * kPoints * kDirections, -1, 1);
  auto forward = For<v1::ApplyJacobianRequest>();
  forward.set_point_set(set.id());
  forward.set_with_normals(true);
  forward.set_revision(2);
  forward.set_tangents(BytesOf(tangents));
  auto reverse = For<v1::CotangentHeader>();
  reverse.set_point_set(set.id());
  reverse.set_with_normals(true);
  reverse.set_directions(kDirections);

  ASSERT_OK_AND_ASSIGN(const auto moved, client_->ApplyJacobian(forward));
  ASSERT_OK_AND_ASSIGN(const auto answer,
                       client_->ApplyTranspose(reverse, BytesOf(cotangents), 80'000));

  EXPECT_EQ(answer.revision(), 2u);
  EXPECT_EQ(answer.structure_id(), 1u);
  EXPECT_EQ(answer.directions(), kDirections);
  EXPECT_EQ(moved.header.directions(), kDirections);
  const std::vector<Vec3d> gradients = VectorsOf(answer.gradients());
  ASSERT_EQ(gradients.size(), 64 * kDirections);
  const double size = std::sqrt(SumOfProducts(moved.vectors, moved.vectors) *
                                SumOfProducts(cotangents, cotangents));
  EXPECT_NEAR(SumOfProducts(moved.vectors, cotangents), SumOfProducts(gradients, tangents),
              1e-12 * size);
  ASSERT_OK_AND_ASSIGN(const auto again, client_->ApplyTranspose(reverse, BytesOf(cotangents)));
  EXPECT_EQ(again.gradients(), answer.gradients()) << "the same bits, however it is cut in parts";
}

TEST_F(PointSetTest, TangentsMayNameTheControlPointsThatMove) {
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client_->CreateWorld(RandomVectors(500, 0, 2)));
  std::vector<Vec3d> all(2 * 64);
  all[21] = {1, 2, 3};
  all[64 + 42] = {-1, 0, 5};
  auto dense = For<v1::ApplyJacobianRequest>();
  dense.set_point_set(set.id());
  dense.set_tangents(BytesOf(all));
  v1::ApplyJacobianRequest sparse = dense;
  sparse.add_indices(42);
  sparse.add_indices(21);
  sparse.set_tangents(BytesOf({{}, {1, 2, 3}, {-1, 0, 5}, {}}));

  ASSERT_OK_AND_ASSIGN(const auto expected, client_->ApplyJacobian(dense));
  ASSERT_OK_AND_ASSIGN(const auto got, client_->ApplyJacobian(sparse));

  EXPECT_EQ(got.vectors, expected.vectors);
  EXPECT_GT(SumOfProducts(got.vectors, got.vectors), 0);
}

TEST_F(PointSetTest, AnInsertedKnotSortsThePointsAgain) {
  const std::vector<Vec3d> world = RandomVectors(3'000, 0, 2);
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client_->CreateWorld(world));
  ASSERT_OK_AND_ASSIGN(const auto before, client_->Deform(set));
  ASSERT_OK(Apply(Knot("ann", 3)));

  ASSERT_OK_AND_ASSIGN(const auto after, client_->Deform(set));
  auto header = For<v1::CotangentHeader>();
  header.set_point_set(set.id());
  ASSERT_OK_AND_ASSIGN(const auto gradients, client_->ApplyTranspose(header, BytesOf(world)));

  EXPECT_EQ(after.header.structure_id(), 2u);
  EXPECT_EQ(gradients.structure_id(), 2u);
  EXPECT_EQ(gradients.gradients().size(),
            static_cast<size_t>(Lattice().lattice().control_points_size()) * 8);
  for (size_t i = 0; i < world.size(); ++i) {
    ASSERT_LE(Norm(after.vectors[i] - before.vectors[i]), 1e-14);
  }
}

TEST_F(PointSetTest, AMillionNumbersComeAndGoInParts) {
  const std::vector<Vec3d> world = RandomVectors(150'000, 0, 2);
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client_->CreateWorld(world, world));
  ASSERT_OK_AND_ASSIGN(const auto values, client_->Deform(set, true));
  EXPECT_EQ(values.vectors.size(), 300'000u);
  EXPECT_EQ(values.parts, 1 + (300'000u * 24 + 786'431) / 786'432);
}

}  // namespace
}  // namespace latticed::testing
