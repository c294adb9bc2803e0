// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <memory>
#include <ostream>

#include "client/cpp/latticectl/commands.h"
#include "client/cpp/latticectl/json_output.h"
#include "client/cpp/latticectl/lattice_json.h"
#include "client/cpp/latticectl/session.h"
#include "client/cpp/latticectl/surface_mesh.h"
#include "client/cpp/latticectl/text_table.h"
#include "client/cpp/latticectl/view_flags.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

struct SceneFlags {
  SessionFlags session;
  std::string id, mesh, lattice, pipeline, filter;
  FitFlags fit;
  ViewFlags view;
  bool json = false;
};

constexpr size_t kMeshIdDigits = 64;

bool IsMeshId(const std::string& text) {
  return text.size() == kMeshIdDigits &&
         text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

std::string Axes(const v1::LatticeAxes& axes) {
  return fmt::format("{},{},{}", axes.u(), axes.v(), axes.w());
}

void PrintScenes(const std::vector<v1::Scene>& scenes, std::ostream& out) {
  TextTable table({"SCENE", "MESH", "SIZE", "REVISION", "PATCHES", "CHUNKS"});
  for (const v1::Scene& scene : scenes) {
    const std::string size = scene.lattices_size() > 0 ? Axes(scene.lattices(0).size()) : "";
    table.AddRow({scene.id(), scene.mesh().substr(0, 12), size, FormatCount(scene.revision()),
                  FormatCount(scene.patches()), FormatCount(scene.chunks())});
  }
  table.Print(out);
}

void PrintScene(const v1::Scene& scene, std::ostream& out) {
  TextTable table;
  table.AddRow({"scene", scene.id()});
  table.AddRow({"mesh", scene.mesh()});
  for (const auto& lattice : scene.lattices()) {
    table.AddRow({"lattice",
                  fmt::format("size {}, degree {}", Axes(lattice.size()), Axes(lattice.degree()))});
  }
  table.AddRow({"revision", FormatCount(scene.revision())});
  table.AddRow({"structure", FormatCount(scene.structure_id())});
  table.AddRow(
      {"patches",
       fmt::format("{} ({} outside, {} on lattice faces)", FormatCount(scene.patches()),
                   FormatCount(scene.patches_outside()), FormatCount(scene.patches_on_faces()))});
  table.AddRow({"chunks", FormatCount(scene.chunks())});
  const v1::ViewOptions& view = scene.default_view();
  table.AddRow(
      {"default view", fmt::format("{} segments, {} normals, {}, {}/{} bits", view.segments(),
                                   NormalModeName(view.normals()), EncodingName(view.encoding()),
                                   view.position_bits(), view.normal_bits())});
  for (const auto& [purpose, bytes] : scene.bytes()) {
    table.AddRow({"bytes of " + purpose, FormatBytes(bytes)});
  }
  table.Print(out);
}

void Print(const v1::Scene& scene, bool json, std::ostream& out) {
  if (json) {
    out << MessageJson(scene);
  } else {
    PrintScene(scene, out);
  }
}

absl::StatusOr<v1::LatticeSource> Source(const SceneFlags& flags) {
  v1::LatticeSource source;
  if (!flags.lattice.empty()) {
    LATTICED_ASSIGN_OR_RETURN(const auto json, ReadFile(flags.lattice));
    LATTICED_ASSIGN_OR_RETURN(*source.mutable_lattice(), LatticeFromJson(json, flags.lattice));
    return source;
  }
  *source.mutable_fit() = ToProto(flags.fit);
  return source;
}

absl::Status RunCreate(const SceneFlags& flags, Console console) {
  LATTICED_ASSIGN_OR_RETURN(auto source, Source(flags));
  LATTICED_ASSIGN_OR_RETURN(auto session, Session::Open(flags.session));
  v1::CreateSceneRequest request;
  request.set_scene_id(flags.id);
  request.set_mesh(flags.mesh);
  if (!IsMeshId(flags.mesh)) {
    LATTICED_ASSIGN_OR_RETURN(const auto file, ReadMeshFile(flags.mesh));
    const auto mesh = Upload(session.client(), file, {}, console);
    if (!mesh.ok()) return session.Explain(mesh.status());
    request.set_mesh(mesh->id());
  }
  *request.add_lattices() = std::move(source);
  *request.mutable_default_view() = ToProto(flags.view);
  request.mutable_diagnostics()->set_pipeline(PipelineToProto(flags.pipeline));
  const auto scene = session.client().CreateScene(std::move(request));
  if (!scene.ok()) return session.Explain(scene.status());
  Print(*scene, flags.json, console.out);
  return absl::OkStatus();
}

absl::Status RunList(const SceneFlags& flags, Console console) {
  LATTICED_ASSIGN_OR_RETURN(auto session, Session::Open(flags.session));
  const auto scenes = session.client().ListScenes(flags.filter);
  if (!scenes.ok()) return session.Explain(scenes.status());
  if (flags.json) {
    PrintJsonArray(*scenes, console.out);
  } else {
    PrintScenes(*scenes, console.out);
  }
  return absl::OkStatus();
}

absl::Status RunShow(const SceneFlags& flags, Console console) {
  LATTICED_ASSIGN_OR_RETURN(auto session, Session::Open(flags.session));
  const auto scene = session.client().GetScene(flags.id);
  if (!scene.ok()) return session.Explain(scene.status());
  Print(*scene, flags.json, console.out);
  return absl::OkStatus();
}

absl::Status RunDelete(const SceneFlags& flags, Console console) {
  LATTICED_ASSIGN_OR_RETURN(auto session, Session::Open(flags.session));
  const auto status = session.client().DeleteScene(flags.id);
  if (!status.ok()) return session.Explain(status);
  if (flags.json) {
    PrintDeleted({flags.id}, console.out);
  } else {
    console.out << fmt::format("scene {} is deleted\n", flags.id);
  }
  return absl::OkStatus();
}

}  // namespace

void AddSceneCommands(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<SceneFlags>();
  CLI::App* scene = app.add_subcommand("scene", "Makes, lists, shows and deletes scenes");
  scene->require_subcommand(1);
  const auto add = [&](const char* name, const char* what,
                       absl::Status (*run)(const SceneFlags&, Console)) {
    CLI::App* command = scene->add_subcommand(name, what);
    AddSessionFlags(*command, flags->session, ServerChoice::kRequired);
    AddJsonFlag(*command, flags->json);
    command->callback(
        [flags, run, &line] { line.action = [=, &line] { return run(*flags, line.console); }; });
    return command;
  };
  CLI::App* create = add("create", "Puts a mesh under a lattice", RunCreate);
  create->add_option("mesh", flags->mesh, "Mesh id, or a file to upload")->required();
  create->add_option("--id", flags->id, "Id of the scene; by default a random one");
  CLI::Option* lattice =
      create->add_option("--lattice", flags->lattice, "JSON file of the lattice");
  AddFitFlags(*create, flags->fit);
  for (const char* fit : {"--size", "--degree", "--padding"})
    lattice->excludes(create->get_option(fit));
  AddViewFlags(*create, flags->view);
  AddPipelineFlag(*create, flags->pipeline);
  add("list", "Lists scenes", RunList)
      ->add_option("--filter", flags->filter,
                   "Labels that must hold: key=value or key, with commas");
  add("show", "Shows a scene", RunShow)
      ->add_option("scene", flags->id, "Id of the scene")
      ->required();
  add("delete", "Deletes a scene", RunDelete)
      ->add_option("scene", flags->id, "Id of the scene")
      ->required();
}

}  // namespace latticed::client
