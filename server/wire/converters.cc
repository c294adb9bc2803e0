// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/converters.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/outside/outside_rules.h"
#include "fmt/format.h"
#include "google/protobuf/unknown_field_set.h"
#include "server/wire/outside_converters.h"

namespace latticed {
namespace {

std::span<const double> SpanOf(const google::protobuf::RepeatedField<double>& numbers) {
  return {numbers.data(), static_cast<size_t>(numbers.size())};
}

std::array<int, 3> AxesOr(bool set, const v1::LatticeAxes& axes, std::array<int, 3> unset) {
  return set ? std::array<int, 3>{axes.u(), axes.v(), axes.w()} : unset;
}

void SetAxes(const std::array<int, 3>& from, v1::LatticeAxes& axes) {
  axes.set_u(from[0]);
  axes.set_v(from[1]);
  axes.set_w(from[2]);
}

// Replaces the beginning of the field's path in an error: core's paths begin with "lattice" or "fit", but clients
// need the path in their request.
absl::Status Reroot(const absl::Status& status, std::string_view from, std::string_view to) {
  error::Details details = error::DetailsOf(status);
  std::string message(status.message().data(), status.message().size());
  if (from == to || !details.field.starts_with(from) || !message.starts_with(from)) return status;
  details.field.replace(0, from.size(), to);
  message.replace(0, from.size(), to);
  return error::WithDetails(absl::Status(status.code(), message), details);
}

// Sets what goes on outside, filled in. The rest of the structure must be valid.
absl::Status SetOutside(const v1::LatticeOutside& outside, std::string_view field,
                        std::span<const Vec3d> mesh, LatticeStructure& s) {
  LATTICED_ASSIGN_OR_RETURN(s.outside, FromProto(outside, fmt::format("{}.outside", field)));
  s.outside = ResolvedOutside(s, mesh);
  return Reroot(ValidateOutside(s), "lattice", field);
}

absl::StatusOr<Lattice> FromFit(const v1::LatticeFit& fit, const Bounds& mesh,
                                std::string_view field) {
  const LatticeStructure unset;
  auto lattice = FitLattice(mesh, AxesOr(fit.has_size(), fit.size(), unset.size),
                            AxesOr(fit.has_degree(), fit.degree(), unset.degree),
                            fit.has_padding() ? fit.padding() : kDefaultPadding);
  if (!lattice.ok()) return Reroot(lattice.status(), "fit", field);
  if (!fit.has_outside()) return lattice;
  LATTICED_RETURN_IF_ERROR(CheckHasWidths(fit.outside(), fmt::format("{}.outside", field)));
  LATTICED_RETURN_IF_ERROR(SetOutside(fit.outside(), field, {}, lattice->structure));
  return lattice;
}

}  // namespace

bool HoldsUnknown(const google::protobuf::Message& message) {
  return !message.GetReflection()->GetUnknownFields(message).empty();
}

absl::StatusOr<Vec3d> FromProto(const v1::Vec3& v, std::string_view field) {
  const Vec3d result{v.x(), v.y(), v.z()};
  if (!IsFinite(result)) return error::NotFinite(field);
  return result;
}

absl::StatusOr<Vec3d> BoundedFromProto(const v1::Vec3& v, std::string_view field) {
  LATTICED_ASSIGN_OR_RETURN(const auto result, FromProto(v, field));
  for (int axis = 0; axis < 3; ++axis) {
    LATTICED_RETURN_IF_ERROR(
        error::CheckRange(field, result[axis], -limits::kMaxCoordinate, limits::kMaxCoordinate));
  }
  return result;
}

v1::Vec3 ToProto(Vec3d v) {
  v1::Vec3 result;
  result.set_x(v.x);
  result.set_y(v.y);
  result.set_z(v.z);
  return result;
}

v1::Bounds ToProto(const Bounds& bounds) {
  v1::Bounds result;
  if (bounds.empty()) return result;
  *result.mutable_min() = ToProto(bounds.min);
  *result.mutable_max() = ToProto(bounds.max);
  return result;
}

absl::StatusOr<std::vector<Vec3d>> PointsFromProto(
    const google::protobuf::RepeatedField<double>& flat, size_t most, std::string_view field) {
  return PointsFromFlat(SpanOf(flat), most, field);
}

void AppendPoints(std::span<const Vec3d> points, google::protobuf::RepeatedField<double>& flat) {
  flat.Reserve(flat.size() + static_cast<int>(3 * points.size()));
  for (const Vec3d& p : points) {
    flat.Add(p.x);
    flat.Add(p.y);
    flat.Add(p.z);
  }
}

absl::StatusOr<LatticeStructure> StructureFromProto(const v1::Lattice& lattice,
                                                    std::string_view field,
                                                    std::span<const Vec3d> mesh) {
  if (!lattice.has_frame()) {
    return error::InvalidField(fmt::format("{}.frame", field), "is required");
  }
  LatticeStructure s;
  s.degree = AxesOr(lattice.has_degree(), lattice.degree(), s.degree);
  s.size = AxesOr(lattice.has_size(), lattice.size(), s.size);
  s.knots = {KnotsOrDefault(SpanOf(lattice.knots_u()), s.degree[0], s.size[0]),
             KnotsOrDefault(SpanOf(lattice.knots_v()), s.degree[1], s.size[1]),
             KnotsOrDefault(SpanOf(lattice.knots_w()), s.degree[2], s.size[2])};
  const v1::LatticeFrame& frame = lattice.frame();
  s.frame.origin = {frame.origin().x(), frame.origin().y(), frame.origin().z()};
  s.frame.edges = {Vec3d{frame.u().x(), frame.u().y(), frame.u().z()},
                   Vec3d{frame.v().x(), frame.v().y(), frame.v().z()},
                   Vec3d{frame.w().x(), frame.w().y(), frame.w().z()}};
  if (auto status = Validate(s); !status.ok()) return Reroot(status, "lattice", field);
  if (!lattice.has_outside()) return s;
  LATTICED_RETURN_IF_ERROR(SetOutside(lattice.outside(), field, mesh, s));
  return s;
}

absl::StatusOr<Lattice> FromProto(const v1::Lattice& lattice, std::string_view field,
                                  std::span<const Vec3d> mesh) {
  LATTICED_ASSIGN_OR_RETURN(auto structure, StructureFromProto(lattice, field, mesh));
  Lattice result{.structure = std::move(structure), .control_points = {}};
  if (lattice.control_points().empty()) {
    result.control_points = IdentityControlPoints(result.structure);
  } else {
    LATTICED_ASSIGN_OR_RETURN(result.control_points,
                              PointsFromProto(lattice.control_points(), limits::kMaxControlPoints,
                                              fmt::format("{}.control_points", field)));
  }
  if (auto status = Validate(result); !status.ok()) return Reroot(status, "lattice", field);
  return result;
}

absl::StatusOr<Lattice> FromProto(const v1::LatticeSource& source, const Bounds& mesh_bounds,
                                  std::string_view field, std::span<const Vec3d> mesh) {
  if (source.has_lattice()) {
    return FromProto(source.lattice(), fmt::format("{}.lattice", field), mesh);
  }
  if (!source.has_fit() && HoldsUnknown(source)) {
    return error::Unsupported(field, "this kind of source");
  }
  return FromFit(source.fit(), mesh_bounds, fmt::format("{}.fit", field));
}

v1::Lattice ToProto(const LatticeStructure& s, std::span<const Vec3d> control_points) {
  v1::Lattice result;
  const v1::LatticeSummary summary = SummaryToProto(s);
  *result.mutable_frame() = summary.frame();
  *result.mutable_degree() = summary.degree();
  *result.mutable_size() = summary.size();
  result.mutable_knots_u()->Add(s.knots[0].begin(), s.knots[0].end());
  result.mutable_knots_v()->Add(s.knots[1].begin(), s.knots[1].end());
  result.mutable_knots_w()->Add(s.knots[2].begin(), s.knots[2].end());
  AppendPoints(control_points, *result.mutable_control_points());
  if (s.outside != Outside{}) *result.mutable_outside() = summary.outside();
  return result;
}

v1::Lattice ToProto(const Lattice& lattice) {
  return ToProto(lattice.structure, lattice.control_points);
}

v1::LatticeSummary SummaryToProto(const LatticeStructure& s) {
  v1::LatticeSummary result;
  *result.mutable_frame()->mutable_origin() = ToProto(s.frame.origin);
  *result.mutable_frame()->mutable_u() = ToProto(s.frame.edges[0]);
  *result.mutable_frame()->mutable_v() = ToProto(s.frame.edges[1]);
  *result.mutable_frame()->mutable_w() = ToProto(s.frame.edges[2]);
  SetAxes(s.degree, *result.mutable_degree());
  SetAxes(s.size, *result.mutable_size());
  if (s.outside != Outside{}) *result.mutable_outside() = ToProto(s.outside);
  return result;
}

}  // namespace latticed
