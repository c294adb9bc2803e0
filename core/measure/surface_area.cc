// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/surface_area.h"

#include <algorithm>
#include <cmath>

#include "core/base/status_macros.h"
#include "core/measure/patch_points.h"
#include "core/measure/patch_runs.h"
#include "core/measure/triangle_rule.h"

namespace latticed {
namespace {

constexpr int kMostQuarterings = 24;
// Above this tolerance two low rules need the fewest points, below it two higher ones.
constexpr double kHighRules = 1e-7;

// A part of a patch.
struct PatchPart {
  RestTriangle at;
  double spare = 0;  // of its error, besides its share by area
  int quarterings = 0;
};

void AppendQuarters(const PatchPart& part, std::vector<PatchPart>& parts) {
  for (const RestTriangle& quarter : {part.at.Part(0, 0, 0.5), part.at.Part(0.5, 0, 0.5),
                                      part.at.Part(0, 0.5, 0.5), part.at.Part(0.5, 0.5, -0.5)}) {
    parts.push_back({quarter, 0.25 * part.spare, part.quarterings + 1});
  }
}

// The area of a run.
struct RunArea {
  double area = 0, error = 0;
  std::vector<RunLattice> lattices;
  std::vector<BoxNumbers> sums;  // by lattice; none if no gradient was asked for
};

// One point a patch.
struct AreaEstimate {
  double area = 0, rest_area = 0;
};

class AreaSum {
 public:
  AreaSum(const DeformPlan& plan, std::span<const Vec3d> control_points, double tolerance,
          bool with_gradient)
      : is_weighted_(plan.is_weighted()),
        runs_(plan, control_points),
        tolerance_(tolerance),
        coarse_(MakeTriangleRule(tolerance < kHighRules ? 4 : 2)),
        fine_(MakeTriangleRule(tolerance < kHighRules ? 6 : 4)) {
    if (with_gradient) result_.gradient.resize(control_points.size());
  }

  absl::StatusOr<SurfaceArea> Run(StopCheck stop, CpuArena* arena) {
    LATTICED_RETURN_IF_ERROR(ForRuns(
        runs_, arena, stop, [&](size_t run) { return EstimateOf(run); },
        [&](const AreaEstimate& of_run) {
          estimate_.area += of_run.area;
          estimate_.rest_area += of_run.rest_area;
        }));
    LATTICED_RETURN_IF_ERROR(ForRuns(
        runs_, arena, stop, [&](size_t run) { return AreaOf(run); },
        [&](const RunArea& of_run) {
          result_.area += of_run.area;
          result_.error += of_run.error;
          for (size_t g = 0; g < of_run.sums.size(); ++g) {
            of_run.lattices[g].AddTransposed(
                of_run.sums[g], [&](size_t i) -> Vec3d& { return result_.gradient[i]; });
          }
        },
        1));
    return std::move(result_);
  }

 private:
  AreaEstimate EstimateOf(size_t run) const {
    static_assert(kPatchesPerRun <= PatchPoints::kMost);
    const std::vector<TriangleRulePoint> centroid = MakeTriangleRule(1);
    const std::vector<RunLattice> lattices = runs_.LatticesOf(run);
    PatchPoints points(lattices);
    AreaEstimate estimate;
    for (const uint32_t patch : runs_.patches(run)) {
      const RestTriangle at = runs_.TriangleOf(patch);
      estimate.rest_area += at.Area();
      points.Add(at, centroid);
    }
    points.Evaluate();
    points.SetLengths();
    for (size_t i = 0; i < points.count(); ++i) estimate.area += points.AreaOf(i, i + 1);
    return estimate;
  }

  RunArea AreaOf(size_t run) const {
    RunArea result{.lattices = runs_.LatticesOf(run)};
    if (!result_.gradient.empty()) result.sums.resize(result.lattices.size());
    std::vector<PatchPart> parts;
    for (const uint32_t patch : runs_.patches(run)) {
      const RestTriangle at = runs_.TriangleOf(patch);
      const double rest_area = at.Area();
      if (result.lattices.empty() || at.Rests()) {
        result.area += rest_area;
        continue;
      }
      // Half of the error in proportion to the area, half of it in proportion to the area at rest, where a patch is
      // folded.
      parts.push_back({at, 0.5 * tolerance_ * estimate_.area * rest_area / estimate_.rest_area});
    }
    PatchPoints points(result.lattices);
    while (!parts.empty()) AddLast(parts, points, result);
    return result;
  }

  // Integrates the last parts, as many as a block holds. Quarters of those that need it take their place.
  void AddLast(std::vector<PatchPart>& parts, PatchPoints& points, RunArea& result) const {
    const size_t count =
        std::min(parts.size(), PatchPoints::kMost / (fine_.size() + coarse_.size()));
    const std::vector<PatchPart> last(parts.end() - static_cast<std::ptrdiff_t>(count),
                                      parts.end());
    parts.resize(parts.size() - count);
    points.Clear();
    for (const PatchPart& part : last) points.Add(part.at, fine_);
    for (const PatchPart& part : last) points.Add(part.at, coarse_);
    points.Evaluate();
    points.SetLengths();
    const size_t fine_count = count * fine_.size();
    for (size_t n = 0; n < count; ++n) {
      const size_t fine = n * fine_.size(), coarse = fine_count + n * coarse_.size();
      const double area = points.AreaOf(fine, fine + fine_.size());
      const double error = std::abs(area - points.AreaOf(coarse, coarse + coarse_.size()));
      if (error <= 0.5 * tolerance_ * area + last[n].spare ||
          last[n].quarterings == kMostQuarterings) {
        result.area += area;
        result.error += error;
        continue;
      }
      points.LeaveOut(fine, fine + fine_.size());
      AppendQuarters(last[n], parts);
    }
    if (!result.sums.empty()) points.SumAreaForces(fine_count, is_weighted_, result.sums);
  }

  const bool is_weighted_;
  const PatchRuns runs_;
  const double tolerance_;
  const std::vector<TriangleRulePoint> coarse_, fine_;
  AreaEstimate estimate_;
  SurfaceArea result_;
};

}  // namespace

absl::StatusOr<SurfaceArea> MeasureArea(const DeformPlan& plan,
                                        std::span<const Vec3d> control_points, double tolerance,
                                        bool with_gradient, StopCheck stop, CpuArena* arena) {
  return AreaSum(plan, control_points, tolerance, with_gradient).Run(stop, arena);
}

}  // namespace latticed
