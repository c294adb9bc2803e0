// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points with weights: against the definition of core/ffd/weights, against differences, and forward against reverse mode.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "core/ffd/weights/vertex_weights.h"
#include "core/points/host_points.h"
#include "tests/core/points/point_fixture.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

constexpr uint32_t kWeightedPointsSeed = 61;
constexpr size_t kWeightedCount = 700;

// Points in and around a lattice. Some weights are 0 and some are 1.
struct WeightedPointSet {
  RandomVectors random{kWeightedPointsSeed};
  CpuArena arena{2};
  LatticeStructure structure;
  std::vector<Vec3d> control_points, world, normals;
  std::vector<PointWeight> weights;
  std::unique_ptr<SortedPoints> points;

  explicit WeightedPointSet(std::array<int, 3> degree)
      : structure(ObliqueStructure(degree, {2, 1, 3})),
        control_points(random.Jittered(structure, 0.2)),
        world(random.Around(structure, kWeightedCount)),
        normals(random.Units(kWeightedCount)),
        weights(kWeightedCount) {
    for (PointWeight& weight : weights) {
      weight = {std::clamp(1.5 * random.Next().x, 0.0, 1.0), random.Next(0.3)};
    }
    points = std::make_unique<SortedPoints>(structure, world, normals, arena, weights);
  }
  std::vector<Vec3d> Deformed(PointNormals with = PointNormals::kWanted) {
    std::vector<Vec3d> out(VectorsPerDirection(*points, with));
    EXPECT_OK(Deform(*points, control_points, with, arena, NeverStop, out));
    return out;
  }
  std::vector<Vec3d> Velocities(const std::vector<Vec3d>& tangent, PointNormals with) {
    std::vector<Vec3d> out(VectorsPerDirection(*points, with));
    EXPECT_OK(ApplyJacobian(*points, control_points, tangent, with, arena, NeverStop, out));
    return out;
  }
};

template <class Body>
void ForSomeDegrees(const Body& body) {
  for (const std::array<int, 3> degree : {std::array{1, 1, 1}, {2, 2, 2}, {1, 3, 2}, {3, 3, 3}}) {
    SCOPED_TRACE(::testing::Message() << "degree " << degree[0] << degree[1] << degree[2]
                                      << ", seed " << kWeightedPointsSeed);
    body(degree);
  }
}

TEST(WeightedPoints, DeformMatchesTheDefinition) {
  ForSomeDegrees([](std::array<int, 3> degree) {
    WeightedPointSet f(degree);

    const std::vector<Vec3d> out = f.Deformed();

    size_t outside = 0;
    for (size_t i = 0; i < kWeightedCount; ++i) {
      DeformedPoint expected = EvaluateWorld(f.structure, f.control_points, f.world[i]);
      if (!expected.inside) ++outside;
      Weigh(f.world[i], f.weights[i].weight, f.weights[i].gradient, expected.position,
            expected.jacobian);
      ASSERT_LE(Norm(out[i] - expected.position), 2e-14) << i;
      const CarriedNormal carried = CarryNormal(expected.jacobian.data(), f.normals[i]);
      if (!expected.inside || carried.kappa > 100) continue;
      ASSERT_LE(Norm(out[kWeightedCount + i] - carried.direction), 2e-12) << i;
    }
    EXPECT_EQ(outside, kWeightedCount / 8);
    EXPECT_EQ(f.Deformed(PointNormals::kNone),
              std::vector<Vec3d>(out.begin(), out.begin() + kWeightedCount));
  });
}

TEST(WeightedPoints, ForwardModeIsTheDerivative) {
  constexpr double kStep = 1e-5;
  ForSomeDegrees([](std::array<int, 3> degree) {
    WeightedPointSet f(degree);
    const std::vector<Vec3d> tangent = f.random.Some(f.control_points.size());
    const std::vector<Vec3d> out = f.Velocities(tangent, PointNormals::kWanted);
    const std::vector<Vec3d> at = f.control_points;
    const auto moved = [&](double step) {
      for (size_t i = 0; i < at.size(); ++i) f.control_points[i] = at[i] + step * tangent[i];
      return f.Deformed();
    };

    const std::vector<Vec3d> after = moved(kStep), before = moved(-kStep);

    for (size_t i = 0; i < out.size(); ++i) {
      const Vec3d difference = (after[i] - before[i]) / (2 * kStep);
      const bool is_normal = i >= kWeightedCount;
      // The second difference of a normal grows with its condition.
      const double tolerance = is_normal ? 1e-5 * (1 + std::pow(Norm(out[i]), 3)) : 1e-9;
      ASSERT_LE(Norm(out[i] - difference), tolerance) << i;
    }
  });
}

TEST(WeightedPoints, TransposeIsTheAdjoint) {
  ForSomeDegrees([](std::array<int, 3> degree) {
    WeightedPointSet f(degree);
    for (const PointNormals with : {PointNormals::kNone, PointNormals::kWanted}) {
      const std::vector<Vec3d> tangent = f.random.Some(f.control_points.size());
      const std::vector<Vec3d> cotangent = f.random.Some(VectorsPerDirection(*f.points, with));
      std::vector<Vec3d> gradient(f.control_points.size());

      EXPECT_OK(ApplyJacobianTranspose(*f.points, f.control_points, cotangent, with, f.arena,
                                       NeverStop, gradient));

      const std::vector<Vec3d> velocities = f.Velocities(tangent, with);
      const double size =
          std::sqrt(LongDot(velocities, velocities) * LongDot(cotangent, cotangent));
      EXPECT_NEAR(LongDot(velocities, cotangent), LongDot(tangent, gradient), 1e-12 * size);
    }
  });
}

}  // namespace
}  // namespace latticed
