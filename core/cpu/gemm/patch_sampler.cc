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

void Set(double* column, size_t stride, size_t row, Vec3d value) {
  for (int a = 0; a < 3; ++a) column[row + static_cast<size_t>(a) * stride] = value[a];
}
void Add(double* column, size_t stride, size_t row, Vec3d value) {
  for (int a = 0; a < 3; ++a) column[row + static_cast<size_t>(a) * stride] += value[a];
}
void WeighRow(double* column, size_t stride, size_t row, Vec3d rest, double weight) {
  for (int a = 0; a < 3; ++a) {
    double& value = column[row + static_cast<size_t>(a) * stride];
    value = rest[a] + weight * (value - rest[a]);
  }
}

std::vector<Vec3d> Relative(std::span<const Vec3d> points, Vec3d origin) {
  std::vector<Vec3d> relative(points.begin(), points.end());
  for (Vec3d& p : relative) p -= origin;
  return relative;
}

}  // namespace

PatchSampler::PatchSampler(const DeformPlan& plan, const StageMatrices& stage,
                           std::span<const Vec3d> control_points)
    : plan_(plan),
      stage_(stage),
      control_points_(Relative(control_points, plan.local_origin)),
      own_{plan.structure, FrameMap(plan.structure), control_points_} {
  for (const TurnedLattice& lattice : plan.turned) {
    turned_.push_back({lattice.structure, FrameMap(lattice.structure),
                       std::span(control_points_).subspan(lattice.first_point)});
  }
}

Vec3d PatchSampler::Sample(size_t index, double* positions, double* by_normal, Vec3d facet_normal,
                           size_t stride) const {
  const Patch& patch = plan_.patches[index];
  const Columns out{positions, by_normal, stride};
  Corners rest, parameters;
  for (size_t c = 0; c < 3; ++c) {
    const PlanVertex& vertex = plan_.vertices[patch.vertex[c]];
    rest[c] = vertex.world - plan_.local_origin;
    parameters[c] = vertex.parameter;
  }
  if (patch.box == plan_.outside_box()) {
    SampleOutside(rest, facet_normal, out);
  } else {
    SampleVolume(own_, plan_.boxes[patch.box].span, parameters, nullptr, facet_normal, out);
  }
  for (size_t g = 0; g < turned_.size(); ++g) {
    const TurnedLattice& lattice = plan_.turned[g];
    if (lattice.spans[index] == kNoSpans) continue;
    for (size_t c = 0; c < 3; ++c) parameters[c] = lattice.parameters[patch.vertex[c]];
    SampleVolume(turned_[g], lattice.spans[index], parameters, &rest, facet_normal, out);
  }
  if (plan_.is_weighted()) WeighSamples(index, rest, facet_normal, out);
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

template <typename T>
T PatchSampler::At(size_t sample, const std::array<T, 3>& corners) const {
  const auto [t0, t1, t2] = stage_.samples[sample];
  const double over = 1.0 / stage_.degree;
  return (t0 * over) * corners[0] + (t1 * over) * corners[1] + (t2 * over) * corners[2];
}

void PatchSampler::SampleVolume(const Volume& volume, const std::array<int, 3>& span,
                                const Corners& parameters, const Corners* rest, Vec3d facet_normal,
                                const Columns& out) const {
  const LatticeStructure& s = volume.structure;
  const BoxPoints points = Gather(s, volume.control_points, span);
  const Vec3d direction = volume.map.DirectionToParameter(facet_normal);
  for (size_t i = 0; i < stage_.m; ++i) {
    const Vec3d at = At(i, parameters);
    std::array<Basis, 3> value{}, slope{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<size_t>(axis);
      EvaluateBasis(s.knots[a].data(), s.degree[a], span[a], at[axis], value[a].data());
      if (out.by_normal == nullptr) continue;
      EvaluateBasisDerivatives(s.knots[a].data(), s.degree[a], span[a], at[axis], slope[a].data());
    }
    const Vec3d position = Sum(points, value[0], value[1], value[2]);
    if (rest == nullptr) {
      Set(out.positions, out.stride, i, position);
    } else {
      Add(out.positions, out.stride, i, position - At(i, *rest));
    }
    if (out.by_normal == nullptr) continue;
    const Vec3d by_normal = direction.x * Sum(points, slope[0], value[1], value[2]) +
                            direction.y * Sum(points, value[0], slope[1], value[2]) +
                            direction.z * Sum(points, value[0], value[1], slope[2]);
    if (rest == nullptr) {
      Set(out.by_normal, out.stride, i, by_normal);
    } else {
      Add(out.by_normal, out.stride, i, by_normal - facet_normal);
    }
  }
}

void PatchSampler::SampleOutside(const Corners& rest, Vec3d facet_normal,
                                 const Columns& out) const {
  for (size_t i = 0; i < stage_.m; ++i) {
    Set(out.positions, out.stride, i, At(i, rest));
    if (out.by_normal != nullptr) Set(out.by_normal, out.stride, i, facet_normal);
  }
}

void PatchSampler::WeighSamples(size_t patch, const Corners& rest, Vec3d facet_normal,
                                const Columns& out) const {
  const std::array<double, 3> corners = plan_.CornerWeights(patch);
  for (size_t i = 0; i < stage_.m; ++i) {
    const double weight = At(i, corners);
    WeighRow(out.positions, out.stride, i, At(i, rest), weight);
    if (out.by_normal != nullptr) WeighRow(out.by_normal, out.stride, i, facet_normal, weight);
  }
}

}  // namespace latticed
