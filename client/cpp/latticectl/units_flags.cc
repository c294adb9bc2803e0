// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/units_flags.h"

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <vector>

#include "absl/strings/numbers.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

struct NamedAxis {
  const char* name;
  v1::UpAxis axis;
};
constexpr std::array<NamedAxis, 3> kUpAxes{
    {{"x", v1::UP_AXIS_X}, {"y", v1::UP_AXIS_Y}, {"z", v1::UP_AXIS_Z}}};

// For CLI11, whose own check lets its message run to the largest double's 309 digits.
std::string CheckLength(const std::string& text) {
  double length = 0;
  const bool good = absl::SimpleAtod(text, &length) && length > 0 && std::isfinite(length);
  return good ? "" : fmt::format("'{}' is not a length above 0", text);
}

}  // namespace

void AddUnitsFlags(CLI::App& command, UnitsFlags& flags) {
  std::vector<std::string> names;
  names.reserve(kUpAxes.size());
  for (const NamedAxis& up : kUpAxes) names.emplace_back(up.name);
  command.add_option("--up-axis", flags.up_axis, "Axis of the mesh that points up")
      ->check(CLI::IsMember(names));
  command
      .add_option("--meters-per-unit", flags.meters_per_unit,
                  "Length of the mesh's unit, for instance 0.001 for millimetres")
      ->check(CheckLength);
}

v1::MeshUnits ToProto(const UnitsFlags& flags) {
  v1::MeshUnits units;
  for (const NamedAxis& up : kUpAxes) {
    if (flags.up_axis == up.name) units.set_up_axis(up.axis);
  }
  units.set_meters_per_unit(flags.meters_per_unit);
  return units;
}

std::string UpAxisName(v1::UpAxis axis) {
  for (const NamedAxis& up : kUpAxes) {
    if (axis == up.axis) return up.name;
  }
  return "";
}

}  // namespace latticed::client
