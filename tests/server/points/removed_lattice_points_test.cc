// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Point sets of scenes whose lattice 0 was removed, through the stub.
#include <vector>

#include "tests/server/lattices/removed_fixture.h"
#include "tests/server/points/point_set_client.h"

namespace latticed::testing {
namespace {

using RemovedLatticePoints = RemovedLatticesTest;

TEST_F(RemovedLatticePoints, GoOnWithTheOthers) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole()), Shaken(Whole({1, 1, 1}))})));
  PointSetClient client(server_->channel());
  const std::vector<Vec3d> world = SomePoints(20);
  ASSERT_OK_AND_ASSIGN(const v1::PointSet before, client.CreateWorld(world));
  ASSERT_OK(Apply(Remove(0)));
  ASSERT_OK_AND_ASSIGN(const v1::PointSet after, client.CreateWorld(world));
  const std::vector<Vec3d> expected = Evaluate(world);

  for (const v1::PointSet& set : {before, after}) {
    ASSERT_OK_AND_ASSIGN(const auto values, client.Deform(set));
    ASSERT_EQ(values.vectors.size(), world.size());
    for (size_t i = 0; i < world.size(); ++i) {
      EXPECT_LE(Norm(values.vectors[i] - expected[i]), 1e-13) << "seed " << kSeed;
    }
  }
}

TEST_F(RemovedLatticePoints, DerivativesAreByALatticeThatIsLeft) {
  ASSERT_OK(Create(RequestOf({Whole(), Shaken(Whole({1, 1, 1}))})));
  ASSERT_OK(Apply(Remove(0)));
  PointSetClient client(server_->channel());
  const std::vector<Vec3d> world = SomePoints(5);
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client.CreateWorld(world));
  auto jacobian = For<v1::ApplyJacobianRequest>();
  jacobian.set_point_set(set.id());
  jacobian.set_tangents(BytesOf(std::vector<Vec3d>(64, Vec3d{1, 0, 0})));
  auto transpose = For<v1::CotangentHeader>();
  transpose.set_point_set(set.id());
  const std::string cotangents = BytesOf(std::vector<Vec3d>(world.size(), Vec3d{1, 0, 0}));

  ExpectRefused(client.ApplyJacobian(jacobian).status(), absl::StatusCode::kInvalidArgument,
                "OUT_OF_RANGE", "lattice");
  ExpectRefused(client.ApplyTranspose(transpose, cotangents).status(),
                absl::StatusCode::kInvalidArgument, "OUT_OF_RANGE", "header.lattice");
  jacobian.set_lattice(1);
  transpose.set_lattice(1);
  ASSERT_OK_AND_ASSIGN(const auto moves, client.ApplyJacobian(jacobian));
  for (const Vec3d move : moves.vectors) EXPECT_LE(Norm(move - Vec3d{1, 0, 0}), 1e-13);
  ASSERT_OK_AND_ASSIGN(const v1::PointGradients gradients,
                       client.ApplyTranspose(transpose, cotangents));
  Vec3d sum{};
  for (const Vec3d gradient : VectorsOf(gradients.gradients())) sum += gradient;
  EXPECT_LE(Norm(sum - Vec3d{5, 0, 0}), 1e-13);
}

}  // namespace
}  // namespace latticed::testing
