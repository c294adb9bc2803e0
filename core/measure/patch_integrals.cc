// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/patch_integrals.h"

#include <algorithm>

#include "core/base/status_macros.h"
#include "core/measure/patch_points.h"
#include "core/measure/patch_runs.h"
#include "core/measure/triangle_rule.h"

namespace latticed {
namespace {

// A rule of order m is exact to the degree 2 m - 2.
int OrderFor(const DeformPlan& plan, bool with_moment) {
  const int degree = plan.surface_degree();
  return with_moment ? 2 * degree : (3 * degree + 1) / 2;
}

// The integrals over a run. Sums are for derivatives alone.
struct RunIntegrals {
  double across = 0;  // of P . n dA
  Vec3d moment;       // of P . n dA P
  std::vector<RunLattice> lattices;
  std::vector<BoxNumbers>
      sums;  // by lattice, of l^p m^q n^r w n dA; with a moment then of that times P_j
};

RunIntegrals IntegrateRun(const PatchRuns& runs, size_t run,
                          std::span<const TriangleRulePoint> rule, bool with_moment,
                          bool with_gradient) {
  RunIntegrals result{.lattices = runs.LatticesOf(run)};
  if (with_gradient) result.sums.resize(result.lattices.size() * (with_moment ? 4 : 1));
  PatchPoints points(result.lattices);
  const auto integrate = [&] {
    points.Evaluate();
    points.AddVolume(with_moment, result.across, result.moment);
    if (with_gradient) points.SumVolumeForces(result.sums, with_moment);
    points.Clear();
  };
  for (const uint32_t patch : runs.patches(run)) {
    const RestTriangle at = runs.TriangleOf(patch);
    if (result.lattices.empty() || at.Rests()) {  // P . n is constant on a flat triangle
      const double across = 0.5 * Dot(at.corner, Cross(at.s, at.t));
      result.across += across;
      result.moment += across / 3 * (3 * at.corner + at.s + at.t);
      continue;
    }
    for (auto left = rule; !left.empty();) {
      const size_t count = std::min(left.size(), PatchPoints::kMost - points.count());
      points.Add(at, left.first(count));
      if (points.count() == PatchPoints::kMost) integrate();
      left = left.subspan(count);
    }
  }
  integrate();
  return result;
}

}  // namespace

absl::StatusOr<PatchIntegrals> IntegratePatches(const DeformPlan& plan,
                                                std::span<const Vec3d> control_points,
                                                bool with_moment, StopCheck stop, CpuArena* arena,
                                                bool with_gradient) {
  const std::vector<TriangleRulePoint> rule = MakeTriangleRule(OrderFor(plan, with_moment));
  const PatchRuns runs(plan, control_points);
  PatchIntegrals result{.origin = runs.origin()};
  if (with_gradient) result.volume_gradient.resize(control_points.size());
  if (with_gradient && with_moment) result.moment_gradient.resize(control_points.size());
  LATTICED_RETURN_IF_ERROR(ForRuns(
      runs, arena, stop,
      [&](size_t run) { return IntegrateRun(runs, run, rule, with_moment, with_gradient); },
      [&](const RunIntegrals& of_run) {
        result.volume += of_run.across / 3;
        result.moment += 0.25 * of_run.moment;
        if (!with_gradient) return;
        auto sums = of_run.sums.begin();
        for (const RunLattice& lattice : of_run.lattices) {
          lattice.AddTransposed(*sums++,
                                [&](size_t i) -> Vec3d& { return result.volume_gradient[i]; });
          for (size_t j = 0; with_moment && j < 3; ++j) {
            lattice.AddTransposed(*sums++,
                                  [&](size_t i) -> Vec3d& { return result.moment_gradient[i][j]; });
          }
        }
      }));
  return result;
}

}  // namespace latticed
