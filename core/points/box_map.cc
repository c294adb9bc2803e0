// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/points/box_map.h"

namespace latticed {
namespace {

using Row = std::array<double, 3>;

Vec3d ToVec(const double* c) { return {c[0], c[1], c[2]}; }

}  // namespace

BoxMaps::BoxMaps(const LatticeStructure& structure) : structure_(structure) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<size_t>(axis);
    const std::vector<double>& knots = structure_.knots[a];
    const int degree = structure_.degree[a];
    place_of_span_[a].resize(knots.size());
    for (int k = degree; k < structure_.size[a]; ++k) {
      const double low = knots[static_cast<size_t>(k)], high = knots[static_cast<size_t>(k) + 1];
      if (!(high > low)) continue;
      place_of_span_[a][static_cast<size_t>(k)] = spans_[a].size();
      spans_[a].push_back({k, 0.5 * (low + high), high - low, MakeSpanBasis(knots, degree, k)});
    }
    domain_begin_[axis] = structure_.domain_begin(axis);
  }
  const FrameMap map(structure_);
  const std::array<Vec3d, 3> columns{map.DirectionToParameter({1, 0, 0}),
                                     map.DirectionToParameter({0, 1, 0}),
                                     map.DirectionToParameter({0, 0, 1})};
  for (int a = 0; a < 3; ++a) {
    parameter_by_world_[static_cast<size_t>(a)] = {columns[0][a], columns[1][a], columns[2][a]};
  }
}

size_t BoxMaps::BoxOf(const std::array<int, 3>& span) const {
  std::array<size_t, 3> place{};
  for (size_t a = 0; a < 3; ++a) place[a] = place_of_span_[a][static_cast<size_t>(span[a])];
  return place[0] + spans_[0].size() * (place[1] + spans_[1].size() * place[2]);
}

std::array<const BoxMaps::Axis*, 3> BoxMaps::AxesOf(size_t box) const {
  const size_t u = spans_[0].size(), v = spans_[1].size();
  return {&spans_[0][box % u], &spans_[1][box / u % v], &spans_[2][box / u / v]};
}

size_t BoxMaps::FirstPoint(const std::array<const Axis*, 3>& axes) const {
  return static_cast<size_t>(structure_.Index(axes[0]->span - structure_.degree[0],
                                              axes[1]->span - structure_.degree[1],
                                              axes[2]->span - structure_.degree[2]));
}

LocalMap BoxMaps::MapOf(size_t box) const {
  const auto axes = AxesOf(box);
  LocalMap map{.frame_origin = structure_.frame.origin};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<size_t>(axis);
    map.scale[a] = parameter_by_world_[a] / axes[a]->width;
    map.offset[axis] = (domain_begin_[axis] - axes[a]->centre) / axes[a]->width;
  }
  return map;
}

BoxPolynomial BoxMaps::Contract(size_t box, std::span<const Vec3d> points, Vec3d origin) const {
  const auto axes = AxesOf(box);
  const size_t first = FirstPoint(axes);
  const auto nu = static_cast<size_t>(structure_.degree[0]),
             nv = static_cast<size_t>(structure_.degree[1]),
             nw = static_cast<size_t>(structure_.degree[2]);
  const auto row = static_cast<size_t>(structure_.size[0]),
             layer = row * static_cast<size_t>(structure_.size[1]);
  // w, then v, then u: each step replaces one index of the control points by a power.
  BoxPolynomial result{.origin = origin};
  double by_w[kPowers][kPowers][kPowers][3] = {}, by_v[kPowers][kPowers][kPowers][3] = {};
  for (size_t j = 0; j <= nv; ++j) {
    for (size_t i = 0; i <= nu; ++i) {
      for (size_t k = 0; k <= nw; ++k) {
        const Vec3d p = points[first + i + row * j + layer * k] - origin;
        for (size_t r = 0; r <= nw; ++r) {
          const double weight = axes[2]->basis[k][r];
          for (int c = 0; c < 3; ++c) by_w[i][j][r][c] += weight * p[c];
        }
      }
      for (size_t q = 0; q <= nv; ++q) {
        const double weight = axes[1]->basis[j][q];
        for (size_t r = 0; r <= nw; ++r) {
          for (size_t c = 0; c < 3; ++c) by_v[i][q][r][c] += weight * by_w[i][j][r][c];
        }
      }
    }
  }
  for (size_t i = 0; i <= nu; ++i) {
    for (size_t p = 0; p <= nu; ++p) {
      const double weight = axes[0]->basis[i][p];
      for (size_t q = 0; q <= nv; ++q) {
        for (size_t r = 0; r <= nw; ++r) {
          for (size_t c = 0; c < 3; ++c) {
            result.coefficients.at[p][q][r][c] += weight * by_v[i][q][r][c];
          }
        }
      }
    }
  }
  return result;
}

BoxPolynomial BoxMaps::PolynomialOf(size_t box, std::span<const Vec3d> control_points) const {
  return Contract(box, control_points, control_points[FirstPoint(AxesOf(box))]);
}

BoxPolynomial BoxMaps::VelocityOf(size_t box, std::span<const Vec3d> tangents) const {
  return Contract(box, tangents, {});
}

void BoxMaps::AddGradient(size_t box, const BoxNumbers& sums, std::span<Vec3d> gradient) const {
  const auto axes = AxesOf(box);
  const size_t first = FirstPoint(axes);
  const auto nu = static_cast<size_t>(structure_.degree[0]),
             nv = static_cast<size_t>(structure_.degree[1]),
             nw = static_cast<size_t>(structure_.degree[2]);
  const auto row = static_cast<size_t>(structure_.size[0]),
             layer = row * static_cast<size_t>(structure_.size[1]);
  for (size_t i = 0; i <= nu; ++i) {
    Row by_u[kPowers][kPowers] = {};
    for (size_t p = 0; p <= nu; ++p) {
      const double weight = axes[0]->basis[i][p];
      for (size_t q = 0; q <= nv; ++q) {
        for (size_t r = 0; r <= nw; ++r) {
          for (size_t c = 0; c < 3; ++c) by_u[q][r][c] += weight * sums.at[p][q][r][c];
        }
      }
    }
    for (size_t j = 0; j <= nv; ++j) {
      Row by_v[kPowers] = {};
      for (size_t q = 0; q <= nv; ++q) {
        const double weight = axes[1]->basis[j][q];
        for (size_t r = 0; r <= nw; ++r) {
          for (size_t c = 0; c < 3; ++c) by_v[r][c] += weight * by_u[q][r][c];
        }
      }
      for (size_t k = 0; k <= nw; ++k) {
        Vec3d& out = gradient[first + i + row * j + layer * k];
        for (size_t r = 0; r <= nw; ++r) out += axes[2]->basis[k][r] * ToVec(by_v[r].data());
      }
    }
  }
}

}  // namespace latticed
