// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lattices in files: the proto3 JSON of latticed.v1.Lattice. MessageJson writes every field, with
// enough digits to read the same doubles back. ReadLattice takes any proto3 JSON, so knots and
// control points may be missing. It refuses unknown field names.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_LATTICE_JSON_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_LATTICE_JSON_H_

#include <array>
#include <string>

#include "absl/status/statusor.h"
#include "core/ffd/lattice.h"
#include "latticed/v1/lattice.pb.h"

namespace CLI {
class App;
}

namespace latticed::client {

[[nodiscard]] v1::Vec3 ToProto(Vec3d from);
[[nodiscard]] v1::Lattice ToProto(const Lattice& lattice);
[[nodiscard]] absl::StatusOr<v1::Lattice> ReadLattice(const std::string& path);

// Of an option that takes any number of such files.
inline constexpr char kLatticesHelp[] =
    "JSON file of the lattice; may be repeated: what several move adds up";

// --size 5,4,6 --degree 2,2,2 --padding 0.05.
struct FitFlags {
  std::string size = "4,4,4";
  std::string degree = "2,2,2";
  double padding = kDefaultPadding;
};
void AddFitFlags(CLI::App& command, FitFlags& flags);
[[nodiscard]] v1::LatticeFit ToProto(const FitFlags& flags);
// A check for CLI11: returns an error text unless `text` is three whole numbers.
[[nodiscard]] std::string CheckAxes(const std::string& text);
// Parses a text that CheckAxes has passed.
[[nodiscard]] std::array<int, 3> ParseAxes(const std::string& text);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_LATTICE_JSON_H_
