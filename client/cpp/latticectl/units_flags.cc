// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/units_flags.h"

#include <CLI/CLI.hpp>
#include <cmath>

#include "absl/strings/numbers.h"
#include "client/cpp/latticectl/named_values.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr NamedValues<v1::UpAxis, 3> kUpAxes{
    {{"x", v1::UP_AXIS_X}, {"y", v1::UP_AXIS_Y}, {"z", v1::UP_AXIS_Z}}};

// For CLI11, whose own check prints the largest double with 309 digits.
std::string CheckLength(const std::string& text) {
  double length = 0;
  const bool good = absl::SimpleAtod(text, &length) && length > 0 && std::isfinite(length);
  return good ? "" : fmt::format("'{}' is not a length above 0", text);
}

}  // namespace

void AddUnitsFlags(CLI::App& command, v1::MeshUnits& units) {
  AddNamedOption<v1::UpAxis>(
      command, "--up-axis", kUpAxes, [&units](auto axis) { units.set_up_axis(axis); },
      "Axis of the mesh that points up");
  command
      .add_option_function<double>(
          "--meters-per-unit", [&units](double length) { units.set_meters_per_unit(length); },
          "Length of the mesh's unit, for instance 0.001 for millimetres")
      ->check(CheckLength);
}

std::string UpAxisName(v1::UpAxis axis) { return NameOf(kUpAxes, axis, ""); }

}  // namespace latticed::client
