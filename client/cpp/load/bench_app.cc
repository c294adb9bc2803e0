// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/bench_app.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <ostream>

#include "client/cpp/latticectl/command_line/command_line.h"
#include "client/cpp/latticectl/commands/bench_flags.h"
#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/server_meshes.h"
#include "client/cpp/latticectl/session/session.h"
#include "client/cpp/library/encodings/encoding_choice.h"
#include "client/cpp/load/load_run.h"
#include "client/cpp/load/report_output.h"
#include "core/base/status_macros.h"
#include "core/mesh/sample_meshes.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

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
  LoadPlan plan = flags.plan;
  LATTICED_ASSIGN_OR_RETURN(const std::string reason,
                            ChooseOpenEncoding(session.client(), scenes.front(), plan.view));
  ProgressBar bar(console, "edits", ProgressBar::Unit::kCount);
  LATTICED_ASSIGN_OR_RETURN(
      auto report,
      RunLoad(
          plan, scenes, [&session] { return session.NewClient(); },
          {.own_holds_server = flags.session.server.empty(), .server = flags.server_process},
          bar.callback(), stop));
  report.encoding_reason = reason;
  return report;
}

absl::Status Run(const BenchFlags& flags, CommandLine& line) {
  const std::stop_token stop = line.interruption.Catch();
  return WithSession(flags.session, line, stop, [&](Session& session) -> absl::Status {
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

}  // namespace

int RunLatticectlBench(int argc, const char* const* argv, Console console) {
  CLI::App app("", "latticectl bench");
  CommandLine line{.console = console};
  BenchFlags flags;
  DeclareBench(app, flags);
  SetAction(app, line, [&flags, &line] { return Run(flags, line); });
  return RunCommandLine(app, line, argc, argv);
}

}  // namespace latticed::client
