// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Point sets: 10^6 points in an 8 x 8 x 8 lattice, in random order: sorted, deformed, forward and reverse mode. One
// thread, unless the name says otherwise. Beside it, pygeo_like.py does the same by a sparse matrix.
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "core/points/point_derivatives.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"

namespace latticed::bench {
namespace {

constexpr size_t kPoints = 1'000'000;
constexpr uint32_t kSeed = 26;

struct PointScene {
  LatticeStructure structure;
  std::vector<Vec3d> control_points, tangent, world, normals, cotangents;

  explicit PointScene(int degree) {
    structure.degree = {degree, degree, degree};
    structure.size = {8, 8, 8};
    for (size_t a = 0; a < 3; ++a) structure.knots[a] = ClampedUniformKnots(degree, 8);
    structure.frame = {{0, 0, 0}, {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}};
    std::mt19937 random(kSeed);
    std::uniform_real_distribution<double> uniform(0, 1);
    const auto next = [&] {
      const double x = uniform(random), y = uniform(random), z = uniform(random);
      return Vec3d{x, y, z};
    };
    control_points = IdentityControlPoints(structure);
    for (Vec3d& p : control_points) p += 0.05 * next();
    for (size_t i = 0; i < control_points.size(); ++i) tangent.push_back(next());
    for (size_t i = 0; i < kPoints; ++i) {
      world.push_back(next());
      normals.push_back(Unit(next()));
    }
    for (size_t i = 0; i < 2 * kPoints; ++i) cotangents.push_back(next());
  }
};

// Before anything is timed: the definition, and adjointness.
void Verify(const PointScene& scene, const SortedPoints& points, CpuArena& arena) {
  std::vector<Vec3d> out(kPoints), moved(kPoints), gradient(scene.control_points.size());
  bool good = Deform(points, scene.control_points, PointNormals::kNone, arena, NeverStop, out).ok();
  for (size_t i = 0; i < kPoints; i += 101) {
    const Vec3d expected =
        EvaluateWorld(scene.structure, scene.control_points, scene.world[i]).position;
    good = good && Norm(out[i] - expected) < 1e-14;
  }
  const std::span<const Vec3d> cotangents(scene.cotangents.data(), kPoints);
  good = good &&
         ApplyJacobian(points, scene.control_points, scene.tangent, PointNormals::kNone, arena,
                       NeverStop, moved)
             .ok() &&
         ApplyJacobianTranspose(points, scene.control_points, cotangents, PointNormals::kNone,
                                arena, NeverStop, gradient)
             .ok();
  long double forward = 0, reverse = 0;
  for (size_t i = 0; i < kPoints; ++i) forward += Dot(moved[i], cotangents[i]);
  for (size_t i = 0; i < gradient.size(); ++i) reverse += Dot(scene.tangent[i], gradient[i]);
  if (good && std::abs(forward - reverse) <= 1e-12L * std::abs(forward)) return;
  fmt::print(stderr, "points: the result differs from the definition\n");
  std::exit(1);
}

enum class Call { kSort, kDeform, kForward, kReverse };

void Run(benchmark::State& state, int degree, Call call, PointNormals wanted, int threads,
         size_t directions) {
  const PointScene scene(degree);
  CpuArena arena(threads);
  const SortedPoints points(scene.structure, scene.world, scene.normals, arena);
  Verify(scene, points, arena);
  const size_t per_direction = VectorsPerDirection(points, wanted);
  std::vector<Vec3d> out(directions * per_direction), cotangents, tangents,
      gradients(directions * scene.control_points.size());
  for (size_t d = 0; d < directions; ++d) {
    tangents.insert(tangents.end(), scene.tangent.begin(), scene.tangent.end());
    cotangents.insert(cotangents.end(), scene.cotangents.begin(),
                      scene.cotangents.begin() + static_cast<std::ptrdiff_t>(per_direction));
  }
  for (auto _ : state) {
    switch (call) {
      case Call::kSort:
        benchmark::DoNotOptimize(
            SortedPoints(scene.structure, scene.world, scene.normals, arena).size());
        break;
      case Call::kDeform:
        (void)Deform(points, scene.control_points, wanted, arena, NeverStop, out);
        break;
      case Call::kForward:
        (void)ApplyJacobian(points, scene.control_points, tangents, wanted, arena, NeverStop, out);
        break;
      case Call::kReverse:
        (void)ApplyJacobianTranspose(points, scene.control_points, cotangents, wanted, arena,
                                     NeverStop, gradients);
        break;
    }
    benchmark::ClobberMemory();
  }
  CountPoints(state, kPoints * directions);
}

}  // namespace

void RegisterPointsBenches() {
  struct Row {
    const char* name;
    Call call;
    PointNormals normals;
    int threads;
    size_t directions;
  };
  constexpr PointNormals kNone = PointNormals::kNone, kWanted = PointNormals::kWanted;
  for (const int degree : {2, 3}) {
    for (const Row& row :
         {Row{"sort", Call::kSort, kNone, 1, 1}, Row{"deform", Call::kDeform, kNone, 1, 1},
          Row{"deform-normals", Call::kDeform, kWanted, 1, 1},
          Row{"forward", Call::kForward, kNone, 1, 1},
          Row{"forward-normals", Call::kForward, kWanted, 1, 1},
          Row{"reverse", Call::kReverse, kNone, 1, 1},
          Row{"reverse-normals", Call::kReverse, kWanted, 1, 1},
          Row{"reverse-8-directions", Call::kReverse, kNone, 1, 8},
          Row{"reverse-2-threads", Call::kReverse, kNone, 2, 1}}) {
      RegisterTimed(fmt::format("points/{}/degree{}", row.name, degree),
                    [row, degree](benchmark::State& state) {
                      Run(state, degree, row.call, row.normals, row.threads, row.directions);
                    });
    }
  }
}

}  // namespace latticed::bench
