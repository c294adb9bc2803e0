// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <ostream>

#include "client/cpp/latticectl/commands.h"
#include "client/cpp/latticectl/json_output.h"
#include "client/cpp/latticectl/lattice_json.h"
#include "client/cpp/latticectl/progress_bar.h"
#include "client/cpp/latticectl/sample_or_file.h"
#include "client/cpp/latticectl/session.h"
#include "client/cpp/latticectl/view_flags.h"
#include "client/cpp/load/load_run.h"
#include "client/cpp/load/load_scenes.h"
#include "client/cpp/load/report_output.h"
#include "core/base/status_macros.h"
#include "core/mesh/sample_meshes.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr int kMostStreams = 10'000;
constexpr int kMostProcesses = 1 << 22;  // of Linux

struct BenchFlags {
  SessionFlags session;
  std::vector<std::string> meshes{"knot"};
  int resolution = kDefaultSampleResolution;
  FitFlags fit;
  ViewFlags view;
  std::string pipeline, points = "all", decode = "first", markdown;
  double rate = 0, interval_ms = 0, seconds = 0;
  int server_process = 0;
  bool json = false;
  LoadPlan plan;  // the rest of it follows from what stands above
};

LoadPlan ToPlan(const BenchFlags& flags) {
  LoadPlan plan = flags.plan;
  plan.all_points = flags.points == "all";
  plan.decoding = flags.decode == "first" ? Decoding::kFirst
                  : flags.decode == "all" ? Decoding::kAll
                                          : Decoding::kNone;
  plan.view = ToProto(flags.view);
  if (flags.rate > 0) {
    plan.mode = LoadMode::kOpen;
    plan.period = absl::Seconds(1) / flags.rate;
  }
  if (flags.interval_ms > 0) {
    plan.mode = LoadMode::kInterval;
    plan.period = absl::Milliseconds(flags.interval_ms);
  }
  if (flags.seconds > 0) {
    plan.duration = absl::Seconds(flags.seconds);
    plan.edits = std::numeric_limits<uint64_t>::max();
  }
  return plan;
}

std::string MeshNames(const BenchFlags& flags) {
  std::string names;
  for (const std::filesystem::path path : flags.meshes) {
    names += (names.empty() ? "" : ", ") + path.filename().string();
  }
  return names;
}

absl::Status Print(const BenchFlags& flags, const LoadPlan& plan, const LoadReport& report,
                   Console console) {
  if (flags.json) {
    PrintLoadJson(plan, report, console.out);
  } else {
    PrintLoadText(plan, report, console.out);
  }
  if (flags.markdown.empty()) return absl::OkStatus();
  std::ofstream file(flags.markdown, std::ios::app);
  file << LoadMarkdown(plan, report);
  file.close();
  if (file) return absl::OkStatus();
  return absl::UnknownError(fmt::format("{} cannot be written", flags.markdown));
}

absl::StatusOr<LoadReport> Measure(Session& session, const BenchFlags& flags, const LoadPlan& plan,
                                   const std::stop_token& stop, Console console) {
  v1::CreateSceneRequest request;
  *request.add_lattices()->mutable_fit() = ToProto(flags.fit);
  request.mutable_diagnostics()->set_pipeline(PipelineToProto(flags.pipeline));
  LoadScenes scenes(session.client());
  for (int i = 0; i < plan.scenes; ++i) {
    const std::string& mesh = flags.meshes[static_cast<size_t>(i) % flags.meshes.size()];
    LATTICED_ASSIGN_OR_RETURN(auto file, SampleOrFile(mesh, flags.resolution));
    LATTICED_RETURN_IF_ERROR(scenes.Make(std::move(file), request, console));
  }
  LoadRun run(
      plan, scenes.scenes(), [&session] { return session.NewClient(); },
      {.fused = flags.pipeline.empty() || flags.pipeline == "fused",
       .server_inside = flags.session.server.empty(),
       .server_process = flags.server_process,
       .superseded = [&session] { return session.Counter("latticed_updates_superseded_total"); }},
      stop);
  const bool timed = flags.seconds > 0;
  ProgressBar bar(console, timed ? "milliseconds" : "edits", ProgressBar::Unit::kCount);
  return run.Run(bar.callback());
}

absl::Status Run(const BenchFlags& flags, CommandLine& line) {
  const std::stop_token stop = line.interruption.Catch();
  LATTICED_ASSIGN_OR_RETURN(auto session, Session::Open(flags.session, stop));
  const LoadPlan plan = ToPlan(flags);
  auto report = Measure(session, flags, plan, stop, line.console);
  if (!report.ok()) return session.Explain(report.status());
  report->meshes = MeshNames(flags);
  LATTICED_RETURN_IF_ERROR(Print(flags, plan, *report, line.console));
  return stop.stop_requested() ? absl::CancelledError("interrupted") : absl::OkStatus();
}

void AddLoadFlags(CLI::App& command, BenchFlags& flags) {
  LoadPlan& plan = flags.plan;
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
  command
      .add_option("--decode", flags.decode,
                  "Whose updates are decoded, where they are read: each scene's first editor's, "
                  "those of all but slow watchers, or none")
      ->check(CLI::IsMember({"first", "all", "none"}))
      ->capture_default_str();
}

void AddPaceFlags(CLI::App& command, BenchFlags& flags) {
  CLI::Option* edits =
      command.add_option("--edits", flags.plan.edits, "How many edits each editor makes")
          ->check(CLI::Range(1, 1'000'000))
          ->capture_default_str();
  command.add_option("--duration", flags.seconds, "Edits for so many seconds instead")
      ->check(CLI::PositiveNumber)
      ->excludes(edits);
  CLI::Option* rate =
      command
          .add_option("--rate", flags.rate,
                      "Open loop: so many edits a second of each editor, whatever the server does")
          ->check(CLI::Range(0.01, 10'000.0));
  command
      .add_option(
          "--interval", flags.interval_ms,
          "An edit every so many milliseconds, as a browser's drag: all are one gesture, and "
          "the newest replaces what could not be sent yet")
      ->check(CLI::Range(0.1, 60'000.0))
      ->excludes(rate);
  command
      .add_option(
          "--points", flags.points,
          "What an edit moves: every second control point, so that all chunks change, or one, "
          "each in its turn")
      ->check(CLI::IsMember({"all", "one"}))
      ->capture_default_str();
}

}  // namespace

void AddBenchCommand(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<BenchFlags>();
  CLI::App* command = app.add_subcommand(
      "bench",
      "Puts a server under load and measures the time from an edit to its update: each editor's "
      "next edit when the update of its last one is here, or at times of their own (--rate, "
      "--interval)");
  command->footer(
      "Counted as \"edits merged\": those that share their update with a later one; as \"updates "
      "restarted\": those that say so (UpdateBegin.restart), begun in place of one that a newer "
      "one superseded before its end, since its reader was slow or it gave way to less detail "
      "(--max-points, --max-bytes-per-second); as \"updates superseded\": the latter alone, of "
      "all streams, as a server in this process counts them.");
  command->add_option("meshes", flags->meshes, "Files, or names of 'latticectl sample'")
      ->capture_default_str();
  command->add_option("--resolution", flags->resolution, "Of sample meshes")
      ->check(CLI::Range(kMinSampleResolution, kMaxSampleResolution))
      ->capture_default_str();
  AddLoadFlags(*command, *flags);
  AddPaceFlags(*command, *flags);
  AddFitFlags(*command, flags->fit);
  AddViewFlags(*command, flags->view);
  AddDragFlags(*command, flags->view);
  AddPipelineFlag(*command, flags->pipeline);
  AddSessionFlags(*command, flags->session, ServerChoice::kInProcess);
  command
      ->add_option("--server-pid", flags->server_process,
                   "The server's process on this machine, whose processor time is told then")
      ->check(CLI::Range(1, kMostProcesses))
      ->needs("--server");
  command->add_option("--markdown", flags->markdown, "Appends the result to this file");
  AddJsonFlag(*command, flags->json);
  command->callback([flags, &line] { line.action = [flags, &line] { return Run(*flags, line); }; });
}

}  // namespace latticed::client
