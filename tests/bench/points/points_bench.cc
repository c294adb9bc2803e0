// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Point sets: 10^6 points in an 8 x 8 x 8 lattice, in random order: sorted, deformed, forward and reverse mode. One
// thread, unless the name says otherwise. Rows of "points/cuda" are on a device, with the copies over the bus. Beside it,
// pygeo_like.py does the same by a sparse matrix.
#include <cmath>
#include <cstdlib>
#include <memory>
#include <random>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "core/points/host_points.h"
#include "cuda/cuda_backend.h"
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
void Verify(const PointScene& scene, PointEvaluator& points) {
  std::vector<Vec3d> out(kPoints), moved(kPoints), gradient(scene.control_points.size());
  bool good = points.Deform(scene.control_points, PointNormals::kNone, NeverStop, out).ok();
  for (size_t i = 0; i < kPoints; i += 101) {
    const Vec3d expected =
        EvaluateWorld(scene.structure, scene.control_points, scene.world[i]).position;
    good = good && Norm(out[i] - expected) < 1e-14;
  }
  const std::span<const Vec3d> cotangents(scene.cotangents.data(), kPoints);
  good =
      good &&
      points
          .ApplyJacobian(scene.control_points, scene.tangent, PointNormals::kNone, NeverStop, moved)
          .ok() &&
      points
          .ApplyJacobianTranspose(scene.control_points, cotangents, PointNormals::kNone, NeverStop,
                                  gradient)
          .ok();
  long double forward = 0, reverse = 0;
  for (size_t i = 0; i < kPoints; ++i) forward += Dot(moved[i], cotangents[i]);
  for (size_t i = 0; i < gradient.size(); ++i) reverse += Dot(scene.tangent[i], gradient[i]);
  if (good && std::abs(forward - reverse) <= 1e-12L * std::abs(forward)) return;
  fmt::print(stderr, "points: the result differs from the definition\n");
  std::exit(1);
}

enum class Call { kSort, kDeform, kForward, kReverse };

struct Row {
  const char* name;
  Call call;
  PointNormals normals;
  int threads = 1;
  size_t directions = 1;
};

// Of a CUDA device, or of the host.
absl::StatusOr<std::shared_ptr<PointEvaluator>> EvaluatorOf(
    const std::shared_ptr<const SortedPoints>& points, Backend* device, CpuArena& arena) {
  if (device == nullptr) return std::make_shared<HostPoints>(points, &arena);
  return device->PreparePoints(points);
}

void Run(benchmark::State& state, int degree, const Row& row, Backend* device) {
  const PointScene scene(degree);
  CpuArena arena(row.threads);
  const auto sorted =
      std::make_shared<const SortedPoints>(scene.structure, scene.world, scene.normals, arena);
  const auto evaluator = EvaluatorOf(sorted, device, arena);
  if (!evaluator.ok()) return Skip(state, evaluator.status());
  PointEvaluator& points = **evaluator;
  Verify(scene, points);
  const PointNormals wanted = row.normals;
  const size_t directions = row.directions, per_direction = VectorsPerDirection(*sorted, wanted);
  std::vector<Vec3d> out(directions * per_direction), cotangents, tangents,
      gradients(directions * scene.control_points.size());
  for (size_t d = 0; d < directions; ++d) {
    tangents.insert(tangents.end(), scene.tangent.begin(), scene.tangent.end());
    cotangents.insert(cotangents.end(), scene.cotangents.begin(),
                      scene.cotangents.begin() + static_cast<std::ptrdiff_t>(per_direction));
  }
  for (auto _ : state) {
    switch (row.call) {
      case Call::kSort:
        benchmark::DoNotOptimize(
            SortedPoints(scene.structure, scene.world, scene.normals, arena).size());
        break;
      case Call::kDeform:
        (void)points.Deform(scene.control_points, wanted, NeverStop, out);
        break;
      case Call::kForward:
        (void)points.ApplyJacobian(scene.control_points, tangents, wanted, NeverStop, out);
        break;
      case Call::kReverse:
        (void)points.ApplyJacobianTranspose(scene.control_points, cotangents, wanted, NeverStop,
                                            gradients);
        break;
    }
    benchmark::ClobberMemory();
  }
  CountPoints(state, kPoints * directions);
}

}  // namespace

void RegisterPointsBenches() {
  constexpr PointNormals kNone = PointNormals::kNone, kWanted = PointNormals::kWanted;
  for (const int degree : {2, 3}) {
    for (const Row& row :
         {Row{"sort", Call::kSort, kNone}, Row{"deform", Call::kDeform, kNone},
          Row{"deform-normals", Call::kDeform, kWanted}, Row{"forward", Call::kForward, kNone},
          Row{"forward-normals", Call::kForward, kWanted}, Row{"reverse", Call::kReverse, kNone},
          Row{"reverse-normals", Call::kReverse, kWanted},
          Row{"reverse-8-directions", Call::kReverse, kNone, 1, 8},
          Row{"reverse-2-threads", Call::kReverse, kNone, 2}}) {
      RegisterTimed(fmt::format("points/{}/degree{}", row.name, degree),
                    [row, degree](benchmark::State& state) { Run(state, degree, row, nullptr); });
      if (row.call == Call::kSort || row.threads > 1) continue;
      RegisterTimed(fmt::format("points/cuda/{}/degree{}", row.name, degree),
                    [row, degree](benchmark::State& state) {
                      const auto backend = MakeCudaBackend({});
                      if (!backend.ok()) return SkipNotHere(state, backend.status());
                      Run(state, degree, row, backend->get());
                    });
    }
  }
}

}  // namespace latticed::bench
