// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/tensor/tensor_surfaces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/status_macros.h"
#include "core/ffd/direct_ffd.h"

namespace latticed::bench {
namespace {

using Row = std::array<double, kTensorOrder>;
using Matrix = std::array<Row, kTensorOrder>;

double Bernstein(int index, double x) {
  double binomial = 1;
  for (int k = 0; k < index; ++k) binomial = binomial * (kTensorDegree - k) / (k + 1);
  return binomial * std::pow(x, index) * std::pow(1 - x, kTensorDegree - index);
}

// Gauss-Jordan. The Bernstein matrix of distinct parameters is totally positive, so it needs no pivots.
Matrix Inverse(Matrix a) {
  Matrix inverse{};
  for (size_t i = 0; i < kTensorOrder; ++i) inverse[i][i] = 1;
  for (size_t c = 0; c < kTensorOrder; ++c) {
    const double scale = 1 / a[c][c];
    for (size_t k = 0; k < kTensorOrder; ++k) {
      a[c][k] *= scale;
      inverse[c][k] *= scale;
    }
    for (size_t r = 0; r < kTensorOrder; ++r) {
      const double factor = r == c ? 0 : a[r][c];
      for (size_t k = 0; k < kTensorOrder; ++k) {
        a[r][k] -= factor * a[c][k];
        inverse[r][k] -= factor * inverse[c][k];
      }
    }
  }
  return inverse;
}

void AddPoints(const TrimmedGrid& grid, uint32_t surface, TensorSurfaces& to) {
  double t = -1;  // less than any point's t
  for (const TrimmedPoint& point : grid.points) {
    if (point.t != t) to.lines.push_back({static_cast<float>(point.t), surface});
    t = point.t;
    to.points.push_back({static_cast<float>(point.s), static_cast<uint32_t>(to.lines.size() - 1)});
  }
}

size_t MostLines(const std::vector<TensorSurface>& surfaces) {
  const size_t last = surfaces.size() - 1;
  uint32_t most = 0;
  for (size_t i = 0; i < last; i += kTensorGroup) {
    const size_t end = std::min(i + kTensorGroup, last);
    most = std::max(most, surfaces[end].first_line - surfaces[i].first_line);
  }
  return most;
}

}  // namespace

ParameterRectangle RectangleOf(const DeformPlan& plan, const SubPolygon& polygon, Vec3d normal) {
  std::vector<Vec3d> corners;
  for (const uint32_t vertex : polygon.corners) corners.push_back(plan.vertices[vertex].world);
  return SmallestRectangle(corners, normal);
}

absl::StatusOr<TensorSurfaces> MakeTensorSurfaces(const DeformPlan& plan) {
  if (plan.structure.patch_degree() != kTensorDegree) {
    return absl::UnimplementedError("the comparator supports only degree 6");
  }
  LATTICED_ASSIGN_OR_RETURN(auto polygons, FindSubPolygons(plan));
  TensorSurfaces result{.polygons = std::move(polygons)};
  const FrameMap map(plan.structure);
  const DirectFfd rest(plan, plan.identity_points);
  for (const SubPolygon& polygon : result.polygons) {
    const ParameterRectangle rectangle =
        RectangleOf(plan, polygon, rest.RestFacetNormal(polygon.patches.front()));
    const auto& span = plan.boxes[plan.patches[polygon.patches.front()].box].span;
    result.surfaces.push_back({.span = {span[0], span[1], span[2]},
                               .first_line = static_cast<uint32_t>(result.lines.size()),
                               .first_point = static_cast<uint32_t>(result.points.size()),
                               .corner = map.ToParameter(rectangle.corner),
                               .along = map.DirectionToParameter(rectangle.along),
                               .across = map.DirectionToParameter(rectangle.across)});
    const TrimmedGrid grid = TrimGrid(rectangle.polygon, kTensorSegments);
    AddPoints(grid, static_cast<uint32_t>(result.surfaces.size() - 1), result);
    result.triangles += grid.triangles.size();
  }
  result.surfaces.push_back({.first_line = static_cast<uint32_t>(result.lines.size()),
                             .first_point = static_cast<uint32_t>(result.points.size())});
  result.most_lines = MostLines(result.surfaces);
  return result;
}

TensorInverse MakeTensorInverse() {
  Matrix samples{};
  for (int i = 0; i < kTensorOrder; ++i) {
    for (int a = 0; a < kTensorOrder; ++a) {
      samples[static_cast<size_t>(i)][static_cast<size_t>(a)] =
          Bernstein(a, double{1} * i / kTensorDegree);
    }
  }
  const Matrix inverse = Inverse(samples);
  TensorInverse result{};
  for (size_t i = 0; i < kTensorOrder; ++i) {
    for (size_t a = 0; a < kTensorOrder; ++a) {
      result.entry[i][a] = static_cast<float>(inverse[i][a]);
    }
  }
  return result;
}

}  // namespace latticed::bench
