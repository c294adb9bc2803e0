// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_SERVER_WIRE_MESH_UNITS_H_
#define LATTICED_SERVER_WIRE_MESH_UNITS_H_

#include <string_view>

#include "absl/status/statusor.h"
#include "core/mesh/mesh_units.h"
#include "latticed/v1/mesh.pb.h"

namespace latticed {

// Errors name the field, which begins with `path`: UNSUPPORTED, NOT_FINITE, OUT_OF_RANGE.
[[nodiscard]] absl::StatusOr<MeshUnits> MeshUnitsFromProto(const v1::MeshUnits& units,
                                                           std::string_view path);

[[nodiscard]] v1::MeshUnits ToProto(const MeshUnits& units);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_MESH_UNITS_H_
