// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/gemm/patch_sampler.h"

#include <array>

#include "core/base/limits.h"
#include "core/ffd/bspline_basis.h"

namespace latticed {
namespace {

constexpr size_t kMaxOrder = limits::kMaxDegree + 1;
using Basis = std::array<double, kMaxOrder>;

// The control points of one knot box, gathered so that a patch's samples read them from the cache.
struct BoxPoints {
  std::array<Vec3d, kMaxOrder * kMaxOrder * kMaxOrder> points;
  std::array<size_t, 3> order{};
};

BoxPoints Gather(const LatticeStructure& s, std::span<const Vec3d> control_points,
                 const std::array<int, 3>& span) {
  BoxPoints box;
  for (size_t a = 0; a < 3; ++a) box.order[a] = static_cast<size_t>(s.degree[a]) + 1;
  size_t next = 0;
  for (int k = span[2] - s.degree[2]; k <= span[2]; ++k) {
    for (int j = span[1] - s.degree[1]; j <= span[1]; ++j) {
      for (int i = span[0] - s.degree[0]; i <= span[0]; ++i) {
        box.points[next++] = control_points[static_cast<size_t>(s.Index(i, j, k))];
      }
    }
  }
  return box;
}

Vec3d Sum(const BoxPoints& box, const Basis& u, const Basis& v, const Basis& w) {
  Vec3d total;
  const Vec3d* p = box.points.data();
  for (size_t k = 0; k < box.order[2]; ++k) {
    Vec3d plane;
    for (size_t j = 0; j < box.order[1]; ++j) {
      Vec3d row;
      for (size_t i = 0; i < box.order[0]; ++i) row += u[i] * *p++;
      plane += v[j] * row;
    }
    total += w[k] * plane;
  }
  return total;
}

void Store(double* column, size_t stride, size_t row, Vec3d value) {
  for (int a = 0; a < 3; ++a) column[row + static_cast<size_t>(a) * stride] = value[a];
}

}  // namespace

PatchSampler::PatchSampler(const DeformPlan& plan, const StageMatrices& stage,
                           std::span<const Vec3d> control_points)
    : plan_(plan),
      stage_(stage),
      map_(plan.structure),
      control_points_(control_points.begin(), control_points.end()) {
  for (Vec3d& p : control_points_) p -= plan.local_origin;
}

Vec3d PatchSampler::Sample(size_t index, double* positions, double* by_normal, Vec3d facet_normal,
                           size_t stride) const {
  const Patch& patch = plan_.patches[index];
  if (patch.box == plan_.outside_box()) {
    SampleOutside(patch, positions, by_normal, facet_normal, stride);
  } else {
    SampleInside(patch, positions, by_normal, facet_normal, stride);
  }
  const size_t m = stage_.m;
  const std::array<size_t, 3> corners{0, m - 1 - static_cast<size_t>(stage_.degree), m - 1};
  Vec3d centre;
  for (int a = 0; a < 3; ++a) {
    double* column = positions + static_cast<size_t>(a) * stride;
    centre[a] = (column[corners[0]] + column[corners[1]] + column[corners[2]]) / 3.0;
    for (size_t i = 0; i < m; ++i) column[i] -= centre[a];
  }
  return centre;
}

void PatchSampler::SampleInside(const Patch& patch, double* positions, double* by_normal,
                                Vec3d facet_normal, size_t stride) const {
  const LatticeStructure& s = plan_.structure;
  const KnotBox& box = plan_.boxes[patch.box];
  const BoxPoints points = Gather(s, control_points_, box.span);
  std::array<Vec3d, 3> corner;
  for (size_t c = 0; c < 3; ++c) corner[c] = plan_.vertices[patch.vertex[c]].parameter;
  const Vec3d direction = map_.DirectionToParameter(facet_normal);
  const double over = 1.0 / stage_.degree;
  for (size_t i = 0; i < stage_.m; ++i) {
    const auto [t0, t1, t2] = stage_.samples[i];
    const Vec3d at = (t0 * over) * corner[0] + (t1 * over) * corner[1] + (t2 * over) * corner[2];
    std::array<Basis, 3> value{}, slope{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<size_t>(axis);
      EvaluateBasis(s.knots[a].data(), s.degree[a], box.span[a], at[axis], value[a].data());
      if (by_normal == nullptr) continue;
      EvaluateBasisDerivatives(s.knots[a].data(), s.degree[a], box.span[a], at[axis],
                               slope[a].data());
    }
    Store(positions, stride, i, Sum(points, value[0], value[1], value[2]));
    if (by_normal == nullptr) continue;
    Store(by_normal, stride, i,
          direction.x * Sum(points, slope[0], value[1], value[2]) +
              direction.y * Sum(points, value[0], slope[1], value[2]) +
              direction.z * Sum(points, value[0], value[1], slope[2]));
  }
}

void PatchSampler::SampleOutside(const Patch& patch, double* positions, double* by_normal,
                                 Vec3d facet_normal, size_t stride) const {
  std::array<Vec3d, 3> corner;
  for (size_t c = 0; c < 3; ++c) {
    corner[c] = plan_.vertices[patch.vertex[c]].world - plan_.local_origin;
  }
  const double over = 1.0 / stage_.degree;
  for (size_t i = 0; i < stage_.m; ++i) {
    const auto [t0, t1, t2] = stage_.samples[i];
    Store(positions, stride, i,
          (t0 * over) * corner[0] + (t1 * over) * corner[1] + (t2 * over) * corner[2]);
    if (by_normal != nullptr) Store(by_normal, stride, i, facet_normal);
  }
}

}  // namespace latticed
