// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <filesystem>
#include <map>
#include <memory>
#include <ostream>

#include "absl/strings/ascii.h"
#include "client/cpp/latticectl/command_line/message_flags.h"
#include "client/cpp/latticectl/command_line/value_types.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/geometry/files.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/scene_tolerance.h"
#include "client/cpp/latticectl/session/session.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

struct ExportFlags : ServerFlags {
  std::string scene, output;
  uint64_t revision = 0;
  v1::ViewOptions view;
  Tolerance tolerance;
  bool original = false;
  bool patches = false;
};

// The format of a path's extension; UNSPECIFIED for an unknown one.
v1::ExportFormat FormatOf(const std::string& path) {
  static const auto* const kFormats = new std::map<std::string, v1::ExportFormat>{
      {".ply", v1::EXPORT_FORMAT_PLY}, {".obj", v1::EXPORT_FORMAT_OBJ},
      {".stl", v1::EXPORT_FORMAT_STL}, {".glb", v1::EXPORT_FORMAT_GLB},
      {".drc", v1::EXPORT_FORMAT_DRC}, {".nets", v1::EXPORT_FORMAT_CONTROL_NETS},
      {".usda", v1::EXPORT_FORMAT_USD}};
  const auto found =
      kFormats->find(absl::AsciiStrToLower(std::filesystem::path(path).extension().string()));
  return found == kFormats->end() ? v1::EXPORT_FORMAT_UNSPECIFIED : found->second;
}

std::string CheckOutput(const std::string& path) {
  return FormatOf(path) == v1::EXPORT_FORMAT_UNSPECIFIED
             ? fmt::format(
                   "{}: the extension must be one of .ply, .obj, .stl, .glb, .drc, .usda, .nets",
                   path)
             : "";
}

absl::StatusOr<v1::ExportRequest> RequestOf(const ExportFlags& flags, Client& client) {
  v1::ExportRequest request;
  request.set_scene(flags.scene);
  request.set_revision(flags.revision);
  request.set_format(FormatOf(flags.output));
  *request.mutable_view() = flags.view;
  LATTICED_RETURN_IF_ERROR(
      SetTolerance(client, flags.scene, flags.tolerance, request.mutable_view()));
  if (flags.original) request.set_geometry(v1::EXPORT_GEOMETRY_ORIGINAL);
  if (flags.patches) request.set_geometry(v1::EXPORT_GEOMETRY_PATCHES);
  return request;
}

// A tolerance of the scene's default view is not known here.
std::string Certificate(const v1::ExportRequest& request, const v1::ExportHeader& header) {
  const double certified = header.certified_error();
  if (certified == 0) return "";
  const double asked = request.view().tolerance();
  return DescribeCertificate(asked > 0 ? asked : certified, certified);
}

absl::Status RunExport(const ExportFlags& flags, Client& client, Console console) {
  LATTICED_ASSIGN_OR_RETURN(const auto request, RequestOf(flags, client));
  ProgressBar bar(console, "export", ProgressBar::Unit::kBytes);
  LATTICED_ASSIGN_OR_RETURN(const auto file, client.Export(request, bar.callback()));
  LATTICED_RETURN_IF_ERROR(WriteFile(flags.output, file.bytes));
  PrintResult(flags.json, file.header,
              fmt::format("{}: {}, revision {}{}\n", flags.output, FormatBytes(file.bytes.size()),
                          file.header.revision(), Certificate(request, file.header)),
              console.out);
  return absl::OkStatus();
}

}  // namespace

void AddExportCommand(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<ExportFlags>();
  CLI::App* command = app.add_subcommand(
      "export", "Writes the deformed surface of a scene, or its original mesh, to a file");
  command->add_option("scene", flags->scene, "Id of the scene")->required();
  command
      ->add_option("-o,--output", flags->output,
                   "PLY, OBJ, STL, GLB, USDA, DRC or control NETS file")
      ->required()
      ->type_name(kFileType)
      ->check(CheckOutput);
  command->add_option("--revision", flags->revision, "Fails unless this is the newest revision");
  CLI::Option* original =
      command->add_flag("--original", flags->original,
                        "The uploaded vertices and faces, moved, in place of the exact surface");
  command
      ->add_flag("--patches", flags->patches,
                 "The exact surface, each patch with vertices of its own")
      ->excludes(original);
  AddViewFlags(*command, flags->view, ViewDefaults::kOfScene);
  AddToleranceFlag(*command, flags->tolerance);
  SetExample(*command, "export my-scene -o out.glb --segments 16");
  SetServerAction(*command, flags, line, RunExport);
}

}  // namespace latticed::client
