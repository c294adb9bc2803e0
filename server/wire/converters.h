// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Messages of latticed.v1 <-> types of core. From… reads untrusted messages: sizes are checked
// before anything is allocated, and the result is valid. ToProto cannot fail.
//
// Errors   kInvalidArgument with the path of the field, which begins with the argument `field`;
//          reason UNSUPPORTED for an enum value that this server does not know
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_CONVERTERS_H_
#define LATTICED_SERVER_WIRE_CONVERTERS_H_

#include <span>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/bounds.h"
#include "core/base/vec.h"
#include "core/ffd/lattice.h"
#include "google/protobuf/message.h"
#include "google/protobuf/repeated_field.h"
#include "latticed/v1/common.pb.h"
#include "latticed/v1/lattice.pb.h"

namespace latticed {

// Whether the message has fields that this server does not know. In a message with only a oneof this is an
// alternative of a later version.
[[nodiscard]] bool HoldsUnknown(const google::protobuf::Message& message);

// Vectors. Finite, or NOT_FINITE.
[[nodiscard]] absl::StatusOr<Vec3d> FromProto(const v1::Vec3& v, std::string_view field);
// A point of the world, or a direction: each coordinate within ±limits::kMaxCoordinate, or OUT_OF_RANGE.
[[nodiscard]] absl::StatusOr<Vec3d> BoundedFromProto(const v1::Vec3& v, std::string_view field);
[[nodiscard]] v1::Vec3 ToProto(Vec3d v);
// For empty bounds callers leave the field unset.
[[nodiscard]] v1::Bounds ToProto(const Bounds& bounds);

// Flat x, y, z lists; at most `most` points.
[[nodiscard]] absl::StatusOr<std::vector<Vec3d>> PointsFromProto(
    const google::protobuf::RepeatedField<double>& flat, size_t most, std::string_view field);
void AppendPoints(std::span<const Vec3d> points, google::protobuf::RepeatedField<double>& flat);

// Lattices. Degree 2, size 4, clamped uniform knots and identity control points where unset. `mesh` has the points of the
// rest world that a linear continuation without widths reaches.
[[nodiscard]] absl::StatusOr<LatticeStructure> StructureFromProto(const v1::Lattice& lattice,
                                                                  std::string_view field,
                                                                  std::span<const Vec3d> mesh = {});
[[nodiscard]] absl::StatusOr<Lattice> FromProto(const v1::Lattice& lattice, std::string_view field,
                                                std::span<const Vec3d> mesh = {});
// Lattice or fit around the bounds of the mesh.
[[nodiscard]] absl::StatusOr<Lattice> FromProto(const v1::LatticeSource& source,
                                                const Bounds& mesh_bounds, std::string_view field,
                                                std::span<const Vec3d> mesh = {});
[[nodiscard]] v1::Lattice ToProto(const LatticeStructure& structure,
                                  std::span<const Vec3d> control_points);
[[nodiscard]] v1::Lattice ToProto(const Lattice& lattice);
[[nodiscard]] v1::LatticeSummary SummaryToProto(const LatticeStructure& structure);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_CONVERTERS_H_
