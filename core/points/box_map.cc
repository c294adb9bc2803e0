// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/points/box_map.h"

namespace latticed {
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

BoxContraction BoxMaps::ContractionOf(size_t box) const {
  const auto axes = AxesOf(box);
  return {structure_,
          {axes[0]->span, axes[1]->span, axes[2]->span},
          {&axes[0]->basis, &axes[1]->basis, &axes[2]->basis}};
}

BoxPolynomial BoxMaps::PolynomialOf(size_t box, std::span<const Vec3d> control_points) const {
  const BoxContraction contraction = ContractionOf(box);
  const Vec3d origin = control_points[contraction.first()];
  return {origin, contraction.Contract(control_points, origin)};
}

BoxPolynomial BoxMaps::VelocityOf(size_t box, std::span<const Vec3d> tangents) const {
  return {{}, ContractionOf(box).Contract(tangents, {})};
}

void BoxMaps::AddGradient(size_t box, const BoxNumbers& sums, std::span<Vec3d> gradient) const {
  ContractionOf(box).AddTransposed(sums, [&](size_t i) -> Vec3d& { return gradient[i]; });
}

}  // namespace latticed
