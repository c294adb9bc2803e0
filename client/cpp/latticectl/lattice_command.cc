// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>

#include "client/cpp/latticectl/commands.h"
#include "client/cpp/latticectl/files.h"
#include "client/cpp/latticectl/json_output.h"
#include "client/cpp/latticectl/lattice_json.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

struct LatticeFlags {
  std::string mesh;
  FitFlags fit;
  std::string output;
  bool json = false;
};

absl::Status Run(const LatticeFlags& flags, Console console) {
  LATTICED_ASSIGN_OR_RETURN(const auto file, ReadMeshFile(flags.mesh));
  LATTICED_ASSIGN_OR_RETURN(const auto mesh, ParseMesh(file));
  LATTICED_ASSIGN_OR_RETURN(const auto lattice,
                            FitLattice(mesh.ComputeBounds(), ParseAxes(flags.fit.size),
                                       ParseAxes(flags.fit.degree), flags.fit.padding));
  const std::string json = MessageJson(ToProto(lattice));
  if (flags.output.empty()) {
    console.out << json;
    return absl::OkStatus();
  }
  LATTICED_RETURN_IF_ERROR(WriteFile(flags.output, json));
  if (flags.json) {
    PrintJson({{"output", flags.output}, {"controlPoints", lattice.control_points.size()}},
              console.out);
  } else {
    console.out << fmt::format("{}: {} control points\n", flags.output,
                               lattice.control_points.size());
  }
  return absl::OkStatus();
}

}  // namespace

void AddLatticeCommand(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<LatticeFlags>();
  CLI::App* command = app.add_subcommand(
      "lattice", "Writes the identity lattice around a mesh as JSON, to be edited");
  command->add_option("mesh", flags->mesh, "OBJ, PLY, STL, GLB or DRC file")->required();
  AddFitFlags(*command, flags->fit);
  command->add_option("-o,--output", flags->output, "JSON file to write; by default it is printed");
  AddJsonFlag(*command, flags->json);
  SetAction(*command, line, [flags, &line] { return Run(*flags, line.console); });
}

}  // namespace latticed::client
