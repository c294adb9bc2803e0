// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/weights/vertex_weights.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed {

namespace {

absl::Status CheckChange(const SetWeights& change, size_t vertices, std::string_view field) {
  const bool of_all = change.indices.empty();
  const size_t wanted = of_all ? vertices : change.indices.size();
  if (change.values.size() != wanted && wanted != 0) {
    return error::InvalidField(
        fmt::format("{}.values", field),
        fmt::format("there are {} for {} vertices", change.values.size(), wanted));
  }
  for (size_t n = 0; n < change.values.size(); ++n) {
    if (change.values[n] >= 0 && change.values[n] <= 1) continue;  // false for NaN
    return error::InvalidField(
        fmt::format("{}.values", field),
        fmt::format("number {} is {}; weights are from 0 to 1", n, change.values[n]),
        "OUT_OF_RANGE");
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<VertexWeights> Changed(const VertexWeights& weights, const SetWeights& change,
                                      size_t vertices, std::string_view field) {
  if (change.indices.empty() && change.values.empty()) return VertexWeights();
  LATTICED_RETURN_IF_ERROR(CheckChange(change, vertices, field));
  if (change.indices.empty()) return std::make_shared<const std::vector<float>>(change.values);
  std::vector<float> changed;
  if (weights != nullptr) changed = *weights;
  const size_t highest = std::ranges::max(change.indices);
  if (vertices != 0 && highest >= vertices) {
    return error::OutOfRange(fmt::format("{}.some.indices", field), static_cast<double>(highest), 0,
                             static_cast<double>(vertices - 1));
  }
  changed.resize(std::max({changed.size(), vertices, highest + 1}), 1.0f);
  std::vector<bool> named(changed.size());
  for (size_t n = 0; n < change.indices.size(); ++n) {
    const uint32_t vertex = change.indices[n];
    if (named[vertex]) {
      return error::InvalidField(fmt::format("{}.some.indices", field),
                                 fmt::format("{} is named twice", vertex));
    }
    named[vertex] = true;
    changed[vertex] = change.values[n];
  }
  return std::make_shared<const std::vector<float>>(std::move(changed));
}

bool SameWeights(const VertexWeights& a, const VertexWeights& b) {
  if (a == nullptr || b == nullptr) return a == b;
  return a == b || *a == *b;
}

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
  // By the length. The direction across a lower triangle is one of rounding errors.
  constexpr double kLeastHeight = 1e-9;
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
  if (!(height > kLeastHeight * length)) return {};
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
