// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/lattice.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/control_point_range.h"
#include "core/ffd/outside/outside_map.h"
#include "core/ffd/outside/outside_rules.h"
#include "fmt/format.h"

namespace latticed {
namespace {

constexpr std::array<std::string_view, 3> kAxis{"u", "v", "w"};

// `of` is the first part of field names: "lattice" or "fit".
absl::Status ValidateSizes(const LatticeStructure& s, std::string_view of) {
  int64_t count = 1;
  for (size_t a = 0; a < 3; ++a) {
    LATTICED_RETURN_IF_ERROR(error::CheckRange(fmt::format("{}.degree.{}", of, kAxis[a]),
                                               s.degree[a], limits::kMinDegree,
                                               limits::kMaxDegree));
    LATTICED_RETURN_IF_ERROR(error::CheckRange(fmt::format("{}.size.{}", of, kAxis[a]), s.size[a],
                                               s.degree[a] + 1, limits::kMaxControlPoints));
    count *= s.size[a];
  }
  return error::CheckRange(fmt::format("{}.size", of), static_cast<double>(count), 8,
                           limits::kMaxControlPoints);
}

absl::Status ValidateKnots(const std::vector<double>& knots, int degree, int size,
                           std::string_view axis) {
  const std::string field = fmt::format("lattice.knots_{}", axis);
  const auto expected = static_cast<size_t>(size + degree + 1);
  if (knots.size() != expected) {
    return error::InvalidField(field, fmt::format("got {} knots, size + degree + 1 = {} are needed",
                                                  knots.size(), expected));
  }
  if (!std::all_of(knots.begin(), knots.end(), [](double k) { return std::isfinite(k); })) {
    return error::NotFinite(field);
  }
  if (!std::is_sorted(knots.begin(), knots.end())) {
    return error::InvalidField(field, "knots must not decrease");
  }
  const auto d = static_cast<size_t>(degree);
  const double begin = knots[d], end = knots[static_cast<size_t>(size)];
  if (!(begin < end)) {
    return error::InvalidField(
        field, fmt::format("the domain [knot {}, knot {}] must not be empty", degree, size));
  }
  for (size_t i = 0; i < knots.size();) {
    size_t j = i;
    while (j < knots.size() && knots[j] == knots[i]) ++j;
    const bool interior = knots[i] > begin && knots[i] < end;
    const size_t most = interior ? d : d + 1;
    if (j - i > most) {
      return error::InvalidField(
          field,
          fmt::format("knot {} has multiplicity {}, at most {} is allowed", knots[i], j - i, most));
    }
    i = j;
  }
  return absl::OkStatus();
}

absl::Status ValidateFrame(const LatticeFrame& frame) {
  LATTICED_RETURN_IF_ERROR(CheckControlPoint(frame.origin, "lattice.frame.origin"));
  double product = 1;
  for (size_t a = 0; a < 3; ++a) {
    LATTICED_RETURN_IF_ERROR(
        CheckControlPoint(frame.edges[a], fmt::format("lattice.frame.{}", kAxis[a])));
    product *= Norm(frame.edges[a]);
  }
  const double volume = std::abs(Dot(Cross(frame.edges[0], frame.edges[1]), frame.edges[2]));
  // Below this ratio the inverse has no correct digit left for the 2^-40 snapping of vertices.
  constexpr double kSmallestVolumeRatio = 1e-9;
  if (!(volume > kSmallestVolumeRatio * product) || !std::isfinite(1.0 / volume)) {
    return error::InvalidField("lattice.frame", "the three edge vectors must span a volume",
                               "SINGULAR_FRAME");
  }
  return absl::OkStatus();
}

}  // namespace

std::vector<double> ClampedUniformKnots(int degree, int size) {
  std::vector<double> knots(static_cast<size_t>(size + degree + 1));
  for (int i = 0; i < size + degree + 1; ++i) {
    knots[static_cast<size_t>(i)] = std::clamp(i - degree, 0, size - degree);
  }
  return knots;
}

std::vector<double> KnotsOrDefault(std::span<const double> given, int degree, int size) {
  if (!given.empty()) return {given.begin(), given.end()};
  const bool legal = degree >= limits::kMinDegree && degree <= limits::kMaxDegree &&
                     size > degree && size <= limits::kMaxControlPoints;
  return legal ? ClampedUniformKnots(degree, size) : std::vector<double>{};
}

absl::StatusOr<std::vector<Vec3d>> PointsFromFlat(std::span<const double> flat, size_t most,
                                                  std::string_view field) {
  if (flat.size() % 3 != 0) {
    return error::InvalidField(
        field, fmt::format("got {} numbers, x y z per point are needed", flat.size()));
  }
  const size_t count = flat.size() / 3;
  if (count > most) {
    return error::OutOfRange(field, static_cast<double>(count), 0, static_cast<double>(most));
  }
  std::vector<Vec3d> points;
  points.reserve(count);
  for (size_t i = 0; i < flat.size(); i += 3) {
    points.push_back({flat[i], flat[i + 1], flat[i + 2]});
    if (!IsFinite(points.back())) return error::NotFinite(field);
  }
  return points;
}

absl::Status Validate(const LatticeStructure& s) {
  LATTICED_RETURN_IF_ERROR(ValidateSizes(s, "lattice"));
  for (size_t a = 0; a < 3; ++a) {
    LATTICED_RETURN_IF_ERROR(ValidateKnots(s.knots[a], s.degree[a], s.size[a], kAxis[a]));
  }
  LATTICED_RETURN_IF_ERROR(ValidateFrame(s.frame));
  return ValidateOutside(s);
}

absl::Status Validate(const Lattice& lattice) {
  LATTICED_RETURN_IF_ERROR(Validate(lattice.structure));
  const auto expected = static_cast<size_t>(lattice.structure.control_point_count());
  if (lattice.control_points.size() != expected) {
    return error::InvalidField("lattice.control_points",
                               fmt::format("got {} points, size u * v * w = {} are needed",
                                           lattice.control_points.size(), expected));
  }
  for (const Vec3d p : lattice.control_points) {
    LATTICED_RETURN_IF_ERROR(CheckControlPoint(p, "lattice.control_points"));
  }
  if (lattice.structure.outside == Outside{}) return absl::OkStatus();
  for (const Vec3d p : OutsideMap(lattice.structure).Continue(lattice.control_points)) {
    LATTICED_RETURN_IF_ERROR(CheckControlPoint(p, "lattice.outside"));
  }
  return absl::OkStatus();
}

std::vector<Vec3d> IdentityControlPoints(const LatticeStructure& s) {
  std::array<std::vector<double>, 3> greville;
  for (size_t a = 0; a < 3; ++a) {
    const auto d = static_cast<size_t>(s.degree[a]);
    greville[a].resize(static_cast<size_t>(s.size[a]));
    for (size_t i = 0; i < greville[a].size(); ++i) {
      double sum = 0;
      for (size_t k = 1; k <= d; ++k) sum += s.knots[a][i + k];
      greville[a][i] = sum / static_cast<double>(d);
    }
  }
  const FrameMap map(s);
  std::vector<Vec3d> points;
  points.reserve(static_cast<size_t>(s.control_point_count()));
  for (double w : greville[2]) {
    for (double v : greville[1]) {
      for (double u : greville[0]) points.push_back(map.ToWorld({u, v, w}));
    }
  }
  return points;
}

absl::StatusOr<Lattice> FitLattice(const Bounds& bounds, std::array<int, 3> size,
                                   std::array<int, 3> degree, double padding) {
  if (!std::isfinite(padding)) return error::NotFinite("fit.padding");
  constexpr double kMostPadding = 100;
  LATTICED_RETURN_IF_ERROR(error::CheckRange("fit.padding", padding, 0, kMostPadding));
  const Vec3d extent = bounds.extent();
  const double longest = std::max({extent.x, extent.y, extent.z});
  // A single point has no longest edge: padding then counts in world units.
  const double margin = padding * (longest > 0 ? longest : 1.0);
  const Vec3d pad{margin, margin, margin};
  const Vec3d edge = extent + 2.0 * pad;
  if (!(edge.x > 0 && edge.y > 0 && edge.z > 0)) {
    return error::InvalidField("fit.padding", "a flat mesh needs a padding above 0");
  }
  Lattice lattice;
  LatticeStructure& s = lattice.structure;
  s.degree = degree;
  s.size = size;
  s.frame = {bounds.min - pad, {Vec3d{edge.x, 0, 0}, Vec3d{0, edge.y, 0}, Vec3d{0, 0, edge.z}}};
  LATTICED_RETURN_IF_ERROR(ValidateSizes(s, "fit"));
  for (size_t a = 0; a < 3; ++a) s.knots[a] = ClampedUniformKnots(degree[a], size[a]);
  // Only the frame can still be invalid: a flat mesh with a tiny padding makes it too flat.
  if (auto status = Validate(s); !status.ok()) {
    return error::InvalidField("fit.padding",
                               "makes a frame without volume; a larger one is needed",
                               error::DetailsOf(status).reason);
  }
  lattice.control_points = IdentityControlPoints(s);
  return lattice;
}

FrameMap::FrameMap(const LatticeStructure& s) : origin_(s.frame.origin) {
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<size_t>(a);
    begin_[a] = s.domain_begin(a);
    columns_[i] = s.frame.edges[i] / (s.domain_end(a) - s.domain_begin(a));
  }
  const double det = Dot(Cross(columns_[0], columns_[1]), columns_[2]);
  for (size_t a = 0; a < 3; ++a) {
    rows_[a] = Cross(columns_[(a + 1) % 3], columns_[(a + 2) % 3]) / det;
  }
}

Vec3d FrameMap::ToParameter(Vec3d world) const {
  return begin_ + DirectionToParameter(world - origin_);
}
Vec3d FrameMap::ToWorld(Vec3d parameter) const {
  const Vec3d p = parameter - begin_;
  return origin_ + p.x * columns_[0] + p.y * columns_[1] + p.z * columns_[2];
}
Vec3d FrameMap::DirectionToParameter(Vec3d d) const {
  return {Dot(rows_[0], d), Dot(rows_[1], d), Dot(rows_[2], d)};
}

}  // namespace latticed
