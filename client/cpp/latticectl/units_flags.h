// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Options that say what the numbers of a mesh file mean: --up-axis z --meters-per-unit 0.001. Not
// given, not known.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_UNITS_FLAGS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_UNITS_FLAGS_H_

#include <string>

#include "latticed/v1/mesh.pb.h"

namespace CLI {
class App;
}

namespace latticed::client {

struct UnitsFlags {
  std::string up_axis;  // x, y, z
  double meters_per_unit = 0;
};

void AddUnitsFlags(CLI::App& command, UnitsFlags& flags);
[[nodiscard]] v1::MeshUnits ToProto(const UnitsFlags& flags);

// "x", "y", "z"; empty for an unknown one.
[[nodiscard]] std::string UpAxisName(v1::UpAxis axis);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_UNITS_FLAGS_H_
