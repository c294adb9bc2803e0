// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/lattice_definition.h"

#include <cmath>
#include <utility>

#include "core/ffd/bspline_basis.h"
#include "core/ffd/plan/knot_split.h"

namespace latticed::testing {
namespace {

// A function of the distance y from a face is value * f + slope * f', with the f and f' of the face. Derivatives are by y.
struct Beyond {
  double value = 0, slope = 0;
  double value_by_y = 0, slope_by_y = 0;
};

Beyond LinearBeyond(double y) { return {1, y, 0, 1}; }

// c (W - y)^n + b (S - y)^n; the second term is 0 beyond the step.
Beyond FalloffBeyond(int n, bool smooth, double w, double s, double y, bool beyond_step) {
  double c_value = 0, c_slope = 0, b_value = 0, b_slope = 0;
  if (smooth && n > 1) {
    const double det = std::pow(w, n - 1) * std::pow(s, n - 1) * (w - s);
    c_value = std::pow(s, n - 1) / det;
    c_slope = std::pow(s, n) / n / det;
    b_value = -std::pow(w, n - 1) / det;
    b_slope = -std::pow(w, n) / n / det;
  } else {
    const double part = s / (n * w);
    const double left = 1 - part * part * (3 - 2 * part);
    c_value = left / ((w - s) * std::pow(w, n - 1));
    b_value = (1 - c_value * std::pow(w, n)) / std::pow(s, n);
  }
  const double outer = std::pow(w - y, n), outer_by_y = -n * std::pow(w - y, n - 1);
  const double inner = beyond_step ? 0 : std::pow(s - y, n);
  const double inner_by_y = beyond_step ? 0 : -n * std::pow(s - y, n - 1);
  return {c_value * outer + b_value * inner, c_slope * outer + b_slope * inner,
          c_value * outer_by_y + b_value * inner_by_y, c_slope * outer_by_y + b_slope * inner_by_y};
}

}  // namespace

LatticeDefinition::LatticeDefinition(LatticeStructure structure, std::vector<Vec3d> control_points,
                                     double strength)
    : structure_(std::move(structure)),
      displacements_(std::move(control_points)),
      map_(structure_),
      parameter_by_world_(ParameterByWorld(structure_)) {
  const std::vector<Vec3d> rest = IdentityControlPoints(structure_);
  for (size_t i = 0; i < rest.size(); ++i) {
    displacements_[i] = strength * (displacements_[i] - rest[i]);
  }
}

LatticeDefinition::AxisBasis LatticeDefinition::BasisBeyond(size_t axis, bool at_end,
                                                            double distance, double within) const {
  const LatticeStructure& s = structure_;
  const int n = s.degree[axis];
  const auto a = static_cast<int>(axis);
  const double range = s.domain_end(a) - s.domain_begin(a), snap = kPlaneSnap * range;
  const double w = s.outside.widths[SideOf(axis, at_end)] * range;
  const double step = s.outside.steps[SideOf(axis, at_end)] * range;
  // In a plane the lower piece counts: further out at the begin, nearer at the end.
  const double last = at_end ? snap : -snap;
  if (w == 0 || within > w + last) return {};
  const Beyond beyond =
      s.outside.mode == OutsideMode::kLinear
          ? LinearBeyond(distance)
          : FalloffBeyond(n, s.outside.smooth, w, step, distance, within > step + last);
  const double face = at_end ? s.domain_end(a) : s.domain_begin(a), outwards = at_end ? 1 : -1;
  const int span = FindLowerSpan(s.knots[axis].data(), n, s.size[axis], face);
  AxisBasis basis{.first = span - n, .count = n + 1, .value = {}, .slope = {}};
  std::array<double, 4> f{}, f_slope{};
  EvaluateBasis(s.knots[axis].data(), n, span, face, f.data());
  EvaluateBasisDerivatives(s.knots[axis].data(), n, span, face, f_slope.data());
  for (size_t i = 0; i <= static_cast<size_t>(n); ++i) {
    const double out = outwards * f_slope[i];
    basis.value[i] = beyond.value * f[i] + beyond.slope * out;
    basis.slope[i] = outwards * (beyond.value_by_y * f[i] + beyond.slope_by_y * out);
  }
  return basis;
}

LatticeDefinition::AxisBasis LatticeDefinition::BasisAt(size_t axis, double parameter,
                                                        double within) const {
  const LatticeStructure& s = structure_;
  const int n = s.degree[axis];
  const auto a = static_cast<int>(axis);
  const double begin = s.domain_begin(a), end = s.domain_end(a);
  const double snap = kPlaneSnap * (end - begin);
  const bool goes_on = s.outside.widths[SideOf(axis, false)] != 0;
  if (within <= (goes_on ? begin + snap : begin - snap)) {
    return BasisBeyond(axis, false, begin - parameter, begin - within);
  }
  if (within > end + snap) return BasisBeyond(axis, true, parameter - end, within - end);
  const int span = FindLowerSpan(s.knots[axis].data(), n, s.size[axis], within - snap);
  AxisBasis basis{.first = span - n, .count = n + 1, .value = {}, .slope = {}};
  EvaluateBasis(s.knots[axis].data(), n, span, parameter, basis.value.data());
  EvaluateBasisDerivatives(s.knots[axis].data(), n, span, parameter, basis.slope.data());
  return basis;
}

void LatticeDefinition::AddTo(DeformedPoint& point, Vec3d x, Vec3d within) const {
  const Vec3d at = map_.ToParameter(x), piece = map_.ToParameter(within);
  std::array<AxisBasis, 3> basis;
  for (size_t a = 0; a < 3; ++a) {
    basis[a] = BasisAt(a, at[static_cast<int>(a)], piece[static_cast<int>(a)]);
    if (basis[a].count == 0) return;
  }
  const auto& [u, v, w] = basis;
  std::array<Vec3d, 3> by_parameter;
  for (int k = 0; k < w.count; ++k) {
    for (int j = 0; j < v.count; ++j) {
      for (int i = 0; i < u.count; ++i) {
        const auto index =
            static_cast<size_t>(structure_.Index(u.first + i, v.first + j, w.first + k));
        const auto of = [&](const auto& a, const auto& b, const auto& c) {
          return a[static_cast<size_t>(i)] * b[static_cast<size_t>(j)] * c[static_cast<size_t>(k)];
        };
        const Vec3d d = displacements_[index];
        point.position += of(u.value, v.value, w.value) * d;
        by_parameter[0] += of(u.slope, v.value, w.value) * d;
        by_parameter[1] += of(u.value, v.slope, w.value) * d;
        by_parameter[2] += of(u.value, v.value, w.slope) * d;
      }
    }
  }
  std::array<Vec3d, 3> by_world;
  WorldJacobian(by_parameter.data(), parameter_by_world_.data(), by_world.data());
  for (size_t c = 0; c < 3; ++c) point.jacobian[c] += by_world[c];
}

DeformedPoint SumAt(std::span<const LatticeDefinition> lattices, Vec3d x, Vec3d within) {
  DeformedPoint point{.position = x};
  for (const LatticeDefinition& lattice : lattices) lattice.AddTo(point, x, within);
  return point;
}

}  // namespace latticed::testing
