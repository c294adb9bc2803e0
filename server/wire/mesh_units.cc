// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/mesh_units.h"

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/wire/enum_table.h"

namespace latticed {
namespace {

constexpr auto kUpAxes =
    std::to_array<std::pair<v1::UpAxis, std::string_view>>({{v1::UP_AXIS_X, "x"},
                                                            {v1::UP_AXIS_Y, "y"},
                                                            {v1::UP_AXIS_Z, "z"},
                                                            {v1::UP_AXIS_UNSPECIFIED, ""}});

}  // namespace

absl::StatusOr<MeshUnits> MeshUnitsFromProto(const v1::MeshUnits& units, std::string_view path) {
  const std::string prefix(path);
  MeshUnits out;
  LATTICED_ASSIGN_OR_RETURN(out.up_axis, ReadEnum(kUpAxes, units.up_axis(), prefix + ".up_axis"));
  out.meters_per_unit = units.meters_per_unit();
  if (!std::isfinite(out.meters_per_unit)) return error::NotFinite(prefix + ".meters_per_unit");
  if (out.meters_per_unit < 0) {
    return error::OutOfRange(prefix + ".meters_per_unit", out.meters_per_unit, 0,
                             std::numeric_limits<double>::max());
  }
  return out;
}

v1::MeshUnits ToProto(const MeshUnits& units) {
  v1::MeshUnits out;
  out.set_up_axis(WriteEnum(kUpAxes, std::string_view(units.up_axis)));
  out.set_meters_per_unit(units.meters_per_unit);
  return out;
}

}  // namespace latticed
