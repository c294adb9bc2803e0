// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/enclosed_volume.h"

#include <utility>

#include "core/base/status_macros.h"
#include "core/ffd/box/box_contraction.h"
#include "core/measure/box_integral_kernel.h"
#include "core/measure/patch_integrals.h"
#include "core/measure/weighted_volume.h"

namespace latticed {
namespace {

using box_integral::ForTerms;
using box_integral::Narrow;
using box_integral::NarrowTerm;
using box_integral::Wide;
using box_integral::WideTerm;

// A knot box under its control points.
class BoxMeasure {
 public:
  BoxMeasure(const SurfaceMoments& moments, size_t n, std::span<const Vec3d> control_points,
             Vec3d origin)
      : contraction_(moments.contraction(n)),
        moments_{{moments.table(n, 0), moments.table(n, 1), moments.table(n, 2)},
                 moments.extent()} {
    const LatticeStructure& structure = moments.plan().structure;
    for (size_t a = 0; a < 3; ++a) degree_[a] = static_cast<size_t>(structure.degree[a]);
    const BoxNumbers numbers = contraction_.Contract(control_points, origin);
    ForTerms(degree_, [&](size_t a, size_t b, size_t c) {
      for (size_t k = 0; k < 3; ++k) polynomial_[k][NarrowTerm(a, b, c)] = numbers.at[a][b][c][k];
    });
    box_integral::MultiplySlopes(polynomial_, degree_, cross_);
  }

  // Integrals of l^c (n dA)_k for the powers c up to `times` the degree, into sums[k].
  void Integrate(size_t times, std::array<Wide, 3>& sums) const {
    box_integral::SumMoments(
        cross_, box_integral::CrossPowers(degree_), moments_,
        {times * degree_[0] + 1, times * degree_[1] + 1, times * degree_[2] + 1}, sums);
  }

  // From the integrals of l^c f, those of N_i f for each control point i, which are added to add(i).
  template <typename Add>
  void AddToPoints(const std::array<Wide, 3>& sums, const Add& add) const {
    BoxNumbers numbers;
    ForTerms(degree_, [&](size_t a, size_t b, size_t c) {
      for (size_t k = 0; k < 3; ++k) numbers.at[a][b][c][k] = sums[k][WideTerm(a, b, c)];
    });
    contraction_.AddTransposed(numbers, add);
  }
  // The same for N_i x_j f, with x the deformed point.
  template <typename Add>
  void AddToPoints(const std::array<Wide, 3>& sums, size_t j, const Add& add) const {
    BoxNumbers numbers;
    ForTerms(degree_, [&](size_t a, size_t b, size_t c) {
      const Vec3d product = Multiplied(sums, j, a, b, c);
      for (int k = 0; k < 3; ++k) numbers.at[a][b][c][k] = product[k];
    });
    contraction_.AddTransposed(numbers, add);
  }

 private:
  // The integral of l^(a, b, c) x_j f.
  Vec3d Multiplied(const std::array<Wide, 3>& sums, size_t j, size_t a, size_t b, size_t c) const {
    Vec3d product;
    for (size_t p = 0; p <= degree_[0]; ++p) {
      for (size_t q = 0; q <= degree_[1]; ++q) {
        const size_t row = WideTerm(a + p, b + q, c);
        for (size_t r = 0; r <= degree_[2]; ++r) {
          product += polynomial_[j][NarrowTerm(p, q, r)] *
                     Vec3d{sums[0][row + r], sums[1][row + r], sums[2][row + r]};
        }
      }
    }
    return product;
  }

  const BoxContraction contraction_;
  const box_integral::Moments moments_;
  std::array<size_t, 3> degree_{};
  std::array<Narrow, 3> polynomial_{};
  box_integral::CrossProducts cross_{};
};

// The sums lose the fewest digits about a point near the surface. Where pieces lie outside the frame, their sums have the
// plan's origin.
Vec3d OriginFor(const DeformPlan& plan, std::span<const Vec3d> control_points) {
  if (plan.outside_patches > 0) return plan.local_origin;
  const Vec3d first = control_points.front();
  Vec3d sum;
  for (const Vec3d p : control_points) sum += p - first;
  return first + sum / static_cast<double>(control_points.size());
}

// 1/3 integral x . n dA, from the gradient.
double VolumeOf(const SurfaceMoments& moments, std::span<const Vec3d> control_points, Vec3d origin,
                std::span<const Vec3d> gradient) {
  double sum = moments.outside_volume();
  for (size_t i = 0; i < gradient.size(); ++i) sum += Dot(control_points[i] - origin, gradient[i]);
  return sum / 3;
}

// dC_j/dP_i from the derivatives of S and V; the centroid is relative to the origin of both.
std::vector<std::array<Vec3d, 3>> CentroidGradient(const EnclosedVolume& volume, Vec3d centroid,
                                                   std::span<const std::array<Vec3d, 3>> first) {
  std::vector<std::array<Vec3d, 3>> gradient(first.size());
  for (size_t i = 0; i < first.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      for (int j = 0; j < 3; ++j) {
        gradient[i][static_cast<size_t>(k)][j] =
            (first[i][static_cast<size_t>(j)][k] - centroid[j] * volume.gradient[i][k]) /
            volume.volume;
      }
    }
  }
  return gradient;
}

}  // namespace

EnclosedVolume MeasureVolume(const SurfaceMoments& moments, std::span<const Vec3d> control_points,
                             CpuArena* arena) {
  if (moments.has_weights()) return MeasureWeightedVolume(moments, control_points);
  if (moments.is_by_patches()) {
    return *MeasureVolumeByPatches(moments.plan(), control_points, NeverStop, arena);
  }
  EnclosedVolume result{.gradient = std::vector<Vec3d>(control_points.size())};
  const Vec3d origin = OriginFor(moments.plan(), control_points);
  std::array<Wide, 3> sums;
  for (size_t n = 0; n < moments.boxes().size(); ++n) {
    const BoxMeasure box(moments, n, control_points, origin);
    box.Integrate(1, sums);
    box.AddToPoints(sums, [&](size_t i) -> Vec3d& { return result.gradient[i]; });
  }
  result.volume = VolumeOf(moments, control_points, origin, result.gradient);
  return result;
}

EnclosedCentroid MeasureCentroid(const SurfaceMoments& moments,
                                 std::span<const Vec3d> control_points) {
  const size_t count = control_points.size();
  EnclosedCentroid result{.volume = {.gradient = std::vector<Vec3d>(count)}};
  std::vector<std::array<Vec3d, 3>> first(count);  // [j][k] = dS_j / d coordinate k
  const Vec3d origin = OriginFor(moments.plan(), control_points);
  std::array<Wide, 3> sums;
  for (size_t n = 0; n < moments.boxes().size(); ++n) {
    const BoxMeasure box(moments, n, control_points, origin);
    box.Integrate(2, sums);
    box.AddToPoints(sums, [&](size_t i) -> Vec3d& { return result.volume.gradient[i]; });
    for (size_t j = 0; j < 3; ++j) {
      box.AddToPoints(sums, j, [&](size_t i) -> Vec3d& { return first[i][j]; });
    }
  }
  const double volume = VolumeOf(moments, control_points, origin, result.volume.gradient);
  result.volume.volume = volume;
  Vec3d moment = moments.outside_centroid();
  for (size_t i = 0; i < count; ++i) {
    for (int j = 0; j < 3; ++j) {
      moment[j] += Dot(control_points[i] - origin, first[i][static_cast<size_t>(j)]);
    }
  }
  const Vec3d centroid = moment / (4 * volume);  // relative to the origin
  result.centroid = origin + centroid;
  result.gradient = CentroidGradient(result.volume, centroid, first);
  return result;
}

absl::StatusOr<EnclosedVolume> MeasureVolumeByPatches(const DeformPlan& plan,
                                                      std::span<const Vec3d> control_points,
                                                      StopCheck stop, CpuArena* arena,
                                                      bool with_gradient) {
  LATTICED_ASSIGN_OR_RETURN(
      auto sums, IntegratePatches(plan, control_points, false, stop, arena, with_gradient));
  return EnclosedVolume{sums.volume, std::move(sums.volume_gradient)};
}

absl::StatusOr<EnclosedCentroid> MeasureCentroidByPatches(const DeformPlan& plan,
                                                          std::span<const Vec3d> control_points,
                                                          StopCheck stop, CpuArena* arena,
                                                          bool with_gradient) {
  LATTICED_ASSIGN_OR_RETURN(
      auto sums, IntegratePatches(plan, control_points, true, stop, arena, with_gradient));
  EnclosedCentroid result{.volume = {sums.volume, std::move(sums.volume_gradient)}};
  const Vec3d centroid = sums.moment / sums.volume;
  result.centroid = sums.origin + centroid;
  result.gradient = CentroidGradient(result.volume, centroid, sums.moment_gradient);
  return result;
}

}  // namespace latticed
