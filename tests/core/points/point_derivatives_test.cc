// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/points/point_derivatives.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstring>
#include <vector>

#include "absl/status/status.h"
#include "core/ffd/direct_ffd.h"
#include "tests/core/points/point_fixture.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

constexpr uint32_t kDerivativeSeed = 26;
constexpr double kJitter = 0.2;  // of coordinates; the frame's edges are 2 to 4 long
// Rounding of some 64 products of numbers up to 8.
constexpr double kPositionTolerance = 2e-14;
constexpr double kNormalTolerance = 2e-12;

struct Fixture {
  LatticeStructure structure;
  std::vector<Vec3d> control_points, world, rest_normals;
  CpuArena arena{2};
  SortedPoints points;

  Fixture(std::array<int, 3> degree, size_t count, RandomVectors& random)
      : structure(ObliqueStructure(degree, {2, 1, 3})),
        control_points(random.Jittered(structure, kJitter)),
        world(random.Around(structure, count)),
        rest_normals(random.Units(count)),
        points(structure, world, rest_normals, arena) {}

  std::vector<Vec3d> Deformed(PointNormals normals = PointNormals::kWanted) {
    std::vector<Vec3d> out(VectorsPerDirection(points, normals));
    EXPECT_OK(Deform(points, control_points, normals, arena, NeverStop, out));
    return out;
  }
  std::vector<Vec3d> Velocities(const std::vector<Vec3d>& tangents,
                                PointNormals normals = PointNormals::kWanted) {
    std::vector<Vec3d> out(VectorsPerDirection(points, normals) *
                           (tangents.size() / control_points.size()));
    EXPECT_OK(ApplyJacobian(points, control_points, tangents, normals, arena, NeverStop, out));
    return out;
  }
  std::vector<Vec3d> Gradients(const std::vector<Vec3d>& cotangents, PointNormals normals,
                               CpuArena& on) const {
    std::vector<Vec3d> out(control_points.size() *
                           (cotangents.size() / VectorsPerDirection(points, normals)));
    EXPECT_OK(
        ApplyJacobianTranspose(points, control_points, cotangents, normals, on, NeverStop, out));
    return out;
  }
};

template <class Body>
void ForAllDegrees(const Body& body) {
  for (int u = 1; u <= 3; ++u) {
    for (int v = 1; v <= 3; ++v) {
      for (int w = 1; w <= 3; ++w) {
        SCOPED_TRACE(::testing::Message() << "degree " << u << " " << v << " " << w);
        body(std::array<int, 3>{u, v, w});
      }
    }
  }
}

double Distance(Vec3d a, Vec3d b) { return Norm(a - b); }

TEST(PointDerivatives, DeformMatchesTheDefinitionAtEveryDegree) {
  RandomVectors random(kDerivativeSeed);
  ForAllDegrees([&](std::array<int, 3> degree) {
    Fixture f(degree, 700, random);

    const std::vector<Vec3d> out = f.Deformed();

    for (size_t i = 0; i < f.world.size(); ++i) {
      const DeformedPoint expected = EvaluateWorld(f.structure, f.control_points, f.world[i]);
      ASSERT_LE(Distance(out[i], expected.position), kPositionTolerance) << i;
      const CarriedNormal carried = CarryNormal(expected.jacobian.data(), f.rest_normals[i]);
      if (carried.kappa > 100) continue;
      ASSERT_LE(Distance(out[f.world.size() + i], carried.direction), kNormalTolerance) << i;
    }
  });
}

TEST(PointDerivatives, PositionsAreTheSameWithAndWithoutNormals) {
  RandomVectors random(kDerivativeSeed);
  Fixture f({2, 3, 1}, 999, random);
  const std::vector<Vec3d> both = f.Deformed(), alone = f.Deformed(PointNormals::kNone);
  EXPECT_EQ(std::memcmp(both.data(), alone.data(), alone.size() * sizeof(Vec3d)), 0);
}

TEST(PointDerivatives, ForwardModeIsTheDerivativeAtEveryDegree) {
  RandomVectors random(kDerivativeSeed + 1);
  constexpr double kStep = 1e-5;
  ForAllDegrees([&](std::array<int, 3> degree) {
    Fixture f(degree, 300, random);
    const std::vector<Vec3d> tangent = random.Some(f.control_points.size());
    const std::vector<Vec3d> control_points = f.control_points;
    const auto moved = [&](double step) {
      for (size_t i = 0; i < tangent.size(); ++i) {
        f.control_points[i] = control_points[i] + step * tangent[i];
      }
      return f.Deformed();
    };
    const std::vector<Vec3d> after = moved(kStep), before = moved(-kStep);
    f.control_points = control_points;

    const std::vector<Vec3d> out = f.Velocities(tangent);

    for (size_t i = 0; i < out.size(); ++i) {
      const Vec3d difference = (after[i] - before[i]) / (2 * kStep);
      const bool is_normal = i >= f.world.size();
      // The second difference of a normal grows with its condition.
      const double tolerance = is_normal ? 1e-5 * (1 + std::pow(Norm(out[i]), 3)) : 1e-9;
      ASSERT_LE(Distance(out[i], difference), tolerance) << i;
    }
  });
}

TEST(PointDerivatives, TransposeIsTheAdjointAtEveryDegree) {
  RandomVectors random(kDerivativeSeed + 2);
  constexpr double kAdjointness = 1e-12;
  ForAllDegrees([&](std::array<int, 3> degree) {
    for (const PointNormals normals : {PointNormals::kNone, PointNormals::kWanted}) {
      Fixture f(degree, 2'000, random);
      const std::vector<Vec3d> tangent = random.Some(f.control_points.size());
      const std::vector<Vec3d> cotangent = random.Some(VectorsPerDirection(f.points, normals));

      const std::vector<Vec3d> velocities = f.Velocities(tangent, normals);
      const double forward = LongDot(velocities, cotangent);
      const double reverse = LongDot(tangent, f.Gradients(cotangent, normals, f.arena));

      const double size =
          std::sqrt(LongDot(velocities, velocities) * LongDot(cotangent, cotangent));
      EXPECT_LE(std::abs(forward - reverse), kAdjointness * size);
    }
  });
}

TEST(PointDerivatives, ManyDirectionsGiveTheBitsOfEachAlone) {
  RandomVectors random(kDerivativeSeed + 3);
  constexpr size_t kDirections = kDirectionsTogether + 3;
  Fixture f({2, 2, 3}, 1'500, random);
  const size_t count = f.control_points.size(), values = 2 * f.world.size();
  const std::vector<Vec3d> tangents = random.Some(kDirections * count);
  const std::vector<Vec3d> cotangents = random.Some(kDirections * values);

  const std::vector<Vec3d> velocities = f.Velocities(tangents);
  const std::vector<Vec3d> gradients = f.Gradients(cotangents, PointNormals::kWanted, f.arena);

  for (size_t d = 0; d < kDirections; ++d) {
    const auto begin = [d](const auto& v, size_t each) {
      return v.begin() + static_cast<std::ptrdiff_t>(d * each);
    };
    const std::vector<Vec3d> tangent(begin(tangents, count),
                                     begin(tangents, count) + static_cast<std::ptrdiff_t>(count));
    const std::vector<Vec3d> cotangent(
        begin(cotangents, values), begin(cotangents, values) + static_cast<std::ptrdiff_t>(values));
    const std::vector<Vec3d> velocity = f.Velocities(tangent);
    const std::vector<Vec3d> gradient = f.Gradients(cotangent, PointNormals::kWanted, f.arena);
    EXPECT_TRUE(std::equal(velocity.begin(), velocity.end(), begin(velocities, values)));
    EXPECT_TRUE(std::equal(gradient.begin(), gradient.end(), begin(gradients, count)));
  }
}

TEST(PointDerivatives, SumsHaveTheSameBitsOnOneThreadAndOnEight) {
  RandomVectors random(kDerivativeSeed + 4);
  Fixture f({3, 2, 1}, 100'000, random);
  const std::vector<Vec3d> cotangents = random.Some(2 * f.world.size());
  // Also on a machine with fewer cores.
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 8);
  CpuArena one(1), eight(8);
  const std::vector<Vec3d> expected = f.Gradients(cotangents, PointNormals::kWanted, one);

  for (int run = 0; run < 5; ++run) {
    const std::vector<Vec3d> got = f.Gradients(cotangents, PointNormals::kWanted, eight);
    ASSERT_EQ(std::memcmp(got.data(), expected.data(), got.size() * sizeof(Vec3d)), 0);
  }
}

TEST(PointDerivatives, OutsidePointsStayAndHaveNoDerivative) {
  RandomVectors random(kDerivativeSeed + 5);
  Fixture f({1, 2, 2}, 80, random);
  const std::vector<Vec3d> out = f.Deformed();
  const std::vector<Vec3d> moved = f.Velocities(random.Some(f.control_points.size()));
  std::vector<Vec3d> cotangents(2 * f.world.size());
  size_t outside = 0;
  for (size_t i = 7; i < f.world.size(); i += 8) {
    ++outside;
    EXPECT_EQ(out[i], f.world[i]);
    EXPECT_EQ(out[f.world.size() + i], f.rest_normals[i]);
    EXPECT_EQ(moved[i], Vec3d());
    EXPECT_EQ(moved[f.world.size() + i], Vec3d());
    cotangents[i] = cotangents[f.world.size() + i] = {1, 2, 3};
  }
  EXPECT_EQ(f.points.size() - f.points.inside(), outside);
  for (const Vec3d g : f.Gradients(cotangents, PointNormals::kWanted, f.arena)) {
    EXPECT_EQ(g, Vec3d());
  }
}

TEST(PointDerivatives, ACollapsedLatticeHasNoNormalAndNoDerivativeOfOne) {
  RandomVectors random(kDerivativeSeed + 6);
  Fixture f({2, 2, 2}, 64, random);
  std::ranges::fill(f.control_points, Vec3d{1, 2, 3});

  const std::vector<Vec3d> out = f.Deformed();
  const std::vector<Vec3d> moved = f.Velocities(random.Some(f.control_points.size()));

  for (size_t place = 0; place < f.points.inside(); ++place) {
    const size_t i = f.points.order()[place];
    EXPECT_EQ(out[i], (Vec3d{1, 2, 3}));
    EXPECT_EQ(out[f.world.size() + i], Vec3d());
    EXPECT_EQ(moved[f.world.size() + i], Vec3d());
  }
}

TEST(PointDerivatives, FarFromTheOriginDerivativesKeepTheirDigits) {
  RandomVectors random(kDerivativeSeed + 7);
  Fixture near({3, 3, 3}, 500, random);
  const Vec3d far_away{1e6, -2e6, 4e6};
  LatticeStructure structure = near.structure;
  structure.frame.origin += far_away;
  std::vector<Vec3d> world = near.world, control_points = near.control_points;
  for (Vec3d& p : world) p += far_away;
  for (Vec3d& p : control_points) p += far_away;
  const SortedPoints points(structure, world, {}, near.arena);
  const std::vector<Vec3d> tangents = random.Some(control_points.size());
  std::vector<Vec3d> deformed(world.size()), moved(world.size());

  EXPECT_OK(Deform(points, control_points, PointNormals::kNone, near.arena, NeverStop, deformed));
  EXPECT_OK(ApplyJacobian(points, control_points, tangents, PointNormals::kNone, near.arena,
                          NeverStop, moved));

  const std::vector<Vec3d> expected = near.Deformed(PointNormals::kNone);
  const std::vector<Vec3d> expected_moves = near.Velocities(tangents, PointNormals::kNone);
  for (size_t i = 0; i < world.size(); ++i) {
    EXPECT_LE(Distance(deformed[i] - far_away, expected[i]), 1e-8);
    EXPECT_LE(Distance(moved[i], expected_moves[i]), 1e-8);
  }
}

TEST(PointDerivatives, StopsWhenTheCallerHasGone) {
  RandomVectors random(kDerivativeSeed + 8);
  Fixture f({2, 2, 2}, 100, random);
  const auto gone = [] { return absl::CancelledError("gone"); };
  std::vector<Vec3d> out(f.world.size()), gradient(f.control_points.size());
  EXPECT_TRUE(absl::IsCancelled(
      Deform(f.points, f.control_points, PointNormals::kNone, f.arena, gone, out)));
  EXPECT_TRUE(absl::IsCancelled(ApplyJacobian(f.points, f.control_points, f.control_points,
                                              PointNormals::kNone, f.arena, gone, out)));
  EXPECT_TRUE(absl::IsCancelled(ApplyJacobianTranspose(
      f.points, f.control_points, f.world, PointNormals::kNone, f.arena, gone, gradient)));
}

}  // namespace
}  // namespace latticed
