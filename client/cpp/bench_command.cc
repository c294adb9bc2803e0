// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>

#include "client/cpp/commands.h"
#include "client/cpp/drag_run.h"
#include "client/cpp/json_output.h"
#include "client/cpp/lattice_json.h"
#include "client/cpp/progress_bar.h"
#include "client/cpp/session.h"
#include "client/cpp/temporary_scene.h"
#include "client/cpp/text_table.h"
#include "client/cpp/view_flags.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr int kWarmUpEdits = 3;

struct BenchFlags {
  SessionFlags session;
  std::string mesh = "knot", pipeline, points = "all";
  FitFlags fit;
  ViewFlags view;
  int edits = 100;
  bool json = false;
};

absl::StatusOr<v1::Scene> MakeScene(TemporaryScene& made, const BenchFlags& flags,
                                    Console console) {
  const auto file = SampleOrFile(flags.mesh);
  if (!file.ok()) return file.status();
  const auto mesh = made.Upload(*file, {}, console);
  if (!mesh.ok()) return mesh.status();
  v1::CreateSceneRequest request;
  *request.add_lattices()->mutable_fit() = ToProto(flags.fit);
  request.mutable_diagnostics()->set_pipeline(PipelineToProto(flags.pipeline));
  return made.Create(std::move(request));
}

// Shakes all control points, or one after the other, by a tenth of the lattice's first edge.
v1::EditBatch MakeEdit(const v1::Lattice& lattice, bool all, int step) {
  const auto points = static_cast<uint32_t>(lattice.control_points_size()) / 3;
  const v1::Vec3& edge = lattice.frame().u();
  const double reach =
      0.1 * std::sqrt(edge.x() * edge.x() + edge.y() * edge.y() + edge.z() * edge.z());
  v1::EditBatch batch;
  auto* move = batch.add_edits()->mutable_move_control_points();
  if (all) {
    for (uint32_t i = 1; i < points; i += 2) move->add_indices(i);
  } else {
    move->add_indices(static_cast<uint32_t>(step) % points);
  }
  move->mutable_offset()->set_z(step % 2 == 0 ? reach : -reach);
  return batch;
}

void Print(const BenchFlags& flags, const DragResult& drag, const Surface& surface,
           std::ostream& out) {
  double total_ms = 0;
  for (const double latency : drag.latencies_ms) total_ms += latency;
  const double rate = 1000 * static_cast<double>(drag.latencies_ms.size()) / total_ms;
  const v1::Topology& topology = surface.topology();
  if (flags.json) {
    out << nlohmann::json{{"mesh", flags.mesh},
                          {"patches", topology.patch_count()},
                          {"points", topology.point_count()},
                          {"encoding", EncodingName(surface.view().encoding())},
                          {"edits", drag.latencies_ms.size()},
                          {"p50Ms", drag.LatencyAt(0.5)},
                          {"p90Ms", drag.LatencyAt(0.9)},
                          {"p99Ms", drag.LatencyAt(0.99)},
                          {"updatesPerSecond", rate},
                          {"bytesPerUpdate", drag.bytes_per_update()}}
               .dump(2)
        << '\n';
    return;
  }
  TextTable table({"MESH", "PATCHES", "POINTS", "ENCODING", "EDITS", "P50", "P90", "P99",
                   "UPDATES/S", "BYTES/UPDATE"});
  table.AddRow({flags.mesh, FormatCount(topology.patch_count()),
                FormatCount(topology.point_count()), EncodingName(surface.view().encoding()),
                FormatCount(drag.latencies_ms.size()), FormatMilliseconds(drag.LatencyAt(0.5)),
                FormatMilliseconds(drag.LatencyAt(0.9)), FormatMilliseconds(drag.LatencyAt(0.99)),
                fmt::format("{:.1f}", rate),
                FormatBytes(static_cast<uint64_t>(drag.bytes_per_update()))});
  table.Print(out);
}

absl::Status RunOn(Client& client, const BenchFlags& flags, const v1::Scene& scene,
                   Console console) {
  v1::WatchRequest watch;
  watch.set_scene(scene.id());
  *watch.mutable_view() = ToProto(flags.view);
  const auto stream = client.Deform(std::move(watch));
  if (!stream.ok()) return stream.status();
  const v1::Lattice lattice = (*stream)->surface().lattice().lattice();
  const auto make = [&](int step) { return MakeEdit(lattice, flags.points == "all", step); };
  ProgressBar bar(console, "edits", ProgressBar::Unit::kCount);
  const auto warm_up = RunDrag(**stream, kWarmUpEdits, make, [](uint64_t, uint64_t) {});
  if (!warm_up.ok()) return warm_up.status();
  const auto drag = RunDrag(**stream, flags.edits, make, bar.callback());
  if (!drag.ok()) return drag.status();
  Print(flags, *drag, (*stream)->surface(), console.out);
  return absl::OkStatus();
}

absl::Status Run(const BenchFlags& flags, CommandLine& line) {
  auto session = Session::Open(flags.session, &line.interruption);
  if (!session.ok()) return session.status();
  TemporaryScene made(session->client());
  const auto scene = MakeScene(made, flags, line.console);
  if (!scene.ok()) return session->Explain(scene.status());
  return session->Explain(RunOn(session->client(), flags, *scene, line.console));
}

}  // namespace

void AddBenchCommand(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<BenchFlags>();
  CLI::App* command = app.add_subcommand(
      "bench", "Measures the time from an edit to its complete update, one edit at a time");
  command->add_option("mesh", flags->mesh, "A file, or a name of 'latticectl sample'")
      ->capture_default_str();
  command->add_option("--edits", flags->edits, "How many edits")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command
      ->add_option("--points", flags->points,
                   "What an edit moves: all control points' region, or one")
      ->check(CLI::IsMember({"all", "one"}))
      ->capture_default_str();
  AddFitFlags(*command, flags->fit);
  AddViewFlags(*command, flags->view);
  AddPipelineFlag(*command, flags->pipeline);
  AddSessionFlags(*command, flags->session, ServerChoice::kInProcess);
  AddJsonFlag(*command, flags->json);
  command->callback([flags, &line] { line.action = [flags, &line] { return Run(*flags, line); }; });
}

}  // namespace latticed::client
