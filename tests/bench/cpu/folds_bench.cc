// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Certifying folds of a torus in an 8 x 8 x 8 lattice on one core: after an edit of one control point in the middle, and of
// all boxes. The reports are compared with samples of the definition first.
#include <array>
#include <memory>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "core/folds/fold_certifier.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"
#include "tests/support/test_meshes.h"

namespace latticed::bench {
namespace {

constexpr int kSize = 8;
constexpr double kNoise = 0.02;  // of the frame's edge: nothing folds

double Determinant(const std::array<Vec3d, 3>& j) { return Dot(j[0], Cross(j[1], j[2])); }

// Whether det J > 0 at the middle of each box, as the report says of all of it.
bool AgreesWithSamples(const DeformPlan& plan, std::span<const Vec3d> points,
                       const FoldReport& report) {
  const FrameMap map(plan.structure);
  bool agrees = true;
  for (uint32_t box = 0; box < plan.outside_box(); ++box) {
    const Vec3d middle = map.ToWorld(0.5 * (plan.boxes[box].lower + plan.boxes[box].upper));
    const double there = Determinant(EvaluateWorld(plan.structure, points, middle).jacobian);
    if (report.StateOf(box) == FoldState::kCertified) agrees = agrees && there > 0;
  }
  return agrees;
}

void Certify(benchmark::State& state, int degree, FoldScope scope, bool all) {
  const auto mesh = MakeTorus(250, 100);
  const auto lattice = Checked(
      FitLattice(mesh->ComputeBounds(), {kSize, kSize, kSize}, {degree, degree, degree}, 0.05));
  const auto plan = Checked(MakePlan(mesh, lattice.structure));
  const std::vector<Vec3d> points = testing::Jitter(plan->structure, kNoise, 1);
  const FoldCertifier certifier(plan, scope);
  const FoldReport report = Checked(certifier.Certify(points));
  const std::array changed{
      static_cast<uint32_t>(plan->structure.Index(kSize / 2, kSize / 2, kSize / 2))};
  if (!AgreesWithSamples(*plan, points, report) ||
      certifier.Recertify(report, changed, points) != report) {
    return state.SkipWithError("the report is wrong");
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(all ? Checked(certifier.Certify(points))
                                 : certifier.Recertify(report, changed, points));
  }
  state.counters["boxes"] = static_cast<double>(report.boxes);
}

}  // namespace

void RegisterFoldsBenches() {
  for (const int degree : {1, 2, 3}) {
    for (const auto& [scope, name] :
         {std::pair{FoldScope::kSurface, "surface"}, std::pair{FoldScope::kVolume, "volume"}}) {
      for (const bool all : {false, true}) {
        RegisterTimed(fmt::format("folds/degree{}/{}/{}", degree, name,
                                  all ? "all-boxes" : "one-control-point"),
                      [=](benchmark::State& state) { Certify(state, degree, scope, all); });
      }
    }
  }
}

}  // namespace latticed::bench
