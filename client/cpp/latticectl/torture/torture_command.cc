// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/torture/torture_command.h"

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "client/cpp/latticectl/command_line/value_types.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/server_meshes.h"
#include "client/cpp/latticectl/session/session.h"
#include "client/cpp/latticectl/torture/random_edits.h"
#include "client/cpp/latticectl/torture/torture_run.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr double kLongest = 30 * 86'400.0;  // seconds: a month
constexpr int kSampleResolution = 1;        // a small mesh: the edits are tested, not the surface

struct TortureFlags {
  SessionFlags session;
  TorturePlan plan{.seed = std::random_device{}()};
  std::string mesh = "vase";
  bool keep = false, json = false;
};

absl::StatusOr<TortureReport> Torture(const TortureFlags& flags, Session& session,
                                      const std::stop_token& stop, Console console) {
  LATTICED_ASSIGN_OR_RETURN(const auto file, SampleOrFile(flags.mesh, kSampleResolution));
  TemporaryScenes made(session.client());
  LATTICED_RETURN_IF_ERROR(made.Upload(file, {}, console).status());
  v1::CreateSceneRequest request;
  *request.add_lattices()->mutable_fit() = TorturedLattice();
  std::vector<std::string> scenes;
  for (int n = 0; n < flags.plan.scenes; ++n) {
    LATTICED_ASSIGN_OR_RETURN(const auto scene, made.Create(request));
    scenes.push_back(scene.id());
  }
  StatusLine line(console);
  auto report = RunTorture(
      flags.plan, scenes, [&session] { return session.NewClient(); },
      [&line](const std::string& text) { line.Show("torture: " + text); }, stop);
  if (flags.keep) made.Keep();
  return report;
}

absl::Status Run(const TortureFlags& flags, CommandLine& line) {
  const std::stop_token stop = line.interruption.Catch();
  // The stop must not cancel the calls that compare what was acknowledged.
  return WithSession(flags.session, line, /*stop=*/{}, [&](Session& session) -> absl::Status {
    LATTICED_ASSIGN_OR_RETURN(const auto report, Torture(flags, session, stop, line.console));
    PrintResult(flags.json, TortureJson(report), TortureText(report), line.console.out);
    const auto& what = report.faults.what;
    if (!what.empty()) {
      return absl::DataLossError(
          what.size() == 1 ? what[0] : fmt::format("{}; {} scenes in all", what[0], what.size()));
    }
    return stop.stop_requested() ? absl::CancelledError("interrupted") : absl::OkStatus();
  });
}

}  // namespace

void AddTortureCommand(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<TortureFlags>();
  CLI::App* command = app.add_subcommand(
      "torture",
      "Edits scenes of its own while you kill, drain and cut off servers, and compares them with "
      "all that was acknowledged. Exit code 1 if an edit was lost or counted twice, or a bit of a "
      "lattice is wrong. Ctrl-C ends the edits, and then all is compared");
  command->add_option("mesh", flags->mesh, "A file, or a name of 'latticectl sample'")
      ->type_name(kFileType)
      ->capture_default_str();
  command->add_option("--scenes", flags->plan.scenes, "How many scenes")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  command->add_option("--editors", flags->plan.editors, "Editors of each scene")
      ->check(CLI::Range(1, 16))
      ->capture_default_str();
  command
      ->add_option("--rate", flags->plan.rate,
                   "Edits a second of each editor, if the server keeps up")
      ->check(CLI::Range(0.01, 10'000.0))
      ->capture_default_str();
  command->add_option("--seconds", flags->plan.seconds, "How long it edits")
      ->check(CLI::Range(0.0, kLongest))
      ->capture_default_str();
  command->add_option("--seed", flags->plan.seed,
                      "Of the random edits; without it another each time");
  command->add_flag("--keep", flags->keep, "Do not delete the scenes and the mesh");
  AddSessionFlags(*command, flags->session, ServerChoice::kRequired);
  command->get_option("--server")
      ->description("Address of a server or a proxy. Several ip:port: servers that share a store")
      ->join(',');
  AddJsonFlag(*command, flags->json);
  SetExample(*command, "torture --server 127.0.0.1:50151 --scenes 60 --seconds 600");
  SetAction(*command, line, [flags, &line] { return Run(*flags, line); });
}

}  // namespace latticed::client
