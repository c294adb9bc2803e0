// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A first look at latticed: uploads a sample mesh, puts a lattice of 4 x 4 x 5 control points around
// it, and runs a scripted drag, one gesture that twists the upper layers and leans the top over.
#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <ostream>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client/cpp/latticectl/command_line/value_types.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "client/cpp/latticectl/output/latency_recorder.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/scene_tolerance.h"
#include "client/cpp/latticectl/session/server_meshes.h"
#include "client/cpp/latticectl/session/session.h"
#include "core/base/status_macros.h"
#include "core/mesh/sample_meshes.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr double kRawBytesPerPoint = 24;  // float32 position and normal
constexpr double kTopTwist = 0.5 * std::numbers::pi;
constexpr double kTopLean = 0.35;  // as a fraction of the lattice's first edge

struct QuickstartFlags {
  SessionFlags session;
  Tolerance tolerance;
  std::string output, sample = "knot";
  int steps = 60;
  bool json = false;
};

v1::CreateSceneRequest SceneRequest() {
  v1::CreateSceneRequest request;
  *request.add_lattices()->mutable_fit() = ToProto(FitFlags{.size = "4,4,5"});
  return request;
}

// Turns about the vertical axis through the middle of the lattice, then shifts along x.
void SetTwist(const v1::LatticeFrame& frame, double angle, double shift,
              google::protobuf::RepeatedField<double>* matrix) {
  const double x = frame.origin().x() + 0.5 * frame.u().x(),
               y = frame.origin().y() + 0.5 * frame.v().y();
  const double c = std::cos(angle), s = std::sin(angle);
  const double columns[16] = {
      c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, x - c * x + s * y + shift, y - s * x - c * y, 0, 1};
  matrix->Assign(std::begin(columns), std::end(columns));
}

// One step of the drag: every layer of control points turns and leans in proportion to its height.
v1::EditBatch MakeStep(const v1::Lattice& lattice, int step, int steps) {
  const auto layer_points = static_cast<uint32_t>(lattice.size().u() * lattice.size().v());
  const auto layers = static_cast<uint32_t>(lattice.size().w());
  const double progress = static_cast<double>(step + 1) / steps;
  v1::EditBatch batch;
  batch.set_gesture_id("quickstart");
  batch.set_gesture_phase(step + 1 == steps ? v1::GESTURE_PHASE_COMMIT : v1::GESTURE_PHASE_UPDATE);
  for (uint32_t layer = 1; layer < layers; ++layer) {
    auto* transform = batch.add_edits()->mutable_transform_control_points();
    for (uint32_t i = 0; i < layer_points; ++i) transform->add_indices(layer * layer_points + i);
    const double height = static_cast<double>(layer) / (layers - 1);
    SetTwist(lattice.frame(), progress * height * kTopTwist,
             progress * height * height * kTopLean * lattice.frame().u().x(),
             transform->mutable_matrix());
  }
  return batch;
}

struct QuickstartReport {
  LatencyRecorder latencies;  // from sending an edit to the end of the update that holds it
  uint64_t bytes = 0;         // of chunk data in all updates
  uint64_t patches = 0, points = 0, triangles = 0;
  double tolerance = 0, certified_error = 0;
  std::vector<std::string> files;
};

absl::Status WriteSurface(Client& client, const v1::Scene& scene, const v1::Mesh& mesh,
                          const MeshFile& file, const Tolerance& tolerance, const std::string& stem,
                          Console console, QuickstartReport* report) {
  v1::ViewOptions view;
  view.set_encoding(v1::ENCODING_RAW);
  LATTICED_RETURN_IF_ERROR(SetTolerance(client, scene.id(), tolerance, &view));
  LATTICED_ASSIGN_OR_RETURN(const auto surface,
                            FetchSurface(client, scene.id(), view, mesh, file, console));
  report->patches = surface.patches;
  report->points = surface.mesh.positions.size();
  report->triangles = surface.mesh.triangles.size();
  report->tolerance = surface.tolerance;
  report->certified_error = surface.certified_error;
  const PolygonMesh welded = Welded(surface.mesh);
  for (const char* extension : {".ply", ".glb"}) {
    report->files.push_back(stem + extension);
    LATTICED_RETURN_IF_ERROR(
        WriteMeshFile(stem + extension, welded, {.units = surface.mesh.units}));
  }
  return absl::OkStatus();
}

// Closed loop: sends each edit when the update with the previous edit is complete.
absl::Status Drag(Client& client, const v1::Scene& scene, const QuickstartFlags& flags,
                  Console console, QuickstartReport* report) {
  const int steps = flags.steps;
  v1::WatchRequest watch;
  watch.set_scene(scene.id());
  LATTICED_RETURN_IF_ERROR(SetTolerance(client, scene.id(), flags.tolerance, watch.mutable_view()));
  LATTICED_ASSIGN_OR_RETURN(const auto stream, client.Deform(std::move(watch)));
  const v1::Lattice lattice = stream->surface().lattice().lattice();
  ProgressBar bar(console, "drag", ProgressBar::Unit::kCount);
  for (int step = 0; step < steps; ++step) {
    const absl::Time begin = absl::Now();
    LATTICED_ASSIGN_OR_RETURN(const auto sequence, stream->Send(MakeStep(lattice, step, steps)));
    LATTICED_ASSIGN_OR_RETURN(const auto update, stream->WaitFor(sequence));
    report->latencies.Add(absl::Now() - begin);
    report->bytes += update.bytes;
    bar.Show(static_cast<uint64_t>(step) + 1, static_cast<uint64_t>(steps));
  }
  return absl::OkStatus();
}

void Print(const QuickstartFlags& flags, const QuickstartReport& report, std::ostream& out) {
  const LatencySummary latency = report.latencies.Summarise();
  const double per_update = static_cast<double>(report.bytes) / static_cast<double>(latency.count);
  const double ratio = kRawBytesPerPoint * static_cast<double>(report.points) / per_update;
  TextTable table;
  table.AddRow({"mesh", flags.sample});
  table.AddRow({"patches", FormatCount(report.patches)});
  table.AddRow({"points", FormatCount(report.points)});
  table.AddRow({"triangles", FormatCount(report.triangles)});
  if (report.tolerance > 0) {
    table.AddRow({"certified error", fmt::format("{:.3g}, tolerance {:.3g}", report.certified_error,
                                                 report.tolerance)});
  }
  table.AddRow({"updates", FormatCount(latency.count)});
  table.AddRow({"edit to update", fmt::format("p50 {}, p99 {}", FormatMilliseconds(latency.p50),
                                              FormatMilliseconds(latency.p99))});
  table.AddRow({"bytes per update", FormatBytes(static_cast<uint64_t>(per_update))});
  table.AddRow(
      {"ratio to raw floats", fmt::format("{:.1f} times smaller (24 bytes a point)", ratio)});
  for (const std::string& file : report.files) table.AddRow({"written", file});
  PrintResult(flags.json,
              nlohmann::json{{"patches", report.patches},
                             {"points", report.points},
                             {"triangles", report.triangles},
                             {"certifiedError", report.certified_error},
                             {"updates", latency.count},
                             {"p50Ms", latency.p50},
                             {"p99Ms", latency.p99},
                             {"bytesPerUpdate", per_update},
                             {"ratioToRaw", ratio},
                             {"files", report.files}},
              table.Text(), out);
}

absl::StatusOr<QuickstartReport> RunOn(Client& client, const QuickstartFlags& flags,
                                       Console console) {
  LATTICED_ASSIGN_OR_RETURN(const auto file, SampleOrFile(flags.sample));
  TemporaryScenes made(client);
  LATTICED_ASSIGN_OR_RETURN(const auto mesh, made.Upload(file, {}, console));
  LATTICED_ASSIGN_OR_RETURN(const auto scene, made.Create(SceneRequest()));
  QuickstartReport report;
  const std::string folder = flags.output + "/";
  LATTICED_RETURN_IF_ERROR(
      WriteSurface(client, scene, mesh, file, flags.tolerance, folder + "rest", console, &report));
  LATTICED_RETURN_IF_ERROR(Drag(client, scene, flags, console, &report));
  LATTICED_RETURN_IF_ERROR(WriteSurface(client, scene, mesh, file, flags.tolerance,
                                        folder + "deformed", console, &report));
  made.Keep();  // so that the user can look at the scene
  return report;
}

absl::Status Run(const QuickstartFlags& flags, CommandLine& line) {
  std::error_code failure;
  std::filesystem::create_directories(flags.output, failure);
  if (failure) {
    return absl::UnknownError(
        fmt::format("cannot make the folder {}: {}", flags.output, failure.message()));
  }
  return WithSession(flags.session, line, line.interruption.Catch(), [&](Session& session) {
    const auto report = RunOn(session.client(), flags, line.console);
    if (report.ok()) Print(flags, *report, line.console.out);
    return report.status();
  });
}

}  // namespace

void AddQuickstartCommand(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<QuickstartFlags>();
  CLI::App* command = app.add_subcommand(
      "quickstart",
      "Deforms a sample mesh by a streamed drag, writes it before and after, and says how it went");
  command->add_option("--output", flags->output, "Folder for rest and deformed .ply and .glb")
      ->required()
      ->type_name(kFolderType);
  const auto names = SampleMeshNames();
  command->add_option("--sample", flags->sample, "Which mesh")
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())))
      ->capture_default_str();
  command->add_option("--steps", flags->steps, "Edits of the drag")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  AddToleranceFlag(*command, flags->tolerance);
  AddSessionFlags(*command, flags->session, ServerChoice::kInProcess);
  AddJsonFlag(*command, flags->json);
  SetExample(*command, "quickstart --output demo");
  SetAction(*command, line, [flags, &line] { return Run(*flags, line); });
}

}  // namespace latticed::client
