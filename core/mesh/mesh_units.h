// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The axis and unit of a mesh's coordinates, as its uploader gave them; for a GLB, glTF prescribes the rest. Only the
// root node of an exported GLB is computed from them.
#ifndef LATTICED_CORE_MESH_MESH_UNITS_H_
#define LATTICED_CORE_MESH_MESH_UNITS_H_

#include <string>

#include "fmt/format.h"

namespace latticed {

struct MeshUnits {
  std::string up_axis;         // "x", "y", "z"; empty: unknown
  double meters_per_unit = 0;  // 0: unknown

  bool known() const { return !up_axis.empty() || meters_per_unit > 0; }
};

// Sets the unknown parts to those of a GLB: +y and metres (glTF 2.0, section 3.4, "Coordinate System and Units").
[[nodiscard]] inline MeshUnits WithGltfDefaults(MeshUnits units) {
  if (units.up_axis.empty()) units.up_axis = "y";
  if (units.meters_per_unit == 0) units.meters_per_unit = 1;
  return units;
}

// The known parts of "up +z, 0.01 m per unit"; short enough for the header of an STL file.
[[nodiscard]] inline std::string Describe(const MeshUnits& units) {
  std::string text;
  if (!units.up_axis.empty()) text = "up +" + units.up_axis;
  if (units.meters_per_unit > 0) {
    text += fmt::format("{}{} m per unit", text.empty() ? "" : ", ", units.meters_per_unit);
  }
  return text;
}

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_MESH_UNITS_H_
