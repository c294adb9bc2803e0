// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points under lattices that are turned against each other: against EvaluateWorld of a plan, against differences, and forward
// against reverse mode.
#include "core/points/summed_points.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "core/ffd/weights/vertex_weights.h"
#include "core/points/host_points.h"
#include "tests/core/points/point_fixture.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

constexpr uint32_t kSummedSeed = 70;
constexpr size_t kSummedCount = 700;
constexpr double kSummedPosition = 1e-13;
constexpr double kSummedNormal = 1e-11;  // of condition 100 or less

// Around a part of the points that ObliqueStructure is around, and turned against it by `turn`.
LatticeStructure TurnedStructure(std::array<int, 3> degree, double turn, Vec3d offset) {
  LatticeStructure s = ObliqueStructure(degree, {1, 2, 1});
  s.frame.origin += offset;
  const double c = std::cos(turn), sine = std::sin(turn);
  for (Vec3d& edge : s.frame.edges) {
    edge = 0.8 * Vec3d{c * edge.x - sine * edge.y, sine * edge.x + c * edge.y, edge.z};
  }
  return s;
}

// Points under one lattice and two that are turned. Some points are in all of them and some in none.
struct SummedPointSet {
  RandomVectors random{kSummedSeed};
  CpuArena arena;
  DeformPlan plan;
  std::vector<Vec3d> control_points, world, normals;
  std::vector<PointWeight> weights;
  std::unique_ptr<SummedPoints> points;

  explicit SummedPointSet(std::array<int, 3> degree, size_t count = kSummedCount,
                          bool weighted = false, int threads = 2)
      : arena(threads) {
    plan.structure = ObliqueStructure(degree, {2, 1, 3});
    plan.turned.resize(2);
    plan.turned[0].structure =
        TurnedStructure({degree[1], degree[2], degree[0]}, 0.4, {0.1, 0.3, 0.2});
    plan.turned[1].structure =
        TurnedStructure({4 - degree[2], degree[0], degree[1]}, -0.5, {-0.5, 1, 2});
    control_points = random.Jittered(plan.structure, 0.1);
    for (TurnedLattice& turned : plan.turned) {
      turned.first_point = control_points.size();
      const auto own = random.Jittered(turned.structure, 0.1);
      control_points.insert(control_points.end(), own.begin(), own.end());
    }
    world = random.Around(plan.structure, count);
    // Half of those outside the first lattice come closer, to where a turned one is.
    for (size_t i = 7; i < count; i += 16) world[i] = world[i] - plan.structure.frame.edges[1];
    normals = random.Units(count);
    if (weighted) {
      for (size_t i = 0; i < count; ++i) {
        weights.push_back({std::clamp(1.5 * random.Next().x, 0.0, 1.0), random.Next(0.3)});
      }
    }
    std::vector<std::shared_ptr<PointEvaluator>> lattices{Sorted(plan.structure, normals)};
    for (const TurnedLattice& turned : plan.turned) {
      lattices.push_back(Sorted(turned.structure, {}));
    }
    points = std::make_unique<SummedPoints>(std::move(lattices), &arena);
  }
  std::shared_ptr<PointEvaluator> Sorted(const LatticeStructure& structure,
                                         std::span<const Vec3d> with) {
    return std::make_shared<HostPoints>(
        std::make_shared<const SortedPoints>(structure, world, with, arena, weights), &arena);
  }
  size_t Values(PointNormals with) const { return VectorsPerDirection(points->points(), with); }
  std::vector<Vec3d> Deformed(PointNormals with = PointNormals::kWanted) {
    std::vector<Vec3d> out(Values(with));
    EXPECT_OK(points->Deform(control_points, with, NeverStop, out));
    return out;
  }
  std::vector<Vec3d> Velocities(const std::vector<Vec3d>& tangents, PointNormals with) {
    std::vector<Vec3d> out(Values(with) * (tangents.size() / control_points.size()));
    EXPECT_OK(points->ApplyJacobian(control_points, tangents, with, NeverStop, out));
    return out;
  }
  std::vector<Vec3d> Gradients(const std::vector<Vec3d>& cotangents, PointNormals with) {
    std::vector<Vec3d> out(control_points.size() * (cotangents.size() / Values(with)));
    EXPECT_OK(points->ApplyJacobianTranspose(control_points, cotangents, with, NeverStop, out));
    return out;
  }
  DeformedPoint Expected(size_t i) const {
    DeformedPoint point = EvaluateWorld(plan, control_points, world[i]);
    if (weights.empty()) return point;
    Weigh(world[i], weights[i].weight, weights[i].gradient, point.position, point.jacobian);
    return point;
  }
};

template <class Body>
void ForEveryMix(const Body& body) {
  for (int u = 1; u <= 3; ++u) {
    for (int v = 1; v <= 3; ++v) {
      for (int w = 1; w <= 3; ++w) {
        SCOPED_TRACE(::testing::Message() << "degree " << u << v << w << ", seed " << kSummedSeed);
        body(std::array<int, 3>{u, v, w});
      }
    }
  }
}

void ExpectDefinition(SummedPointSet& f) {
  const std::vector<Vec3d> out = f.Deformed();
  size_t compared = 0;
  for (size_t i = 0; i < f.world.size(); ++i) {
    const DeformedPoint expected = f.Expected(i);
    ASSERT_LE(Norm(out[i] - expected.position), kSummedPosition) << i;
    const CarriedNormal carried = CarryNormal(expected.jacobian.data(), f.normals[i]);
    if (carried.kappa > 100) continue;
    ++compared;
    ASSERT_LE(Norm(out[f.world.size() + i] - carried.direction), kSummedNormal) << i;
  }
  EXPECT_GT(compared, f.world.size() / 2);
}

// The derivative along `tangent`.
void ExpectDifferences(SummedPointSet& f, const std::vector<Vec3d>& tangent) {
  constexpr double kStep = 1e-5;
  const std::vector<Vec3d> control_points = f.control_points;
  const auto moved = [&](double step) {
    for (size_t i = 0; i < tangent.size(); ++i) {
      f.control_points[i] = control_points[i] + step * tangent[i];
    }
    return f.Deformed();
  };
  const std::vector<Vec3d> after = moved(kStep), before = moved(-kStep);
  f.control_points = control_points;

  const std::vector<Vec3d> out = f.Velocities(tangent, PointNormals::kWanted);

  for (size_t i = 0; i < out.size(); ++i) {
    const Vec3d difference = (after[i] - before[i]) / (2 * kStep);
    // The second difference of a normal grows with its condition.
    const bool is_normal = i >= f.world.size();
    const double tolerance = is_normal ? 1e-5 * (1 + std::pow(Norm(out[i]), 3)) : 1e-9;
    ASSERT_LE(Norm(out[i] - difference), tolerance) << i;
  }
}

void ExpectAdjoint(SummedPointSet& f, PointNormals with) {
  const std::vector<Vec3d> tangent = f.random.Some(f.control_points.size());
  const std::vector<Vec3d> cotangent = f.random.Some(f.Values(with));

  const std::vector<Vec3d> velocities = f.Velocities(tangent, with);
  const double forward = LongDot(velocities, cotangent);
  const double reverse = LongDot(tangent, f.Gradients(cotangent, with));

  const double size = std::sqrt(LongDot(velocities, velocities) * LongDot(cotangent, cotangent));
  EXPECT_LE(std::abs(forward - reverse), 1e-12 * size);
}

TEST(SummedPoints, DeformMatchesTheDefinitionAtEveryMix) {
  ForEveryMix([](std::array<int, 3> degree) {
    SummedPointSet f(degree);
    ExpectDefinition(f);
  });
}

TEST(SummedPoints, ForwardModeIsTheDerivativeAtEveryMix) {
  ForEveryMix([](std::array<int, 3> degree) {
    SummedPointSet f(degree, 200);
    ExpectDifferences(f, f.random.Some(f.control_points.size()));
  });
}

TEST(SummedPoints, OneLatticeAloneMayMove) {
  SummedPointSet f({2, 3, 1});
  std::vector<Vec3d> tangent(f.control_points.size());
  for (size_t i = f.plan.turned[0].first_point; i < f.plan.turned[1].first_point; ++i) {
    tangent[i] = f.random.Next();
  }
  ExpectDifferences(f, tangent);
  for (const Vec3d v : f.Velocities(std::vector<Vec3d>(tangent.size()), PointNormals::kWanted)) {
    ASSERT_EQ(v, Vec3d());
  }
}

TEST(SummedPoints, TransposeIsTheAdjointAtEveryMix) {
  ForEveryMix([](std::array<int, 3> degree) {
    SummedPointSet f(degree, 2'000);
    ExpectAdjoint(f, PointNormals::kNone);
    ExpectAdjoint(f, PointNormals::kWanted);
  });
}

TEST(SummedPoints, WeightsTakePointsAPartOfTheWay) {
  ForEveryMix([](std::array<int, 3> degree) {
    SummedPointSet f(degree, 400, true);
    ExpectDefinition(f);
    ExpectDifferences(f, f.random.Some(f.control_points.size()));
    ExpectAdjoint(f, PointNormals::kNone);
    ExpectAdjoint(f, PointNormals::kWanted);
  });
}

TEST(SummedPoints, ManyDirectionsAreThoseOfEachAlone) {
  constexpr size_t kMany = kDirectionsTogether + 3;
  SummedPointSet f({2, 1, 3}, 1'500);
  for (const PointNormals with : {PointNormals::kNone, PointNormals::kWanted}) {
    const size_t points = f.control_points.size(), values = f.Values(with);
    const std::vector<Vec3d> tangents = f.random.Some(kMany * points);
    const std::vector<Vec3d> cotangents = f.random.Some(kMany * values);
    const std::vector<Vec3d> velocities = f.Velocities(tangents, with);
    const std::vector<Vec3d> gradients = f.Gradients(cotangents, with);
    const auto one = [](const std::vector<Vec3d>& of, size_t d, size_t each) {
      const auto part = std::span(of).subspan(d * each, each);
      return std::vector<Vec3d>(part.begin(), part.end());
    };
    for (size_t d = 0; d < kMany; ++d) {
      EXPECT_EQ(f.Velocities(one(tangents, d, points), with), one(velocities, d, values)) << d;
      EXPECT_EQ(f.Gradients(one(cotangents, d, values), with), one(gradients, d, points)) << d;
    }
  }
}

TEST(SummedPoints, PointsOutsideAreThoseThatNoLatticeReaches) {
  SummedPointSet f({2, 2, 2}, 5'000);
  const std::vector<Vec3d> out = f.Deformed();
  const auto moved = f.Velocities(f.random.Some(f.control_points.size()), PointNormals::kWanted);
  size_t outside = 0, in_a_turned_one = 0;
  for (size_t i = 0; i < f.world.size(); ++i) {
    const bool reached = std::ranges::any_of(f.plan.turned, [&](const TurnedLattice& turned) {
      return FindVolumePlace(turned.structure, f.world[i]).has_value();
    });
    if (FindVolumePlace(f.plan.structure, f.world[i]).has_value()) continue;
    if (reached) {
      ++in_a_turned_one;
      continue;
    }
    ++outside;
    EXPECT_EQ(out[i], f.world[i]);
    EXPECT_LE(Norm(out[f.world.size() + i] - f.normals[i]), 1e-15);
    EXPECT_EQ(moved[i], Vec3d());
    EXPECT_EQ(moved[f.world.size() + i], Vec3d());
  }
  EXPECT_GT(outside, 50u);
  EXPECT_GT(in_a_turned_one, 20u);
  EXPECT_EQ(f.points->points_outside(), outside);
}

TEST(SummedPoints, HaveTheSameBitsOnOneThreadAndOnEight) {
  constexpr size_t kPoints = 50'000;
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 8);
  SummedPointSet one({3, 2, 1}, kPoints, false, 1), eight({3, 2, 1}, kPoints, false, 8);
  const std::vector<Vec3d> tangent = one.random.Some(one.control_points.size());
  const std::vector<Vec3d> cotangent = one.random.Some(2 * kPoints);
  const auto same = [](const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    return std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3d)) == 0;
  };
  const std::vector<Vec3d> deformed = one.Deformed();
  const std::vector<Vec3d> velocities = one.Velocities(tangent, PointNormals::kWanted);
  const std::vector<Vec3d> gradients = one.Gradients(cotangent, PointNormals::kWanted);
  for (int run = 0; run < 3; ++run) {
    EXPECT_TRUE(same(eight.Deformed(), deformed));
    EXPECT_TRUE(same(eight.Velocities(tangent, PointNormals::kWanted), velocities));
    EXPECT_TRUE(same(eight.Gradients(cotangent, PointNormals::kWanted), gradients));
  }
}

TEST(SummedPoints, StopWhenTheCallerHasGone) {
  SummedPointSet f({2, 2, 2}, 100);
  const auto gone = [] { return absl::CancelledError("gone"); };
  std::vector<Vec3d> out(f.world.size()), gradient(f.control_points.size());
  EXPECT_TRUE(
      absl::IsCancelled(f.points->Deform(f.control_points, PointNormals::kNone, gone, out)));
  EXPECT_TRUE(absl::IsCancelled(
      f.points->ApplyJacobian(f.control_points, f.control_points, PointNormals::kNone, gone, out)));
  EXPECT_TRUE(absl::IsCancelled(f.points->ApplyJacobianTranspose(
      f.control_points, f.world, PointNormals::kNone, gone, gradient)));
}

}  // namespace
}  // namespace latticed
