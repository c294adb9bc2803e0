// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// --tolerance: the largest distance of the triangles from the exact surface.
//
//   0.02           world units
//   0.1mm          a length: um, mm, cm, m, in. The scene's units make it world units
//   1e-4D          times the diagonal of the deformed mesh's bounds
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_TOLERANCE_FLAG_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_TOLERANCE_FLAG_H_

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "absl/functional/function_ref.h"
#include "absl/status/statusor.h"
#include "latticed/v1/view.pb.h"

namespace latticed::client {

struct Tolerance {
  enum class Unit { kWorld, kMetres, kDiagonal };
  double number = 0;  // 0: none was given
  Unit unit = Unit::kWorld;
  std::string text;  // as it was given
};

// nullopt for what is not above 0, or has another unit.
[[nodiscard]] std::optional<Tolerance> ParseTolerance(const std::string& text);

void AddToleranceFlag(CLI::App& command, Tolerance& tolerance);

// meters_per_unit: 0 if unknown, which is kInvalidArgument for a length. `diagonal` is called for a Tolerance that is
// measured by it.
[[nodiscard]] absl::StatusOr<double> InWorldUnits(
    const Tolerance& tolerance, double meters_per_unit,
    absl::FunctionRef<absl::StatusOr<double>()> diagonal);

// What a command says about a surface that has this certified error; empty if the view has no tolerance. `own_points`:
// the command has made them, from patches.
[[nodiscard]] std::string DescribeCertificate(double tolerance, double certified_error,
                                              bool own_points = false);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_TOLERANCE_FLAG_H_
