// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points of the world and their derivatives on every backend, against the definition in double.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/ffd/direct_ffd.h"
#include "core/points/host_points.h"
#include "core/points/point_evaluator.h"
#include "tests/backend/conformance.h"
#include "tests/core/points/point_fixture.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kPointsSeed = 26;
constexpr double kPointsJitter = 0.2;  // of coordinates; the frame's edges are 2 to 4 long
// Rounding of some 64 products of numbers up to 8.
constexpr double kPositionTolerance = 2e-14;
constexpr double kNormalTolerance = 2e-12;
constexpr double kAdjointness = 1e-12;

// Points in and around a lattice, on a backend.
struct PlacedPoints {
  LatticeStructure structure;
  std::vector<Vec3d> control_points, world, rest_normals;
  CpuArena arena{2};
  std::shared_ptr<PointEvaluator> evaluator;

  PlacedPoints(Backend& backend, std::array<int, 3> degree, size_t count, RandomVectors& random)
      : structure(ObliqueStructure(degree, {2, 1, 3})),
        control_points(random.Jittered(structure, kPointsJitter)),
        world(random.Around(structure, count)),
        rest_normals(random.Units(count)) {
    Prepare(backend);
  }
  // Again, after a change of what is above.
  void Prepare(Backend& backend) {
    const auto sorted = std::make_shared<const SortedPoints>(structure, world, rest_normals, arena);
    auto prepared = backend.PreparePoints(sorted);
    ASSERT_OK(prepared);
    ASSERT_EQ(*prepared == nullptr, backend.name() == "cpu");
    evaluator = *prepared != nullptr ? *prepared : std::make_shared<HostPoints>(sorted, &arena);
  }

  const SortedPoints& points() const { return evaluator->points(); }
  std::vector<Vec3d> Deformed(PointNormals normals = PointNormals::kWanted) const {
    std::vector<Vec3d> out(VectorsPerDirection(points(), normals));
    EXPECT_OK(evaluator->Deform(control_points, normals, NeverStop, out));
    return out;
  }
  std::vector<Vec3d> Velocities(const std::vector<Vec3d>& tangents,
                                PointNormals normals = PointNormals::kWanted) const {
    std::vector<Vec3d> out(VectorsPerDirection(points(), normals) *
                           (tangents.size() / control_points.size()));
    EXPECT_OK(evaluator->ApplyJacobian(control_points, tangents, normals, NeverStop, out));
    return out;
  }
  std::vector<Vec3d> Gradients(const std::vector<Vec3d>& cotangents, PointNormals normals) const {
    std::vector<Vec3d> out(control_points.size() *
                           (cotangents.size() / VectorsPerDirection(points(), normals)));
    EXPECT_OK(
        evaluator->ApplyJacobianTranspose(control_points, cotangents, normals, NeverStop, out));
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

class Points : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { backend_ = BackendOrSkip(GetParam()); }
  PlacedPoints Scene(std::array<int, 3> degree, size_t count) {
    return PlacedPoints(*backend_, degree, count, random_);
  }
  void ExpectAdjoint(const PlacedPoints& f, PointNormals normals) {
    const std::vector<Vec3d> tangent = random_.Some(f.control_points.size());
    const std::vector<Vec3d> cotangent = random_.Some(VectorsPerDirection(f.points(), normals));

    const std::vector<Vec3d> velocities = f.Velocities(tangent, normals);
    const double forward = LongDot(velocities, cotangent);
    const double reverse = LongDot(tangent, f.Gradients(cotangent, normals));

    const double size = std::sqrt(LongDot(velocities, velocities) * LongDot(cotangent, cotangent));
    EXPECT_LE(std::abs(forward - reverse), kAdjointness * size);
  }

  std::unique_ptr<Backend> backend_;
  RandomVectors random_{kPointsSeed};
};

TEST_P(Points, DeformMatchesTheDefinitionAtEveryDegree) {
  ForAllDegrees([&](std::array<int, 3> degree) {
    PlacedPoints f = Scene(degree, 700);

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

TEST_P(Points, ForwardModeIsTheDerivativeAtEveryDegree) {
  constexpr double kStep = 1e-5;
  ForAllDegrees([&](std::array<int, 3> degree) {
    PlacedPoints f = Scene(degree, 300);
    const std::vector<Vec3d> tangent = random_.Some(f.control_points.size());
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

TEST_P(Points, ManyDirectionsGiveTheBitsOfEachAlone) {
  constexpr size_t kDirections = kDirectionsTogether + 3;
  PlacedPoints f = Scene({2, 2, 3}, 1'500);
  const size_t count = f.control_points.size(), values = 2 * f.world.size();
  const std::vector<Vec3d> tangents = random_.Some(kDirections * count);
  const std::vector<Vec3d> cotangents = random_.Some(kDirections * values);

  const std::vector<Vec3d> velocities = f.Velocities(tangents);
  const std::vector<Vec3d> gradients = f.Gradients(cotangents, PointNormals::kWanted);

  for (size_t d = 0; d < kDirections; ++d) {
    const auto begin = [d](const auto& v, size_t each) {
      return v.begin() + static_cast<std::ptrdiff_t>(d * each);
    };
    const std::vector<Vec3d> tangent(begin(tangents, count),
                                     begin(tangents, count) + static_cast<std::ptrdiff_t>(count));
    const std::vector<Vec3d> cotangent(
        begin(cotangents, values), begin(cotangents, values) + static_cast<std::ptrdiff_t>(values));
    const std::vector<Vec3d> velocity = f.Velocities(tangent);
    const std::vector<Vec3d> gradient = f.Gradients(cotangent, PointNormals::kWanted);
    EXPECT_TRUE(std::equal(velocity.begin(), velocity.end(), begin(velocities, values)));
    EXPECT_TRUE(std::equal(gradient.begin(), gradient.end(), begin(gradients, count)));
  }
}

TEST_P(Points, OutsidePointsStayAndHaveNoDerivative) {
  PlacedPoints f = Scene({1, 2, 2}, 80);
  const std::vector<Vec3d> out = f.Deformed();
  const std::vector<Vec3d> moved = f.Velocities(random_.Some(f.control_points.size()));
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
  EXPECT_EQ(f.points().size() - f.points().inside(), outside);
  for (const Vec3d g : f.Gradients(cotangents, PointNormals::kWanted)) {
    EXPECT_EQ(g, Vec3d());
  }
}

TEST_P(Points, ACollapsedLatticeHasNoNormalAndNoDerivativeOfOne) {
  PlacedPoints f = Scene({2, 2, 2}, 64);
  std::ranges::fill(f.control_points, Vec3d{1, 2, 3});

  const std::vector<Vec3d> out = f.Deformed();
  const std::vector<Vec3d> moved = f.Velocities(random_.Some(f.control_points.size()));

  for (size_t place = 0; place < f.points().inside(); ++place) {
    const size_t i = f.points().order()[place];
    EXPECT_EQ(out[i], (Vec3d{1, 2, 3}));
    EXPECT_EQ(out[f.world.size() + i], Vec3d());
    EXPECT_EQ(moved[f.world.size() + i], Vec3d());
  }
}

TEST_P(Points, StopsWhenTheCallerHasGone) {
  const PlacedPoints f = Scene({2, 2, 2}, 100);
  const auto gone = [] { return absl::CancelledError("gone"); };
  std::vector<Vec3d> out(f.world.size()), gradient(f.control_points.size());
  EXPECT_TRUE(
      absl::IsCancelled(f.evaluator->Deform(f.control_points, PointNormals::kNone, gone, out)));
  EXPECT_TRUE(absl::IsCancelled(f.evaluator->ApplyJacobian(f.control_points, f.control_points,
                                                           PointNormals::kNone, gone, out)));
  EXPECT_TRUE(absl::IsCancelled(f.evaluator->ApplyJacobianTranspose(
      f.control_points, f.world, PointNormals::kNone, gone, gradient)));
}

TEST_P(Points, TransposeIsTheAdjointAtEveryDegree) {
  ForAllDegrees([&](std::array<int, 3> degree) {
    const PlacedPoints f = Scene(degree, 2'000);
    ExpectAdjoint(f, PointNormals::kNone);
    ExpectAdjoint(f, PointNormals::kWanted);
  });
}

// Boxes of many runs and of a few points, and boxes without any.
TEST_P(Points, UnevenBoxesHaveExactSums) {
  PlacedPoints f = Scene({2, 3, 1}, 1'000);
  const Vec3d origin = f.structure.frame.origin;
  const auto& edges = f.structure.frame.edges;
  const Vec3d corner = 0.05 * (edges[0] + edges[1] + edges[2]);
  for (size_t i = 0; i < 2 * SortedPoints::kRunPoints + 77; ++i) {
    f.world.push_back(origin + corner + random_.Next(0.01));
    f.rest_normals.push_back(Unit(random_.Next()));
  }
  f.Prepare(*backend_);
  EXPECT_EQ(f.points().runs()[2].box, f.points().runs()[0].box);
  ExpectAdjoint(f, PointNormals::kNone);
  ExpectAdjoint(f, PointNormals::kWanted);
}

TEST_P(Points, CallsHaveTheSameBitsEveryTime) {
  const PlacedPoints f = Scene({3, 2, 1}, 100'000);
  const std::vector<Vec3d> tangents = random_.Some(f.control_points.size());
  const std::vector<Vec3d> cotangents = random_.Some(2 * f.world.size());
  const std::vector<Vec3d> deformed = f.Deformed(), moved = f.Velocities(tangents);
  const std::vector<Vec3d> gradient = f.Gradients(cotangents, PointNormals::kWanted);
  const auto expect_same = [](const std::vector<Vec3d>& got, const std::vector<Vec3d>& expected) {
    ASSERT_EQ(got.size(), expected.size());
    EXPECT_EQ(std::memcmp(got.data(), expected.data(), got.size() * sizeof(Vec3d)), 0);
  };

  for (int run = 0; run < 3; ++run) {
    expect_same(f.Deformed(), deformed);
    expect_same(f.Velocities(tangents), moved);
    expect_same(f.Gradients(cotangents, PointNormals::kWanted), gradient);
  }
  // Another evaluator of the same points.
  PlacedPoints again(*backend_, {3, 2, 1}, 8, random_);
  again.world = f.world, again.rest_normals = f.rest_normals;
  again.control_points = f.control_points;
  again.Prepare(*backend_);
  expect_same(again.Gradients(cotangents, PointNormals::kWanted), gradient);
}

TEST_P(Points, WithoutNormalsPositionsAreTheSame) {
  PlacedPoints f = Scene({2, 3, 1}, 999);
  const std::vector<Vec3d> both = f.Deformed(), alone = f.Deformed(PointNormals::kNone);
  f.rest_normals.clear();
  f.Prepare(*backend_);
  const std::vector<Vec3d> without = f.Deformed(PointNormals::kNone);
  ASSERT_EQ(alone.size(), without.size());
  for (size_t i = 0; i < alone.size(); ++i) {
    EXPECT_LE(Distance(both[i], alone[i]), 4e-15);
    EXPECT_EQ(alone[i], without[i]);
  }
}

TEST_P(Points, AllPointsMayBeOutside) {
  PlacedPoints f = Scene({2, 2, 2}, 300);
  for (Vec3d& p : f.world) p += Vec3d{100, 0, 0};
  f.Prepare(*backend_);
  EXPECT_EQ(f.points().inside(), 0u);
  EXPECT_EQ(f.Deformed(PointNormals::kNone), f.world);
  for (const Vec3d g : f.Gradients(random_.Some(2 * f.world.size()), PointNormals::kWanted)) {
    EXPECT_EQ(g, Vec3d());
  }
}

TEST_P(Points, FarFromTheOriginDerivativesKeepTheirDigits) {
  PlacedPoints f = Scene({3, 3, 3}, 500);
  const std::vector<Vec3d> tangents = random_.Some(f.control_points.size());
  const std::vector<Vec3d> expected = f.Deformed(PointNormals::kNone);
  const std::vector<Vec3d> expected_moves = f.Velocities(tangents, PointNormals::kNone);
  const Vec3d far_away{1e6, -2e6, 4e6};
  f.structure.frame.origin += far_away;
  for (Vec3d& p : f.world) p += far_away;
  for (Vec3d& p : f.control_points) p += far_away;

  f.Prepare(*backend_);

  const std::vector<Vec3d> deformed = f.Deformed(PointNormals::kNone);
  const std::vector<Vec3d> moved = f.Velocities(tangents, PointNormals::kNone);
  for (size_t i = 0; i < f.world.size(); ++i) {
    EXPECT_LE(Distance(deformed[i] - far_away, expected[i]), 1e-8);
    EXPECT_LE(Distance(moved[i], expected_moves[i]), 1e-8);
  }
}

TEST_P(Points, CountsItsDeviceMemoryAndFreesIt) {
  const auto free_bytes = [&] { return backend_->devices().front().free_bytes; };
  const uint64_t before = free_bytes();
  {
    const PlacedPoints f = Scene({2, 2, 2}, 10'000);
    if (GetParam() == "cpu") {
      EXPECT_EQ(f.evaluator->device_bytes(), 0u);
      return;
    }
    EXPECT_GE(f.evaluator->device_bytes(), 520'000u);
    EXPECT_EQ(before - free_bytes(), f.evaluator->device_bytes());
    EXPECT_EQ(backend_->devices().front().use.at("points"), f.evaluator->device_bytes());
    (void)f.Gradients(random_.Some(2 * f.world.size()), PointNormals::kWanted);
    EXPECT_EQ(before - free_bytes(), f.evaluator->device_bytes())
        << "a call gives back its scratch";
  }
  EXPECT_EQ(free_bytes(), before);
}

INSTANTIATE_TEST_SUITE_P(Backends, Points, ::testing::ValuesIn(KnownBackends()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace latticed::testing
