// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/patches/lattice_from_proto.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/edit/lattice_edit.h"
#include "core/ffd/outside/outside_rules.h"

namespace latticed::client {
namespace {

std::array<int, 3> AxesOf(const v1::LatticeAxes& axes) { return {axes.u(), axes.v(), axes.w()}; }

std::span<const double> SpanOf(const google::protobuf::RepeatedField<double>& numbers) {
  return {numbers.data(), static_cast<size_t>(numbers.size())};
}

absl::StatusOr<std::array<double, 6>> SidesOf(
    const google::protobuf::RepeatedField<double>& numbers) {
  std::array<double, 6> sides{};
  if (numbers.size() == 1) sides.fill(numbers[0]);
  if (numbers.size() <= 1) return sides;
  if (numbers.size() != static_cast<int>(sides.size())) {
    return error::InvalidField("lattice.outside", "must have six numbers of each kind, or one");
  }
  std::copy(numbers.begin(), numbers.end(), sides.begin());
  return sides;
}

absl::StatusOr<Outside> OutsideFromProto(const v1::LatticeOutside& proto) {
  Outside outside;
  if (proto.mode() <= v1::OUTSIDE_MODE_FIXED) return outside;
  const bool falls_off = proto.mode() == v1::OUTSIDE_MODE_FALLOFF;
  if (!falls_off && proto.mode() != v1::OUTSIDE_MODE_LINEAR) {
    return error::InvalidField("lattice.outside.mode", "is not known to this client");
  }
  outside.mode = falls_off ? OutsideMode::kFalloff : OutsideMode::kLinear;
  outside.smooth = proto.continuity() != v1::OUTSIDE_CONTINUITY_C0;
  LATTICED_ASSIGN_OR_RETURN(outside.widths, SidesOf(proto.widths()));
  LATTICED_ASSIGN_OR_RETURN(outside.steps, SidesOf(proto.steps()));
  return outside;
}

}  // namespace

Vec3d FromProto(const v1::Vec3& proto) { return {proto.x(), proto.y(), proto.z()}; }

absl::StatusOr<Lattice> FromProto(const v1::Lattice& proto, std::span<const Vec3d> mesh) {
  if (!proto.has_frame()) return error::InvalidField("lattice.frame", "is required");
  Lattice lattice;
  LatticeStructure& s = lattice.structure;
  if (proto.has_degree()) s.degree = AxesOf(proto.degree());
  if (proto.has_size()) s.size = AxesOf(proto.size());
  s.knots = {KnotsOrDefault(SpanOf(proto.knots_u()), s.degree[0], s.size[0]),
             KnotsOrDefault(SpanOf(proto.knots_v()), s.degree[1], s.size[1]),
             KnotsOrDefault(SpanOf(proto.knots_w()), s.degree[2], s.size[2])};
  const v1::LatticeFrame& frame = proto.frame();
  s.frame = {FromProto(frame.origin()),
             {FromProto(frame.u()), FromProto(frame.v()), FromProto(frame.w())}};
  LATTICED_RETURN_IF_ERROR(Validate(s));
  LATTICED_ASSIGN_OR_RETURN(s.outside, OutsideFromProto(proto.outside()));
  s.outside = ResolvedOutside(s, mesh);
  LATTICED_ASSIGN_OR_RETURN(lattice.control_points,
                            PointsFromFlat(SpanOf(proto.control_points()),
                                           limits::kMaxControlPoints, "lattice.control_points"));
  if (lattice.control_points.empty()) lattice.control_points = IdentityControlPoints(s);
  LATTICED_RETURN_IF_ERROR(Validate(lattice));
  return lattice;
}

absl::StatusOr<Lattice> EffectiveLattice(const v1::LatticeState& state) {
  LATTICED_ASSIGN_OR_RETURN(Lattice lattice, FromProto(state.lattice()));
  if (!state.has_strength() || state.strength() == 1) return lattice;
  LATTICED_RETURN_IF_ERROR(CheckStrength(state.strength(), "strength"));
  const std::vector<Vec3d> rest = IdentityControlPoints(lattice.structure);
  for (size_t i = 0; i < rest.size(); ++i) {
    lattice.control_points[i] = rest[i] + state.strength() * (lattice.control_points[i] - rest[i]);
  }
  return lattice;
}

}  // namespace latticed::client
