// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>

#include "absl/strings/str_split.h"
#include "client/cpp/latticectl/command_line/message_flags.h"
#include "client/cpp/latticectl/command_line/value_types.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/server_meshes.h"
#include "client/cpp/latticectl/session/session.h"
#include "core/base/status_macros.h"
#include "core/mesh/mesh_units.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

struct MeshFlags : ServerFlags {
  std::string file, name, filter;
  v1::MeshUnits units;
  std::vector<std::string> labels;  // key=value
  std::vector<std::string> ids;     // to be deleted
  bool force = false;
};

std::string MeshesText(const std::vector<v1::Mesh>& meshes) {
  TextTable table({"MESH", "NAME", "VERTICES", "FACES", "BYTES", "SCENES"});
  for (const v1::Mesh& mesh : meshes) {
    table.AddRow({mesh.id(), mesh.name(), FormatCount(mesh.vertices()), FormatCount(mesh.faces()),
                  FormatBytes(mesh.total_bytes()), FormatCount(mesh.scenes())});
  }
  return table.Text();
}

// The server keeps one mesh for the same bytes, with the units of the first upload.
absl::Status CheckUnits(const v1::Mesh& mesh, const v1::MeshUnits& asked) {
  if ((asked.up_axis() == v1::UP_AXIS_UNSPECIFIED || asked.up_axis() == mesh.up_axis()) &&
      (asked.meters_per_unit() == 0 || asked.meters_per_unit() == mesh.meters_per_unit())) {
    return absl::OkStatus();
  }
  const MeshUnits units{UpAxisName(mesh.up_axis()), mesh.meters_per_unit()};
  return absl::AlreadyExistsError(
      fmt::format("mesh {} already exists with {}, which does not change; 'latticectl meshes "
                  "delete' makes room for another",
                  mesh.id(), units.known() ? Describe(units) : "unknown axis and unit"));
}

absl::Status RunUpload(const MeshFlags& flags, Client& client, Console console) {
  LATTICED_ASSIGN_OR_RETURN(const auto file, ReadMeshFile(flags.file));
  v1::MeshHeader header;
  header.set_name(flags.name);
  for (const std::string& label : flags.labels) {
    const std::pair<std::string, std::string> entry =
        absl::StrSplit(label, absl::MaxSplits('=', 1));
    (*header.mutable_labels())[entry.first] = entry.second;
  }
  *header.mutable_units() = flags.units;
  LATTICED_ASSIGN_OR_RETURN(const auto mesh, Upload(client, file, std::move(header), console));
  LATTICED_RETURN_IF_ERROR(CheckUnits(mesh, flags.units));
  PrintResult(flags.json, mesh, MeshesText({mesh}), console.out);
  return absl::OkStatus();
}

absl::Status RunList(const MeshFlags& flags, Client& client, Console console) {
  LATTICED_ASSIGN_OR_RETURN(const auto meshes, client.ListMeshes(flags.filter));
  if (flags.json) {
    PrintJsonArray(meshes, console.out);
  } else {
    console.out << MeshesText(meshes);
  }
  return absl::OkStatus();
}

absl::Status RunDelete(const MeshFlags& flags, Client& client, Console console) {
  std::vector<std::string> deleted;
  absl::Status status;
  for (const std::string& id : flags.ids) {
    status = client.DeleteMesh(id, flags.force);
    if (!status.ok()) break;
    deleted.push_back(id);
    if (!flags.json) console.out << fmt::format("mesh {} is deleted\n", id);
  }
  if (flags.json) PrintJson({{"deleted", deleted}}, console.out);
  return status;
}

}  // namespace

void AddMeshCommands(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<MeshFlags>();
  CLI::App* upload = app.add_subcommand("upload", "Uploads a mesh file");
  upload->add_option("mesh", flags->file, "OBJ, PLY, STL, GLB or DRC file")
      ->required()
      ->type_name(kFileType);
  upload->add_option("--name", flags->name, "Name for people; by default the file's");
  upload->add_option("--label", flags->labels, "Label key=value; may be repeated");
  AddUnitsFlags(*upload, flags->units);
  SetExample(*upload, "upload vase.obj --label project=demo");
  SetServerAction(*upload, flags, line, RunUpload);

  CLI::App* list = app.add_subcommand("meshes", "Lists or deletes the meshes of a server");
  list->add_option(
      "--filter", flags->filter,
      "Labels that must hold: key=value or key, with commas; by default all are listed");
  SetExample(*list, "meshes --filter project=demo");
  SetServerAction(*list, flags, line, RunList);
  CLI::App* remove = list->add_subcommand("delete", "Deletes meshes");
  remove->add_option("mesh", flags->ids, "Ids of the meshes")->required();
  remove->add_flag("--force", flags->force, "Also delete the scenes that use them; role admin");
  SetExample(*remove, "meshes delete 0123abcd --force");
  SetServerAction(*remove, flags, line, RunDelete);
}

}  // namespace latticed::client
