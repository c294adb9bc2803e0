// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Point sets of scenes whose lattices are turned against each other, through the stub: against EvaluatePoints, differences of
// edits, and forward against reverse mode.
#include <cmath>
#include <cstring>
#include <vector>

#include "tests/server/lattices/removed_fixture.h"
#include "tests/server/points/point_set_client.h"

namespace latticed::testing {
namespace {

class TurnedPointsTest : public RemovedLatticesTest {
 protected:
  void SetUp() override {
    RemovedLatticesTest::SetUp();
    client_ = std::make_unique<PointSetClient>(server_->channel());
  }
  // Some points are beyond the frame of Whole(), too.
  std::vector<Vec3d> World(int count) {
    std::vector<Vec3d> world = SomePoints(count);
    for (Vec3d& p : world) p = 1.4 * p - Vec3d{0.2, 0.2, 0.2};
    return world;
  }
  std::vector<Vec3d> Deformed(const v1::PointSet& set, bool with_normals = false) {
    const auto values = client_->Deform(set, with_normals);
    EXPECT_OK(values);
    return values.ok() ? values->vectors : std::vector<Vec3d>();
  }
  void ExpectDefinition(const v1::PointSet& set, const std::vector<Vec3d>& world) {
    const std::vector<Vec3d> expected = Evaluate(world), got = Deformed(set);
    ASSERT_EQ(got.size(), world.size());
    for (size_t i = 0; i < world.size(); ++i) {
      ASSERT_LE(Norm(got[i] - expected[i]), 1e-13) << i << ", seed " << kSeed;
    }
  }
  v1::ApplyJacobianRequest Forward(const v1::PointSet& set, uint32_t lattice,
                                   const std::vector<Vec3d>& tangents) const {
    auto request = For<v1::ApplyJacobianRequest>();
    request.set_point_set(set.id());
    request.set_with_normals(set.has_normals());
    request.set_lattice(lattice);
    request.set_tangents(BytesOf(tangents));
    return request;
  }

  std::unique_ptr<PointSetClient> client_;
};

double Product(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  EXPECT_EQ(a.size(), b.size());
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += Dot(a[i], b[i]);
  return sum;
}

TEST_F(TurnedPointsTest, TheyFollowEditsOfBothLattices) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole()), Shaken(TurnedSpot({1, 2, 3}))})));
  const std::vector<Vec3d> world = World(3'000);
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client_->CreateWorld(world));
  ExpectDefinition(set, world);
  const std::vector<Vec3d> before = Deformed(set);
  ASSERT_OK(Apply(Push(0, 21, {0.05, 0.02, 0})));
  ExpectDefinition(set, world);
  const std::vector<Vec3d> between = Deformed(set);
  ASSERT_OK(Apply(Push(1, 22, {0, 0.03, -0.04})));
  ExpectDefinition(set, world);
  EXPECT_NE(between, before);
  EXPECT_NE(Deformed(set), between);
}

TEST_F(TurnedPointsTest, LatticesComeAndGoBetweenCalls) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole())})));
  const std::vector<Vec3d> world = World(2'000);
  ASSERT_OK_AND_ASSIGN(const v1::PointSet before, client_->CreateWorld(world, world));
  ExpectDefinition(before, world);
  const std::vector<Vec3d> alone = Deformed(before, true);

  ASSERT_OK(Apply(Put(1, Shaken(TurnedSpot()))));
  ASSERT_OK_AND_ASSIGN(const v1::PointSet during, client_->CreateWorld(world, world));
  ExpectDefinition(before, world);
  EXPECT_EQ(Deformed(before, true), Deformed(during, true));
  EXPECT_GE(during.bytes(), before.bytes() + 28 * world.size()) << "sorted for each lattice";
  ASSERT_OK_AND_ASSIGN(const v1::ListPointSetsResponse listed, client_->List());
  EXPECT_EQ(listed.point_sets(0).bytes(), during.bytes());
  EXPECT_EQ(Get().bytes().at("point_sets"), 2 * during.bytes());
  EXPECT_LE(during.points_outside(), before.points_outside());
  EXPECT_GT(during.points_outside(), 0u);

  ASSERT_OK(Apply(Remove(1)));
  EXPECT_EQ(Deformed(before, true), alone);
  EXPECT_EQ(Deformed(during, true), alone);
  EXPECT_EQ(Get().bytes().at("point_sets"), 2 * before.bytes());
  // The turned one may also be the one that is left.
  ASSERT_OK(Apply(Undo(1)));
  ASSERT_OK(Apply(Remove(0)));
  ExpectDefinition(before, world);
}

TEST_F(TurnedPointsTest, OnlyPointsThatNoLatticeReachesAreOutside) {
  ASSERT_OK(Create(RequestOf({Whole()})));
  // The second one is in TurnedSpot alone.
  const std::vector<Vec3d> world{{0.5, 0.5, 0.5}, {0.5, 0.3, -0.15}, {5, 5, 5}};
  v1::Lattice spot = TurnedSpot();
  spot.mutable_frame()->mutable_origin()->set_z(-0.2);
  spot.mutable_outside()->set_widths(4, 0);
  ASSERT_OK_AND_ASSIGN(const v1::PointSet before, client_->CreateWorld(world));
  EXPECT_EQ(before.points_outside(), 2u);
  ASSERT_OK(Apply(Put(1, spot)));
  ASSERT_OK_AND_ASSIGN(const v1::PointSet after, client_->CreateWorld(world));
  EXPECT_EQ(after.points_outside(), 1u);
}

TEST_F(TurnedPointsTest, SurfacePointsHaveTheNormalsOfTheSurface) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole()), Shaken(TurnedSpot())})));
  constexpr int kPoints = 60;
  auto request = For<v1::EvaluatePointsRequest>();
  std::string records;
  for (int n = 0; n < kPoints; ++n) {
    auto* point = request.mutable_surface_points()->add_points();
    const auto face = static_cast<uint32_t>(n % 6);
    const uint32_t integers[4] = {face, 4 * face, 4 * face + 1, 4 * face + 2};
    const double along = (n + 0.5) / kPoints, rest = 1 - along;
    const double barycentrics[3] = {0.6 * along, 0.4 * along, rest};
    point->set_face(face);
    for (int c = 0; c < 3; ++c) {
      point->add_corners(integers[c + 1]);
      point->add_barycentrics(barycentrics[c]);
    }
    std::string record(40, '\0');
    std::memcpy(record.data(), integers, 16);
    std::memcpy(record.data() + 16, barycentrics, 24);
    records += record;
  }
  auto header = For<v1::PointSetHeader>();
  header.mutable_surface()->set_points(kPoints);
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client_->Create(header, records));
  v1::EvaluatePointsResponse expected;
  ASSERT_OK(Call(&Scenes::EvaluatePoints, request, &expected));

  const std::vector<Vec3d> got = Deformed(set, true);

  ASSERT_EQ(got.size(), 2u * kPoints);
  for (int i = 0; i < kPoints; ++i) {
    for (int a = 0; a < 3; ++a) {
      const auto n = static_cast<size_t>(i);
      EXPECT_NEAR(got[n][a], expected.positions(3 * i + a), 1e-13) << i << ", seed " << kSeed;
      EXPECT_NEAR(got[kPoints + n][a], expected.normals(3 * i + a), 1e-11)
          << i << ", seed " << kSeed;
    }
  }
}

TEST_F(TurnedPointsTest, JacobiansAreTheDifferencesOfEdits) {
  constexpr double kStep = 1e-5;
  ASSERT_OK(Create(RequestOf({Shaken(Whole()), Shaken(TurnedSpot({3, 2, 1}))})));
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set,
                       client_->CreateWorld(World(500), std::vector<Vec3d>(500, {1, 2, 3})));
  for (const uint32_t lattice : {0u, 1u}) {
    const Vec3d direction{0.3, -0.8, 0.5};
    std::vector<Vec3d> tangent(64);
    tangent[22] = direction;
    ASSERT_OK_AND_ASSIGN(const auto moved, client_->ApplyJacobian(Forward(set, lattice, tangent)));
    ASSERT_OK(Apply(Push(lattice, 22, kStep * direction)));
    const std::vector<Vec3d> after = Deformed(set, true);
    ASSERT_OK(Apply(Push(lattice, 22, -2 * kStep * direction)));
    const std::vector<Vec3d> before = Deformed(set, true);

    ASSERT_EQ(moved.vectors.size(), 1'000u);
    double most = 0;
    for (size_t i = 0; i < moved.vectors.size(); ++i) {
      const Vec3d difference = (after[i] - before[i]) / (2 * kStep);
      const bool is_normal = i >= 500;
      // The second difference of a normal grows with its condition.
      const double tolerance = is_normal ? 1e-5 * (1 + std::pow(Norm(moved.vectors[i]), 3)) : 1e-9;
      ASSERT_LE(Norm(moved.vectors[i] - difference), tolerance) << i << ", seed " << kSeed;
      most = std::max(most, Norm(difference));
    }
    EXPECT_GT(most, 0.05) << lattice;
  }
}

TEST_F(TurnedPointsTest, ForwardAndReverseModeAreAdjointForEachLattice) {
  constexpr size_t kPoints = 2'000, kDirections = 3;
  ASSERT_OK(Create(RequestOf({Shaken(TurnedSpot()), Shaken(Whole({1, 2, 3}))})));
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set,
                       client_->CreateWorld(World(kPoints), SomePoints(kPoints)));
  for (const uint32_t lattice : {0u, 1u}) {
    const std::vector<Vec3d> tangents = SomePoints(64 * kDirections);
    const std::vector<Vec3d> cotangents = SomePoints(2 * kPoints * kDirections);
    auto reverse = For<v1::CotangentHeader>();
    reverse.set_point_set(set.id());
    reverse.set_with_normals(true);
    reverse.set_directions(kDirections);
    reverse.set_lattice(lattice);

    ASSERT_OK_AND_ASSIGN(const auto moved, client_->ApplyJacobian(Forward(set, lattice, tangents)));
    ASSERT_OK_AND_ASSIGN(const auto answer, client_->ApplyTranspose(reverse, BytesOf(cotangents)));

    const std::vector<Vec3d> gradients = VectorsOf(answer.gradients());
    const double size =
        std::sqrt(Product(moved.vectors, moved.vectors) * Product(cotangents, cotangents));
    EXPECT_NEAR(Product(moved.vectors, cotangents), Product(gradients, tangents), 1e-12 * size)
        << lattice << ", seed " << kSeed;
  }
}

}  // namespace
}  // namespace latticed::testing
