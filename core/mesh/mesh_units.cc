// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/mesh_units.h"

#include "fmt/format.h"

namespace latticed {

std::string Describe(const MeshUnits& units) {
  std::string text;
  if (!units.up_axis.empty()) text = "up +" + units.up_axis;
  if (units.meters_per_unit > 0) {
    text += fmt::format("{}{} m per unit", text.empty() ? "" : ", ", units.meters_per_unit);
  }
  return text;
}

}  // namespace latticed
