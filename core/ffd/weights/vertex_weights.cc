// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/weights/vertex_weights.h"

#include "core/base/error.h"
#include "fmt/format.h"

namespace latticed {

absl::Status CheckVertexWeights(const PolygonMesh& mesh, std::span<const float> weights) {
  if (weights.size() != mesh.positions.size()) {
    return error::InvalidField("weights", fmt::format("there are {} for a mesh of {} vertices",
                                                      weights.size(), mesh.positions.size()));
  }
  for (size_t v = 0; v < weights.size(); ++v) {
    if (weights[v] >= 0 && weights[v] <= 1) continue;  // false for NaN
    return error::InvalidField(
        "weights",
        fmt::format("the weight of vertex {} is {}; weights are from 0 to 1", v, weights[v]));
  }
  return absl::OkStatus();
}

// The part along the longest side follows from that side alone, and the other part is perpendicular to it. Thus a thin
// triangle's large gradient across does not disturb the small one along.
Vec3d WeightGradient(const std::array<Vec3d, 3>& corners, const std::array<double, 3>& weights) {
  const auto side = [&](size_t c) { return corners[(c + 1) % 3] - corners[c]; };
  size_t first = 0;
  for (size_t c = 1; c < 3; ++c) {
    if (Norm(side(c)) > Norm(side(first))) first = c;
  }
  const size_t second = (first + 1) % 3, third = (first + 2) % 3;
  const double length = Norm(side(first));
  if (!(length > 0)) return {};
  const Vec3d along = side(first) / length, other = corners[third] - corners[first];
  const Vec3d normal = Cross(along, other);
  if (!(Norm(normal) > 0)) return {};
  const Vec3d across = Cross(normal / Norm(normal), along);
  const double height = Dot(other, across);
  if (!(height > 0)) return {};
  const double slope = (weights[second] - weights[first]) / length;
  const double rise = weights[third] - weights[first] - Dot(other, along) * slope;
  return slope * along + (rise / height) * across;
}

void Weigh(Vec3d rest, double weight, Vec3d gradient, Vec3d& position,
           std::array<Vec3d, 3>& jacobian) {
  const Vec3d offset = position - rest;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3d& column = jacobian[static_cast<size_t>(axis)];
    Vec3d unit;
    unit[axis] = 1;
    column = unit + weight * (column - unit) + gradient[axis] * offset;
  }
  position = rest + weight * offset;
}

}  // namespace latticed
