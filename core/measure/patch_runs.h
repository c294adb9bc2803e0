// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The patches of a plan in runs, for measures patch by patch. All patches of a run are in one knot box of each lattice, so
// on a run each lattice is one polynomial, or nothing. Sums of runs are added in their order: a measure has the same bits
// on any number of threads.
//
// Units    world units, relative to origin()
// Errors   ForRuns: what `stop` returns
// Threads  immutable
#ifndef LATTICED_CORE_MEASURE_PATCH_RUNS_H_
#define LATTICED_CORE_MEASURE_PATCH_RUNS_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/base/status_macros.h"
#include "core/base/stop_check.h"
#include "core/base/vec.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/points/box_map.h"
#include "core/view/cpu_arena.h"

namespace latticed {

// A triangle at rest, with the derivatives of all by its barycentrics s and t.
struct RestTriangle {
  Vec3d corner, s, t;
  double weight = 1, weight_s = 0, weight_t = 0;

  // A similar triangle, with its corner at barycentrics u, v.
  RestTriangle Part(double u, double v, double scale) const {
    return {
        corner + u * s + v * t, scale * s,       scale * t, weight + u * weight_s + v * weight_t,
        scale * weight_s,       scale * weight_t};
  }
  double Area() const { return 0.5 * Norm(Cross(s, t)); }
  // Whether no lattice moves it.
  bool Rests() const { return weight == 0 && weight_s == 0 && weight_t == 0; }
};

// A lattice on a run.
struct RunLattice {
  const BoxMaps* boxes = nullptr;
  size_t box = 0;
  size_t first_point = 0;  // of its control points, among those of the plan
  LocalMap map;
  BoxPolynomial polynomial;

  // Adds what the sums over points of the run are for the plan's control points, to add(number of the control point).
  template <class Add>
  void AddTransposed(const BoxNumbers& sums, const Add& add) const {
    boxes->AddTransposed(box, sums, [&](size_t i) -> Vec3d& { return add(first_point + i); });
  }
};

inline constexpr size_t kPatchesPerRun = 64;  // at most

class PatchRuns {
 public:
  // Keeps references to both. The origin is a point of the surface.
  PatchRuns(const DeformPlan& plan, std::span<const Vec3d> control_points);

  Vec3d origin() const { return origin_; }
  size_t size() const { return begins_.size() - 1; }
  std::span<const uint32_t> patches(size_t run) const {
    return std::span(order_).subspan(begins_[run], begins_[run + 1] - begins_[run]);
  }
  // Those that reach the run.
  [[nodiscard]] std::vector<RunLattice> LatticesOf(size_t run) const;
  [[nodiscard]] RestTriangle TriangleOf(size_t patch) const;

 private:
  KnotSpans SpansOf(size_t lattice, size_t patch) const;

  const DeformPlan& plan_;
  const std::span<const Vec3d> control_points_;
  const Vec3d origin_;
  std::vector<BoxMaps> boxes_;   // by lattice; the plan's own is the first
  std::vector<uint32_t> order_;  // of patches
  std::vector<size_t> begins_;   // of runs in it, and the end
};

// Results that are kept until they are added.
inline constexpr size_t kRunsPerThread = 8;

// result = body(run) for all runs, on the threads of `arena`, or on the caller's alone if it is null; then add(result), in
// the order of runs. `stop` is called on the caller's thread, once in so many runs of a thread.
template <class Body, class Add>
absl::Status ForRuns(const PatchRuns& runs, CpuArena* arena, StopCheck stop, const Body& body,
                     const Add& add, size_t runs_per_thread = kRunsPerThread) {
  const size_t together = runs_per_thread * (arena != nullptr ? arena->threads() : 1);
  for (size_t first = 0; first < runs.size(); first += together) {
    LATTICED_RETURN_IF_ERROR(stop());
    std::vector<decltype(body(first))> results(std::min(together, runs.size() - first));
    const auto run = [&](size_t i) { results[i] = body(first + i); };
    if (arena != nullptr) {
      arena->ForEach(results.size(), run);
    } else {
      for (size_t i = 0; i < results.size(); ++i) run(i);
    }
    for (auto& result : results) add(result);
  }
  return absl::OkStatus();
}

}  // namespace latticed

#endif  // LATTICED_CORE_MEASURE_PATCH_RUNS_H_
