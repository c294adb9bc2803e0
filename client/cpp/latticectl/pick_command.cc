// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "client/cpp/latticectl/commands.h"
#include "client/cpp/latticectl/json_output.h"
#include "client/cpp/latticectl/ray_flags.h"
#include "client/cpp/latticectl/session.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "fmt/ranges.h"

namespace latticed::client {
namespace {

struct PickFlags {
  SessionFlags session;
  std::string scene;
  std::vector<double> ray;
  bool json = false;
};

absl::Status Run(const PickFlags& flags, Client& client, Console console) {
  LATTICED_ASSIGN_OR_RETURN(const auto point, client.Pick(PickRequestOf(flags.scene, flags.ray)));
  if (flags.json) {
    console.out << MessageJson(point);
    return absl::OkStatus();
  }
  console.out << fmt::format("{}, {}, {} in face {}\n", point.position().x(), point.position().y(),
                             point.position().z(), point.face());
  if (point.has_normal()) {
    console.out << fmt::format("normal {:.6g}, {:.6g}, {:.6g}\n", point.normal().x(),
                               point.normal().y(), point.normal().z());
  }
  console.out << fmt::format("edit drag --at {},{},{}\n", point.face(),
                             fmt::join(point.corners(), ","), fmt::join(point.barycentrics(), ","));
  return absl::OkStatus();
}

}  // namespace

void AddPickCommand(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<PickFlags>();
  CLI::App* command =
      app.add_subcommand("pick", "Finds the first point of the deformed surface on a ray");
  command->add_option("scene", flags->scene, "Id of the scene")->required();
  AddRayFlag(*command, flags->ray)->required();
  AddJsonFlag(*command, flags->json);
  SetServerAction(*command, flags->session, line,
                  [flags, &line](Client& client) { return Run(*flags, client, line.console); });
}

}  // namespace latticed::client
