// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>

#include "client/cpp/latticectl/commands.h"
#include "client/cpp/latticectl/files.h"
#include "client/cpp/latticectl/json_output.h"
#include "client/cpp/latticectl/text_table.h"
#include "core/base/status_macros.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/sample_meshes.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

struct SampleFlags {
  std::string name;
  int resolution = kDefaultSampleResolution;
  std::string output;
  bool json = false;
};

absl::Status Run(const SampleFlags& flags, Console console) {
  LATTICED_ASSIGN_OR_RETURN(const auto mesh, MakeSampleMesh(flags.name, flags.resolution));
  LATTICED_RETURN_IF_ERROR(WriteFile(flags.output, WriteObj(mesh)));
  if (flags.json) {
    PrintJson({{"output", flags.output},
               {"vertices", mesh.positions.size()},
               {"faces", mesh.face_count()}},
              console.out);
  } else {
    console.out << fmt::format("{}: {} vertices, {} faces\n", flags.output,
                               FormatCount(mesh.positions.size()), FormatCount(mesh.face_count()));
  }
  return absl::OkStatus();
}

std::string CheckIsObj(const std::string& path) {
  const auto format = MeshFormatFromFileName(path);
  return format.ok() && *format == MeshFormat::kObj ? "" : "samples are written as .obj files";
}

}  // namespace

void AddSampleCommand(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<SampleFlags>();
  CLI::App* command =
      app.add_subcommand("sample", "Writes a mesh made by formula, to try things on");
  const auto names = SampleMeshNames();
  command->add_option("name", flags->name, "Which one")
      ->required()
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())));
  command->add_option("--resolution", flags->resolution, "Faces grow with its square")
      ->check(CLI::Range(kMinSampleResolution, kMaxSampleResolution))
      ->capture_default_str();
  command->add_option("-o,--output", flags->output, "OBJ file to write")
      ->required()
      ->check(CheckIsObj);
  AddJsonFlag(*command, flags->json);
  SetAction(*command, line, [flags, &line] { return Run(*flags, line.console); });
}

}  // namespace latticed::client
