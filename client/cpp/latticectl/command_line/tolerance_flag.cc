// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/command_line/tolerance_flag.h"

#include <cmath>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "core/base/error.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

struct NamedUnit {
  const char* name;
  Tolerance::Unit unit;
  double scale;
};
// Units whose names end alike stand in the order in which they must be tried.
constexpr NamedUnit kUnits[] = {
    {"um", Tolerance::Unit::kMetres, 1e-6}, {"mm", Tolerance::Unit::kMetres, 1e-3},
    {"cm", Tolerance::Unit::kMetres, 1e-2}, {"in", Tolerance::Unit::kMetres, 0.0254},
    {"m", Tolerance::Unit::kMetres, 1},     {"D", Tolerance::Unit::kDiagonal, 1},
    {"", Tolerance::Unit::kWorld, 1}};

std::string CheckTolerance(const std::string& text) {
  if (ParseTolerance(text).has_value()) return "";
  return fmt::format("'{}' is not a distance above 0, such as 0.02, 0.1mm or 1e-4D", text);
}

}  // namespace

std::optional<Tolerance> ParseTolerance(const std::string& text) {
  for (const NamedUnit& unit : kUnits) {
    const std::string name = unit.name;
    if (!absl::EndsWith(text, name)) continue;
    const std::string digits = text.substr(0, text.size() - name.size());
    // SimpleAtod would also take spaces and "inf".
    if (digits.find_first_not_of("0123456789.eE+-") != std::string::npos) return std::nullopt;
    double number = 0;
    if (!absl::SimpleAtod(digits, &number)) return std::nullopt;
    number *= unit.scale;
    if (!(number > 0) || !std::isfinite(number)) return std::nullopt;
    return Tolerance{number, unit.unit, text};
  }
  return std::nullopt;
}

void AddToleranceFlag(CLI::App& command, Tolerance& tolerance) {
  command
      .add_option_function<std::string>(
          "--tolerance",
          [&tolerance](const std::string& text) { tolerance = *ParseTolerance(text); },
          "Largest distance of the triangles from the exact surface, in place of --segments, which "
          "then limit the points, except of patches: in world units, with a unit such as 0.1mm, or "
          "1e-4D, of the deformed mesh's diagonal")
      ->type_name("DISTANCE")
      ->check(CheckTolerance);
}

absl::StatusOr<double> InWorldUnits(const Tolerance& tolerance, double meters_per_unit,
                                    absl::FunctionRef<absl::StatusOr<double>()> diagonal) {
  switch (tolerance.unit) {
    case Tolerance::Unit::kWorld:
      break;
    case Tolerance::Unit::kMetres:
      if (!(meters_per_unit > 0)) {
        return error::InvalidField(
            "view.tolerance",
            fmt::format("'{}' is a length, and the scene's unit is unknown; give a number in world "
                        "units, or --meters-per-unit when the mesh is uploaded",
                        tolerance.text));
      }
      return tolerance.number / meters_per_unit;
    case Tolerance::Unit::kDiagonal: {
      const auto length = diagonal();
      if (!length.ok()) return length.status();
      return tolerance.number * *length;
    }
  }
  return tolerance.number;
}

std::string DescribeCertificate(double tolerance, double certified_error, bool own_points) {
  if (!(tolerance > 0)) return "";
  const std::string within = fmt::format("; within {:.3g} of the exact surface", certified_error);
  if (certified_error <= tolerance) return within;
  return fmt::format("{}, not {:.3g}: {}", within, tolerance,
                     own_points ? "an edge has at most 32 segments"
                                : "more --segments or --position-bits may help");
}

}  // namespace latticed::client
