// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <memory>
#include <ostream>

#include "client/cpp/latticectl/command_line/message_flags.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/session.h"
#include "client/cpp/library/encodings/encoding_choice.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

struct InfoFlags : ServerFlags {
  bool health = false;
};

// Why none could be chosen is no reason to show nothing else.
std::string BestEncoding(Client& client) {
  const auto choice = ChooseEncoding(client);
  if (!choice.ok()) return "unknown: " + std::string(choice.status().message());
  return fmt::format("{}: {}", EncodingName(choice->encoding), choice->reason);
}

std::string InfoText(const v1::ServerInfo& info, const std::string& best_encoding) {
  TextTable table;
  table.AddRow({"version", info.version()});
  table.AddRow({"durability", info.durable()
                                  ? "meshes, scenes and edits survive a restart"
                                  : "none: meshes and scenes end with the server (--data-dir)"});
  table.AddRow({"node", info.node()});
  table.AddRow({"boot id", info.boot_id()});
  for (const auto& backend : info.backends()) {
    table.AddRow({"backend", fmt::format("{}: {}", backend.name(), backend.description())});
    for (const auto& device : backend.devices()) {
      if (device.budget_bytes() == 0) continue;
      table.AddRow({fmt::format("memory of device {}", device.number()),
                    fmt::format("{} free of {}", FormatBytes(device.free_bytes()),
                                FormatBytes(device.budget_bytes()))});
    }
    if (!backend.lost().empty()) table.AddRow({"device lost", backend.lost()});
  }
  std::string encodings;
  for (const int encoding : info.encodings()) {
    encodings +=
        (encodings.empty() ? "" : ", ") + EncodingName(static_cast<v1::Encoding>(encoding));
  }
  table.AddRow({"encodings", encodings});
  table.AddRow({"best encoding", best_encoding});
  if (!info.tenant().empty()) table.AddRow({"tenant", info.tenant()});
  for (const v1::QuotaUse& use : info.quotas()) {
    table.AddRow({"quota of " + use.what(),
                  fmt::format("{} used of {}", FormatCount(use.used()), FormatCount(use.quota()))});
  }
  const v1::ServerLimits& limits = info.limits();
  table.AddRow({"largest upload", FormatBytes(limits.max_mesh_bytes())});
  table.AddRow(
      {"host memory", fmt::format("{} reserved of {}", FormatBytes(info.reserved_host_bytes()),
                                  FormatBytes(limits.max_host_bytes()))});
  table.AddRow({"retired snapshots", fmt::format("{}, while slow readers were receiving them",
                                                 FormatCount(info.retired_snapshots()))});
  table.AddRow({"forgotten undo steps", fmt::format("{}, because host memory was short",
                                                    FormatCount(info.forgotten_undo_steps()))});
  table.AddRow({"segments", fmt::format("{} to {}", limits.min_segments(), limits.max_segments())});
  table.AddRow(
      {"control points",
       fmt::format("up to {}", FormatCount(static_cast<uint64_t>(limits.max_control_points())))});
  table.AddRow(
      {"connections", fmt::format("up to {}, of up to {} calls each", limits.max_connections(),
                                  limits.max_calls_per_connection())});
  return table.Text();
}

absl::Status RunInfo(const InfoFlags& flags, Client& client, Console console) {
  if (flags.health) {
    LATTICED_RETURN_IF_ERROR(client.CheckHealth());
    console.out << "serving\n";
    return absl::OkStatus();
  }
  LATTICED_ASSIGN_OR_RETURN(const auto info, client.GetServerInfo());
  const std::string best = flags.json ? "" : BestEncoding(client);
  PrintResult(flags.json, info, InfoText(info, best), console.out);
  return absl::OkStatus();
}

}  // namespace

void AddInfoCommand(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<InfoFlags>();
  CLI::App* command = app.add_subcommand("info", "Says what a server is and can do");
  command->add_flag("--health", flags->health,
                    "Only ask whether it serves, without a token: for health checks");
  SetExample(*command, "info --server 127.0.0.1:50151");
  SetServerAction(*command, flags, line, RunInfo);
}

}  // namespace latticed::client
