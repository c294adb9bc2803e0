// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <string>
#include <utility>

#include "client/cpp/latticectl/command_line/message_flags.h"
#include "client/cpp/latticectl/command_line/tolerance_flag.h"
#include "client/cpp/latticectl/command_line/value_types.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/commands/scene_text.h"
#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "client/cpp/latticectl/geometry/outside_text.h"
#include "client/cpp/latticectl/geometry/weights_source.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/server_meshes.h"
#include "client/cpp/latticectl/session/session.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

struct SceneFlags : ServerFlags {
  std::string id, name, mesh, filter, weights;
  std::vector<std::string> lattices;  // files
  std::optional<double> strength;
  FitFlags fit;
  std::string outside;  // of the fit; empty: not set
  v1::MeshUnits units;
  std::optional<double> crease_angle;
  v1::ViewOptions view;
  Tolerance tolerance;
  v1::Pipeline pipeline = v1::PIPELINE_UNSPECIFIED;
  bool fold_watch = false;
};

constexpr size_t kMeshIdDigits = 64;

bool IsMeshId(const std::string& text) {
  return text.size() == kMeshIdDigits &&
         text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

// The lattices from files, or one that the server fits.
absl::Status AddLattices(const SceneFlags& flags, v1::CreateSceneRequest& request) {
  for (const std::string& file : flags.lattices) {
    LATTICED_ASSIGN_OR_RETURN(*request.add_lattices()->mutable_lattice(), ReadLattice(file));
  }
  if (!flags.lattices.empty()) return absl::OkStatus();
  v1::LatticeFit& fit = *request.add_lattices()->mutable_fit();
  fit = ToProto(flags.fit);
  if (flags.outside.empty()) return absl::OkStatus();
  LATTICED_ASSIGN_OR_RETURN(*fit.mutable_outside(), ParseOutside(flags.outside));
  return absl::OkStatus();
}

// A new scene may not be deformed yet, so its mesh's diagonal counts.
absl::Status SetDefaultTolerance(const SceneFlags& flags, Client& client,
                                 v1::CreateSceneRequest* request) {
  if (flags.tolerance.number == 0) return absl::OkStatus();
  LATTICED_ASSIGN_OR_RETURN(const auto mesh, client.GetMesh(request->mesh()));
  const double asked = flags.units.meters_per_unit();
  const auto diagonal = [&]() -> absl::StatusOr<double> {
    const auto& [low, high] = std::pair(mesh.bounds().min(), mesh.bounds().max());
    return std::hypot(high.x() - low.x(), high.y() - low.y(), high.z() - low.z());
  };
  LATTICED_ASSIGN_OR_RETURN(
      const double distance,
      InWorldUnits(flags.tolerance, asked > 0 ? asked : mesh.meters_per_unit(), diagonal));
  request->mutable_default_view()->set_tolerance(distance);
  return absl::OkStatus();
}

absl::Status RunCreate(const SceneFlags& flags, Client& client, Console console) {
  v1::CreateSceneRequest request;
  LATTICED_RETURN_IF_ERROR(AddLattices(flags, request));
  request.set_scene_id(flags.id);
  request.set_name(flags.name);
  request.set_mesh(flags.mesh);
  if (!IsMeshId(flags.mesh)) {
    LATTICED_ASSIGN_OR_RETURN(const auto file, ReadMeshFile(flags.mesh));
    LATTICED_ASSIGN_OR_RETURN(const auto mesh, Upload(client, file, {}, console));
    request.set_mesh(mesh.id());
  }
  *request.mutable_units() = flags.units;
  if (flags.crease_angle.has_value()) request.set_crease_angle(*flags.crease_angle);
  if (flags.strength.has_value()) request.set_strength(*flags.strength);
  LATTICED_RETURN_IF_ERROR(SetWeights(flags.weights, &request));
  *request.mutable_default_view() = flags.view;
  LATTICED_RETURN_IF_ERROR(SetDefaultTolerance(flags, client, &request));
  request.mutable_diagnostics()->set_pipeline(flags.pipeline);
  request.set_fold_watch(flags.fold_watch);
  LATTICED_ASSIGN_OR_RETURN(const auto scene, client.CreateScene(std::move(request)));
  PrintResult(flags.json, scene, SceneText(scene), console.out);
  return absl::OkStatus();
}

absl::Status RunList(const SceneFlags& flags, Client& client, Console console) {
  LATTICED_ASSIGN_OR_RETURN(const auto scenes, client.ListScenes(flags.filter));
  if (flags.json) {
    PrintJsonArray(scenes, console.out);
  } else {
    console.out << ScenesText(scenes);
  }
  return absl::OkStatus();
}

absl::Status RunShow(const SceneFlags& flags, Client& client, Console console) {
  LATTICED_ASSIGN_OR_RETURN(const auto scene, client.GetScene(flags.id));
  std::vector<v1::LatticeState> states;
  for (const auto& lattice : scene.lattices()) {
    auto state = client.GetLattice(flags.id, lattice.index());
    if (error::DetailsOf(state.status()).reason == "OUT_OF_RANGE") continue;  // since then
    LATTICED_RETURN_IF_ERROR(state.status());
    states.push_back(*std::move(state));
  }
  PrintResult(flags.json, SceneJson(scene, states), SceneText(scene, states), console.out);
  return absl::OkStatus();
}

absl::Status RunDelete(const SceneFlags& flags, Client& client, Console console) {
  LATTICED_RETURN_IF_ERROR(client.DeleteScene(flags.id));
  PrintResult(flags.json, nlohmann::json{{"deleted", std::vector{flags.id}}},
              fmt::format("scene {} is deleted\n", flags.id), console.out);
  return absl::OkStatus();
}

}  // namespace

void AddSceneCommands(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<SceneFlags>();
  CLI::App* scene = app.add_subcommand("scene", "Makes, lists, shows and deletes scenes");
  scene->require_subcommand(0, 1);
  const auto add = [&](const char* name, const char* what, const char* example,
                       absl::Status (*run)(const SceneFlags&, Client&, Console)) {
    CLI::App* command = scene->add_subcommand(name, what);
    SetExample(*command, example);
    SetServerAction(*command, flags, line, run);
    return command;
  };
  CLI::App* create = add("create", "Creates a scene of a mesh and a lattice",
                         "scene create vase.obj --id my-scene --size 4,4,5", RunCreate);
  create->add_option("mesh", flags->mesh, "Mesh id, or a file to upload")
      ->required()
      ->type_name(kFileType);
  create->add_option("--id", flags->id, "Id of the scene; by default a random one");
  create->add_option("--name", flags->name, "Name for people; by default the mesh's");
  CLI::Option* lattice = create->add_option("--lattice", flags->lattices, kLatticesHelp)
                             ->take_all()
                             ->type_name(kFileType);
  AddFitFlags(*create, flags->fit);
  create->add_option("--outside", flags->outside, kOutsideHelp)->check(CheckOutside);
  for (const char* fit : {"--size", "--degree", "--padding", "--outside"})
    lattice->excludes(create->get_option(fit));
  AddUnitsFlags(*create, flags->units);
  AddCreaseFlag(*create, flags->crease_angle);
  create->add_option("--strength", flags->strength,
                     "How much of the deformation the scene takes, 0 to 1; by default all");
  AddWeightsFlag(*create, flags->weights);
  AddViewFlags(*create, flags->view, ViewDefaults::kOfServer);
  AddToleranceFlag(*create, flags->tolerance);
  AddPipelineFlag(*create, flags->pipeline);
  create->add_flag("--fold-watch", flags->fold_watch, "Every edit is answered with where it folds");
  add("list", "Lists scenes", "scene list", RunList)
      ->add_option(
          "--filter", flags->filter,
          "Labels that must hold: key=value or key, with commas; by default all are listed");
  add("show", "Shows a scene", "scene show my-scene", RunShow)
      ->add_option("scene", flags->id, "Id of the scene")
      ->required();
  add("delete", "Deletes a scene", "scene delete my-scene", RunDelete)
      ->add_option("scene", flags->id, "Id of the scene")
      ->required();
}

}  // namespace latticed::client
