// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/commands/bench_flags.h"
#include "client/cpp/latticectl/command_line/value_types.h"

#include <CLI/CLI.hpp>
#include <limits>

#include "absl/time/time.h"
#include "client/cpp/latticectl/command_line/message_flags.h"
#include "client/cpp/latticectl/output/output.h"

namespace latticed::client {
namespace {

constexpr int kMostStreams = 10'000;
constexpr int kMostProcesses = 1 << 22;  // Linux has no larger process id

constexpr NamedValues<Decoding, 3> kDecodings{
    {{"first", Decoding::kFirst}, {"all", Decoding::kAll}, {"none", Decoding::kNone}}};
constexpr NamedValues<bool, 2> kPoints{{{"all", true}, {"one", false}}};

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

void DeclareBench(CLI::App& bench, BenchFlags& flags) {
  bench.description(
      "Puts a server under load and measures the time from an edit to its update. An editor makes "
      "its next edit when the update of its last one is here, or at fixed times (--rate, "
      "--interval)");
  bench.footer(
      "\"edits merged\" share their update with a later edit. \"updates restarted\" say so "
      "(UpdateBegin.restart): a newer update superseded one before its end, because its reader was "
      "slow or because it gave way to less detail (--max-points, --max-bytes-per-second). "
      "\"updates superseded\" gave way to less detail, counted by the server over all of its "
      "streams.\n\nExample: latticectl " +
      std::string(kBenchExample));
  bench.add_option("meshes", flags.meshes, "Files, or names of 'latticectl sample'")
      ->type_name(kFileType)
      ->capture_default_str();
  bench.add_option("--resolution", flags.resolution, "Resolution of sample meshes")
      ->check(CLI::Range(kMinSampleResolution, kMaxSampleResolution))
      ->capture_default_str();
  AddLoadFlags(bench, flags.plan);
  AddPaceFlags(bench, flags.plan);
  AddFitFlags(bench, flags.fit);
  AddViewFlags(bench, flags.plan.view, ViewDefaults::kOfServer);
  bench.get_option("--encoding")->check([](const std::string& name) {
    return name == "patches" ? "patches have no points to compare with the server's" : "";
  });
  bench.get_option("--encoding")->default_str("the faster one");
  AddToleranceFlag(bench, flags.plan.tolerance);
  AddDragFlags(bench, flags.plan.view);
  AddPipelineFlag(bench, flags.pipeline);
  AddSessionFlags(bench, flags.session, ServerChoice::kInProcess);
  bench
      .add_option("--server-pid", flags.server_process,
                  "The server's process on this machine; its processor time is reported")
      ->check(CLI::Range(1, kMostProcesses))
      ->needs("--server");
  AddJsonFlag(bench, flags.json);
}

}  // namespace latticed::client
