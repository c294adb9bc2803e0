// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <memory>
#include <ostream>
#include <string>

#include "client/cpp/latticectl/command_line/message_flags.h"
#include "client/cpp/latticectl/command_line/value_types.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/commands/folds_line.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/session.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr int kFoldsExitCode = 3;  // exit code: the answer is no
constexpr NamedValues<v1::FoldScope, 2> kScopeNames{
    {{"surface", v1::FOLD_SCOPE_SURFACE}, {"volume", v1::FOLD_SCOPE_VOLUME}}};

struct FoldsFlags : ServerFlags {
  v1::CertifyFoldsRequest request;
};

std::string FoldsText(const v1::FoldReport& report) {
  std::string text = FoldsLine(report);
  if (report.places_size() == 0) return text;
  TextTable table({"BOX", "STATE", "DET J", "AT"});
  for (const v1::FoldedBox& place : report.places()) {
    const v1::Vec3& at = place.rest_point();
    table.AddRow({fmt::format("{},{},{}", place.box().u(), place.box().v(), place.box().w()),
                  place.state() == v1::FOLD_STATE_FOLDED ? "folded" : "undecided",
                  fmt::format("{:.4g}", place.determinant()),
                  fmt::format("{:.6g}, {:.6g}, {:.6g}", at.x(), at.y(), at.z())});
  }
  return text + table.Text();
}

}  // namespace

std::string FoldsLine(const v1::FoldReport& report) {
  const std::string boxes = Counted(report.boxes(), "knot box", "knot boxes");
  if (report.certified()) return fmt::format("no fold in {}\n", boxes);
  const std::string undecided =
      report.undecided() == 0 ? "" : fmt::format(", {} undecided", FormatCount(report.undecided()));
  return fmt::format("folded: {} of {}{}\n", FormatCount(report.folded()), boxes, undecided);
}

void AddFoldsCommand(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<FoldsFlags>();
  CLI::App* command = app.add_subcommand(
      "folds", "Proves that the deformation folds nowhere, or says where; exits with 3 then");
  command
      ->add_option_function<std::string>(
          "scene", [flags = flags.get()](const auto& id) { flags->request.set_scene(id); },
          "Id of the scene")
      ->required();
  AddNamedOption<v1::FoldScope>(
      *command, "--scope", kScopeNames,
      [flags = flags.get()](auto scope) { flags->request.set_scope(scope); },
      "Where to look: around the surface, or in the whole frame")
      ->default_str("surface");
  SetExample(*command, "folds my-scene --scope volume");
  SetServerAction(*command, flags, line,
                  [&line](const FoldsFlags& from, Client& client, Console console) -> absl::Status {
                    LATTICED_ASSIGN_OR_RETURN(const auto report, client.CertifyFolds(from.request));
                    PrintResult(from.json, report, FoldsText(report), console.out);
                    if (!report.certified()) line.exit_code = kFoldsExitCode;
                    return absl::OkStatus();
                  });
}

}  // namespace latticed::client
