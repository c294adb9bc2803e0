// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Options that say what the numbers of a mesh file mean: --up-axis z --meters-per-unit 0.001.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_UNITS_FLAGS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_UNITS_FLAGS_H_

#include <string>

#include "latticed/v1/mesh.pb.h"

namespace CLI {
class App;
}

namespace latticed::client {

// An option that is not given leaves its field empty: unknown.
void AddUnitsFlags(CLI::App& command, v1::MeshUnits& units);

// "x", "y", "z"; empty for an unknown one.
[[nodiscard]] std::string UpAxisName(v1::UpAxis axis);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_UNITS_FLAGS_H_
