// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/bench_app.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <ostream>

#include "client/cpp/latticectl/command_line/message_flags.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/server_meshes.h"
#include "client/cpp/latticectl/session/session.h"
#include "client/cpp/load/load_run.h"
#include "client/cpp/load/report_output.h"
#include "core/base/status_macros.h"
#include "core/mesh/sample_meshes.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr int kMostStreams = 10'000;
constexpr int kMostProcesses = 1 << 22;  // Linux has no larger process id

constexpr NamedValues<Decoding, 3> kDecodings{
    {{"first", Decoding::kFirst}, {"all", Decoding::kAll}, {"none", Decoding::kNone}}};
constexpr NamedValues<bool, 2> kPoints{{{"all", true}, {"one", false}}};

struct BenchFlags {
  SessionFlags session;
  std::vector<std::string> meshes{"knot"};
  int resolution = kDefaultSampleResolution;
  FitFlags fit;
  v1::Pipeline pipeline = v1::PIPELINE_UNSPECIFIED;
  int server_process = 0;
  bool json = false;
  LoadPlan plan;
};

std::string MeshNames(const BenchFlags& flags) {
  std::string names;
  for (const std::filesystem::path path : flags.meshes) {
    names += (names.empty() ? "" : ", ") + path.filename().string();
  }
  return names;
}

absl::StatusOr<std::vector<std::string>> MakeScenes(TemporaryScenes& made, const BenchFlags& flags,
                                                    Console console) {
  v1::CreateSceneRequest request;
  *request.add_lattices()->mutable_fit() = ToProto(flags.fit);
  request.mutable_diagnostics()->set_pipeline(flags.pipeline);
  std::vector<std::string> scenes;
  for (int i = 0; i < flags.plan.scenes; ++i) {
    const std::string& name = flags.meshes[static_cast<size_t>(i) % flags.meshes.size()];
    LATTICED_ASSIGN_OR_RETURN(const auto file, SampleOrFile(name, flags.resolution));
    LATTICED_RETURN_IF_ERROR(made.Upload(file, {}, console).status());
    LATTICED_ASSIGN_OR_RETURN(const auto scene, made.Create(request));
    scenes.push_back(scene.id());
  }
  return scenes;
}

absl::StatusOr<LoadReport> Measure(Session& session, const BenchFlags& flags,
                                   const std::stop_token& stop, Console console) {
  TemporaryScenes made(session.client());
  LATTICED_ASSIGN_OR_RETURN(const auto scenes, MakeScenes(made, flags, console));
  ProgressBar bar(console, "edits", ProgressBar::Unit::kCount);
  return RunLoad(
      flags.plan, scenes, [&session] { return session.NewClient(); },
      {.own_holds_server = flags.session.server.empty(), .server = flags.server_process},
      bar.callback(), stop);
}

absl::Status Run(const BenchFlags& flags, CommandLine& line) {
  const std::stop_token stop = line.interruption.Catch();
  return WithSession(flags.session, stop, [&](Session& session) -> absl::Status {
    LATTICED_ASSIGN_OR_RETURN(auto report, Measure(session, flags, stop, line.console));
    report.meshes = MeshNames(flags);
    if (flags.json) {
      PrintJson(LoadJson(flags.plan, report), line.console.out);
    } else {
      line.console.out << LoadMarkdown(flags.plan, report);
    }
    return stop.stop_requested() ? absl::CancelledError("interrupted") : absl::OkStatus();
  });
}

void AddLoadFlags(CLI::App& command, LoadPlan& plan) {
  const auto count = [&command](const char* name, int& value, int least, const char* text) {
    command.add_option(name, value, text)
        ->check(CLI::Range(least, kMostStreams))
        ->capture_default_str();
  };
  count("--scenes", plan.scenes, 1, "How many scenes; the meshes take turns");
  count("--editors", plan.editors, 1, "Editors of each scene, who watch it as well");
  count("--watchers", plan.watchers, 0, "Further watchers of each scene that keep up");
  count("--slow", plan.slow, 0, "Watchers of each scene that read slowly");
  count("--stalled", plan.stalled, 0, "Watchers of each scene that stop reading");
  command.add_option("--slow-bytes-per-second", plan.slow_rate, "What a slow watcher reads")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  AddNamedOption<Decoding>(
      command, "--decode", kDecodings, [&plan](Decoding decoding) { plan.decoding = decoding; },
      "Whose updates are decoded, in the thread that reads them: those of each scene's first "
      "editor, of all but slow watchers, or none")
      ->default_str("first");
}

void AddPaceFlags(CLI::App& command, LoadPlan& plan) {
  CLI::Option* edits =
      command.add_option("--edits", plan.edits, "How many edits each editor makes")
          ->check(CLI::Range(1, 1'000'000))
          ->capture_default_str();
  command
      .add_option_function<double>(
          "--duration",
          [&plan](double seconds) {
            plan.duration = absl::Seconds(seconds);
            plan.edits = std::numeric_limits<uint64_t>::max();
          },
          "Edits for this many seconds instead")
      ->check(CLI::PositiveNumber)
      ->excludes(edits);
  CLI::Option* rate =
      command
          .add_option_function<double>(
              "--rate",
              [&plan](double rate) {
                plan.mode = LoadMode::kOpen;
                plan.period = absl::Seconds(1) / rate;
              },
              "Open loop: each editor makes this many edits a second, whatever the server does")
          ->check(CLI::Range(0.01, 10'000.0));
  command
      .add_option_function<double>(
          "--interval",
          [&plan](double milliseconds) {
            plan.mode = LoadMode::kInterval;
            plan.period = absl::Milliseconds(milliseconds);
          },
          "Milliseconds between edits, as in a browser's drag: all edits are one gesture, and the "
          "newest replaces those that could not be sent yet")
      ->check(CLI::Range(0.1, 60'000.0))
      ->excludes(rate);
  AddNamedOption<bool>(
      command, "--points", kPoints, [&plan](bool all) { plan.all_points = all; },
      "What an edit moves: every second control point, so that all chunks change, or one, "
      "each in its turn")
      ->default_str("all");
}

}  // namespace

int RunLatticectlBench(int argc, const char* const* argv, Console console) {
  CLI::App app(
      "Puts a server under load and measures the time from an edit to its update. An editor makes "
      "its next edit when the update of its last one is here, or at fixed times (--rate, "
      "--interval)",
      "latticectl bench");
  app.footer(
      "\"edits merged\" share their update with a later edit. \"updates restarted\" say so "
      "(UpdateBegin.restart): a newer update superseded one before its end, because its reader was "
      "slow or because it gave way to less detail (--max-points, --max-bytes-per-second). "
      "\"updates superseded\" gave way to less detail, counted by the server over all of its "
      "streams.\n\nExample: latticectl " +
      std::string(kBenchExample));
  CommandLine line{.console = console};
  BenchFlags flags;
  app.add_option("meshes", flags.meshes, "Files, or names of 'latticectl sample'")
      ->capture_default_str();
  app.add_option("--resolution", flags.resolution, "Resolution of sample meshes")
      ->check(CLI::Range(kMinSampleResolution, kMaxSampleResolution))
      ->capture_default_str();
  AddLoadFlags(app, flags.plan);
  AddPaceFlags(app, flags.plan);
  AddFitFlags(app, flags.fit);
  AddViewFlags(app, flags.plan.view, ViewDefaults::kOfServer);
  AddDragFlags(app, flags.plan.view);
  AddPipelineFlag(app, flags.pipeline);
  AddSessionFlags(app, flags.session, ServerChoice::kInProcess);
  app.add_option("--server-pid", flags.server_process,
                 "The server's process on this machine; its processor time is reported")
      ->check(CLI::Range(1, kMostProcesses))
      ->needs("--server");
  AddJsonFlag(app, flags.json);
  SetAction(app, line, [&flags, &line] { return Run(flags, line); });
  return RunCommandLine(app, line, argc, argv);
}

}  // namespace latticed::client
