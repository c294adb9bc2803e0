// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/session.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

struct ShareFlags : ServerFlags {
  std::string scene, share, viewer;
  v1::ShareRole role = v1::SHARE_ROLE_READ;
  std::optional<int64_t> ttl_seconds;  // none: what the server has
};

const std::map<std::string, v1::ShareRole> kRoles = {{"read", v1::SHARE_ROLE_READ},
                                                     {"edit", v1::SHARE_ROLE_EDIT}};
const std::map<std::string, int64_t> kSecondsOf = {{"s", 1}, {"m", 60}, {"h", 3600}, {"d", 86400}};

std::string TimeText(const google::protobuf::Timestamp& time) {
  return absl::FormatTime("%Y-%m-%d %H:%M", absl::FromUnixSeconds(time.seconds()),
                          absl::LocalTimeZone());
}

std::string RoleText(v1::ShareRole role) { return role == v1::SHARE_ROLE_EDIT ? "edit" : "read"; }

// Of the viewer: what is after '#' reaches no server, and no log of one.
std::string Link(std::string viewer, const std::string& scene, const std::string& token) {
  while (viewer.ends_with('/')) viewer.pop_back();
  return fmt::format("{}/?scene={}#token={}", viewer, scene, token);
}

absl::Status RunCreateShare(const ShareFlags& flags, Client& client, Console console) {
  v1::CreateShareRequest request;
  request.set_scene(flags.scene);
  request.set_role(flags.role);
  if (flags.ttl_seconds.has_value()) request.mutable_ttl()->set_seconds(*flags.ttl_seconds);
  LATTICED_ASSIGN_OR_RETURN(const auto made, client.CreateShare(request));
  TextTable table;
  table.AddRow({"share", made.share().share_id()});
  table.AddRow({"may", RoleText(made.share().role())});
  table.AddRow({"until", TimeText(made.share().expire_time())});
  table.AddRow({"token", made.token()});
  if (!flags.viewer.empty()) {
    table.AddRow({"link", Link(flags.viewer, flags.scene, made.token())});
  }
  PrintResult(flags.json, made, table.Text(), console.out);
  return absl::OkStatus();
}

absl::Status RunListShares(const ShareFlags& flags, Client& client, Console console) {
  LATTICED_ASSIGN_OR_RETURN(const auto shares, client.ListShares(flags.scene));
  if (flags.json) {
    PrintJsonArray(shares, console.out);
    return absl::OkStatus();
  }
  TextTable table({"SHARE", "MAY", "UNTIL", "MADE BY", "MADE"});
  for (const v1::Share& share : shares) {
    table.AddRow({share.share_id(), RoleText(share.role()), TimeText(share.expire_time()),
                  share.creator(), TimeText(share.create_time())});
  }
  console.out << table.Text();
  return absl::OkStatus();
}

absl::Status RunRevokeShare(const ShareFlags& flags, Client& client, Console console) {
  LATTICED_RETURN_IF_ERROR(client.RevokeShare(flags.scene, flags.share));
  PrintResult(flags.json, nlohmann::json{{"revoked", std::vector{flags.share}}},
              fmt::format("share {} is revoked\n", flags.share), console.out);
  return absl::OkStatus();
}

}  // namespace

void AddShareCommands(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<ShareFlags>();
  CLI::App* share =
      app.add_subcommand("share", "Shares a scene with people who have no token of the server");
  share->require_subcommand(0, 1);
  const auto add = [&](const char* name, const char* what, const char* example,
                       absl::Status (*run)(const ShareFlags&, Client&, Console)) {
    CLI::App* command = share->add_subcommand(name, what);
    SetExample(*command, example);
    SetServerAction(*command, flags, line, run);
    command->add_option("scene", flags->scene, "Id of the scene")->required();
    return command;
  };
  CLI::App* create = add("create", "Makes a token for one scene, and prints it once",
                         "share create my-scene --role edit --ttl 2d --viewer https://studio:50180",
                         RunCreateShare);
  create->add_option("--role", flags->role, "What its owner may do: read (by default) or edit")
      ->transform(CLI::CheckedTransformer(kRoles))
      ->type_name("ROLE");
  create
      ->add_option("--ttl", flags->ttl_seconds,
                   "How long it lasts, as 90m, 12h or 30d; by default 7d, at most 366d")
      ->transform(CLI::AsNumberWithUnit(kSecondsOf, CLI::AsNumberWithUnit::UNIT_REQUIRED))
      ->type_name("TIME");
  create
      ->add_option("--viewer", flags->viewer,
                   "Address of the viewer, for a link that opens the scene")
      ->type_name("URL");
  add("list", "Lists the shares of a scene", "share list my-scene", RunListShares);
  add("revoke", "Ends a share, and the streams that it opened",
      "share revoke my-scene 67485f3a1b2c3d4e", RunRevokeShare)
      ->add_option("share", flags->share, "Id of the share")
      ->required();
}

}  // namespace latticed::client
