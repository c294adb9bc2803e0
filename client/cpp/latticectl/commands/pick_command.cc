// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "client/cpp/latticectl/command_line/message_flags.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/commands/ray_flag.h"
#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/session.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "fmt/ranges.h"

namespace latticed::client {
namespace {

struct PickFlags : ServerFlags {
  std::string scene;
  std::vector<double> ray;
};

absl::Status RunPick(const PickFlags& flags, Client& client, Console console) {
  LATTICED_ASSIGN_OR_RETURN(const auto point, client.Pick(PickRequestOf(flags.scene, flags.ray)));
  std::string text = fmt::format("{}, {}, {} in face {}\n", point.position().x(),
                                 point.position().y(), point.position().z(), point.face());
  if (point.has_normal()) {
    text += fmt::format("normal {:.6g}, {:.6g}, {:.6g}\n", point.normal().x(), point.normal().y(),
                        point.normal().z());
  }
  text += fmt::format("edit drag --at {},{},{}\n", point.face(), fmt::join(point.corners(), ","),
                      fmt::join(point.barycentrics(), ","));
  PrintResult(flags.json, point, text, console.out);
  return absl::OkStatus();
}

}  // namespace

CLI::Option* AddRayFlag(CLI::App& command, std::vector<double>& ray) {
  return command
      .add_option("--ray", ray, "Ray X,Y,Z,DX,DY,DZ in the world: where it begins, where it goes")
      ->delimiter(',')
      ->expected(6);
}

v1::PickRequest PickRequestOf(const std::string& scene, const std::vector<double>& ray) {
  v1::PickRequest request;
  request.set_scene(scene);
  *request.mutable_ray()->mutable_origin() = ToProto(Vec3d{ray[0], ray[1], ray[2]});
  *request.mutable_ray()->mutable_direction() = ToProto(Vec3d{ray[3], ray[4], ray[5]});
  return request;
}

void AddPickCommand(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<PickFlags>();
  CLI::App* command =
      app.add_subcommand("pick", "Finds the first point of the deformed surface on a ray");
  command->add_option("scene", flags->scene, "Id of the scene")->required();
  AddRayFlag(*command, flags->ray)->required();
  SetExample(*command, "pick my-scene --ray 0,0,5,0,0,-1");
  SetServerAction(*command, flags, line, RunPick);
}

}  // namespace latticed::client
