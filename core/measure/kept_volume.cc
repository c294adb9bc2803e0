// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/kept_volume.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/measure/enclosed_volume.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// A surface on which these points have less influence cannot be moved by them: they lie beside it, and what is left of
// their basis functions is rounding.
constexpr double kNoInfluence = 1e-9;  // of all points'

std::vector<bool> FreePoints(const DeformPlan& plan, const PointFreedom* freedom,
                             const OutsideMap* outside, size_t count) {
  std::vector<bool> free(count, true);
  const auto hold = [&](size_t index) {
    if (outside == nullptr) {
      free[index] = false;
    } else {
      outside->ForSources(index, [&](size_t source, double) { free[source] = false; });
    }
  };
  for (const Seam& seam : plan.seams) {
    if (seam.rests) continue;
    for (int k = seam.first[2]; k <= seam.last[2]; ++k) {
      for (int j = seam.first[1]; j <= seam.last[1]; ++j) {
        for (int i = seam.first[0]; i <= seam.last[0]; ++i) {
          hold(static_cast<size_t>(plan.structure.Index(i, j, k)));
        }
      }
    }
  }
  if (freedom == nullptr) return free;
  for (size_t n = 0; n < free.size(); ++n) {
    if (freedom->is_held(n)) free[n] = false;
    if (freedom->is_mirrored() && !free[n]) free[freedom->ImageOf(n)] = false;
  }
  return free;
}

double DotOf(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  double sum = 0;
  for (size_t n = 0; n < a.size(); ++n) sum += Dot(a[n], b[n]);
  return sum;
}

class Solver {
 public:
  Solver(const SurfaceMoments& moments, double volume, std::optional<Vec3d> direction,
         const PointFreedom* freedom, const OutsideMap* outside, CpuArena* arena)
      : moments_(moments),
        volume_(volume),
        direction_(direction),
        freedom_(freedom),
        outside_(outside),
        arena_(arena) {}

  EnclosedVolume Measure(const std::vector<Vec3d>& points) const {
    if (outside_ == nullptr) return MeasureVolume(moments_, points, arena_);
    EnclosedVolume volume = MeasureVolume(moments_, outside_->Continue(points), arena_);
    volume.gradient = outside_->ApplyTransposed(volume.gradient);
    return volume;
  }

  // Moves the free points; returns the number of steps, or nothing where they cannot restore the volume.
  std::optional<int> Run(const std::vector<bool>& free, std::vector<Vec3d>& points) const {
    std::vector<Vec3d> moved = points, move(points.size());
    for (int step = 0;; ++step) {
      EnclosedVolume now = Measure(moved);
      if (std::abs(now.volume - volume_) <= kVolumeTolerance * std::abs(volume_)) {
        points = std::move(moved);
        return step;
      }
      if (step == kMostVolumeSteps) return std::nullopt;
      const double all = DotOf(now.gradient, now.gradient);
      const std::vector<Vec3d> along = Restrict(std::move(now.gradient), free);
      const double squared = DotOf(along, along);
      if (!(squared > kNoInfluence * kNoInfluence * all)) return std::nullopt;
      const double share = (volume_ - now.volume + DotOf(along, move)) / squared;
      for (size_t n = 0; n < points.size(); ++n) {
        move[n] = share * along[n];
        if (free[n]) moved[n] = points[n] + move[n];
      }
    }
  }

 private:
  std::vector<Vec3d> Restrict(std::vector<Vec3d> gradient, const std::vector<bool>& free) const {
    for (size_t n = 0; n < gradient.size(); ++n) {
      if (!free[n]) gradient[n] = {};
    }
    if (freedom_ != nullptr && freedom_->is_mirrored()) freedom_->SymmetriseMoves(gradient);
    if (direction_.has_value()) {
      for (Vec3d& g : gradient) g = Dot(g, *direction_) * *direction_;
    }
    return gradient;
  }

  const SurfaceMoments& moments_;
  const double volume_;
  const std::optional<Vec3d> direction_;
  const PointFreedom* const freedom_;
  const OutsideMap* const outside_;
  CpuArena* const arena_;
};

absl::Status NotKept(double volume, double wanted) {
  return error::FailedPrecondition(
      "VOLUME_NOT_KEPT",
      fmt::format("the free control points cannot restore the volume {} from {} in {} steps",
                  wanted, volume, kMostVolumeSteps));
}

}  // namespace

double RestVolume(const SurfaceMoments& moments, CpuArena* arena) {
  return MeasureVolume(moments, moments.plan().identity_points, arena).volume;
}

absl::StatusOr<int> KeepVolume(const SurfaceMoments& moments, const KeptVolume& kept,
                               const PointFreedom* freedom, const std::vector<bool>& named,
                               std::vector<Vec3d>& control_points, const OutsideMap* outside,
                               CpuArena* arena) {
  const double volume = kept.volume.has_value() ? *kept.volume : RestVolume(moments, arena);
  std::optional<Vec3d> direction;
  if (kept.axis.has_value()) {
    const LatticeStructure& edited =
        outside != nullptr ? outside->structure() : moments.plan().structure;
    const Vec3d edge = edited.frame.edges[static_cast<size_t>(*kept.axis)];
    direction = edge / Norm(edge);
  }
  const Solver solver(moments, volume, direction, freedom, outside, arena);
  const std::vector<bool> free =
      FreePoints(moments.plan(), freedom, outside, control_points.size());
  std::vector<bool> others = free;
  for (size_t n = 0; n < others.size(); ++n) {
    if (!named[n]) continue;
    others[n] = false;
    if (freedom != nullptr && freedom->is_mirrored()) others[freedom->ImageOf(n)] = false;
  }
  if (const auto steps = solver.Run(others, control_points)) return *steps;
  if (const auto steps = solver.Run(free, control_points)) return *steps;
  return NotKept(solver.Measure(control_points).volume, volume);
}

}  // namespace latticed
