// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client/cpp/latticectl/command_line/message_flags.h"
#include "client/cpp/latticectl/command_line/value_types.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "client/cpp/latticectl/geometry/weights_source.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/scene_patches.h"
#include "client/cpp/latticectl/session/scene_tolerance.h"
#include "client/cpp/latticectl/session/server_meshes.h"
#include "client/cpp/latticectl/session/session.h"
#include "client/cpp/library/patches/lattice_from_proto.h"
#include "core/base/status_macros.h"
#include "core/ffd/deformed_mesh.h"
#include "core/ffd/outside/outside_map.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

struct ApplyFlags {
  std::string mesh, output, weights;
  std::vector<std::string> lattices;
  v1::MeshUnits units;
  std::optional<double> crease_angle;
  v1::ViewOptions view;
  Tolerance tolerance;
  v1::Pipeline pipeline = v1::PIPELINE_UNSPECIFIED;
  SessionFlags session;
  bool vertices_only = false;
  bool json = false;
};

void PrintApplied(const ApplyFlags& flags, const FetchedSurface& surface, absl::Duration time,
                  Console console) {
  const uint64_t points = surface.mesh.positions.size(), triangles = surface.mesh.triangles.size();
  PrintResult(
      flags.json,
      nlohmann::json{{"output", flags.output},
                     {"patches", surface.patches},
                     {"points", points},
                     {"triangles", triangles},
                     {"streamedBytes", surface.bytes},
                     {"certifiedError", surface.certified_error},
                     {"seconds", absl::ToDoubleSeconds(time)}},
      fmt::format("{}: {} patches, {} points, {} triangles; {} streamed, {:.2f} s{}\n",
                  flags.output, FormatCount(surface.patches), FormatCount(points),
                  FormatCount(triangles), FormatBytes(surface.bytes), absl::ToDoubleSeconds(time),
                  DescribeCertificate(surface.tolerance, surface.certified_error,
                                      flags.view.encoding() == v1::ENCODING_PATCHES)),
      console.out);
}

absl::StatusOr<FetchedSurface> Deform(Client& client, const ApplyFlags& flags, const MeshFile& file,
                                      std::vector<v1::Lattice> lattices, Console console) {
  TemporaryScenes made(client);
  v1::MeshHeader header;
  *header.mutable_units() = flags.units;
  LATTICED_ASSIGN_OR_RETURN(auto mesh, made.Upload(file, std::move(header), console));
  // The server keeps the units of a mesh's first upload; the output has the units asked for.
  if (flags.units.up_axis() != v1::UP_AXIS_UNSPECIFIED) mesh.set_up_axis(flags.units.up_axis());
  if (flags.units.meters_per_unit() > 0) mesh.set_meters_per_unit(flags.units.meters_per_unit());
  v1::CreateSceneRequest request;
  for (v1::Lattice& lattice : lattices) {
    *request.add_lattices()->mutable_lattice() = std::move(lattice);
  }
  if (flags.crease_angle.has_value()) request.set_crease_angle(*flags.crease_angle);
  LATTICED_RETURN_IF_ERROR(SetWeights(flags.weights, &request));
  *request.mutable_units() = flags.units;
  request.mutable_diagnostics()->set_pipeline(flags.pipeline);
  LATTICED_ASSIGN_OR_RETURN(const auto scene, made.Create(std::move(request)));
  v1::ViewOptions view = flags.view;
  LATTICED_RETURN_IF_ERROR(SetTolerance(client, scene.id(), flags.tolerance, &view));
  return FetchSurface(client, scene.id(), view, mesh, file, console);
}

absl::StatusOr<std::vector<v1::Lattice>> ReadLattices(const std::vector<std::string>& paths) {
  std::vector<v1::Lattice> lattices;
  for (const std::string& path : paths) {
    LATTICED_ASSIGN_OR_RETURN(lattices.emplace_back(), ReadLattice(path));
  }
  return lattices;
}

// A lattice and how it goes on outside: it moves x to EvaluateWorld(map.continued(), control_points, x).
struct VertexLattice {
  OutsideMap map;
  std::vector<Vec3d> control_points;
};

// Of a mesh with these vertices: they decide how far a lattice goes on.
absl::StatusOr<std::vector<VertexLattice>> VertexLattices(const ApplyFlags& flags,
                                                          std::span<const Vec3d> vertices) {
  LATTICED_ASSIGN_OR_RETURN(const auto protos, ReadLattices(flags.lattices));
  std::vector<VertexLattice> lattices;
  for (const v1::Lattice& proto : protos) {
    LATTICED_ASSIGN_OR_RETURN(const auto lattice, FromProto(proto, vertices));
    OutsideMap map(lattice.structure);
    std::vector<Vec3d> control_points = map.Continue(lattice.control_points);
    lattices.push_back({std::move(map), std::move(control_points)});
  }
  return lattices;
}

// x plus what all of them move it.
DeformedPoint SumAt(std::span<const VertexLattice> lattices, Vec3d x) {
  const DeformedPoint rest{.position = x};
  const auto at = [x](const VertexLattice& lattice) {
    return EvaluateWorld(lattice.map.continued(), lattice.control_points, x);
  };
  DeformedPoint sum = at(lattices[0]);
  for (const VertexLattice& lattice : lattices.subspan(1)) {
    const DeformedPoint one = at(lattice);
    sum.position += one.position - rest.position;
    for (size_t a = 0; a < 3; ++a) sum.jacobian[a] += one.jacobian[a] - rest.jacobian[a];
  }
  return sum;
}

absl::Status RunVerticesOnly(const ApplyFlags& flags, Console console) {
  const absl::Time start = absl::Now();
  LATTICED_ASSIGN_OR_RETURN(const auto file, ReadMeshFile(flags.mesh));
  LATTICED_ASSIGN_OR_RETURN(auto mesh, ParseMesh(file));
  LATTICED_ASSIGN_OR_RETURN(const auto lattices, VertexLattices(flags, mesh.positions));
  MeshUnits units{UpAxisName(flags.units.up_axis()), flags.units.meters_per_unit()};
  if (file.format == MeshFormat::kGlb) units = WithGltfDefaults(units);
  mesh.normals.clear();  // those of the file are wrong after a deformation
  mesh.corner_normals.clear();
  const auto deform = [&](Vec3d world) { return SumAt(lattices, world); };
  LATTICED_ASSIGN_OR_RETURN(mesh, DeformedMesh(std::move(mesh), deform));
  LATTICED_RETURN_IF_ERROR(WriteMeshFile(
      flags.output, mesh, {.units = units, .source = file.bytes, .source_format = file.format}));
  const double seconds = absl::ToDoubleSeconds(absl::Now() - start);
  PrintResult(
      flags.json,
      nlohmann::json{{"output", flags.output},
                     {"vertices", mesh.positions.size()},
                     {"faces", mesh.face_count()},
                     {"seconds", seconds}},
      fmt::format("{}: {} vertices moved, {} faces; {:.2f} s\n", flags.output,
                  FormatCount(mesh.positions.size()), FormatCount(mesh.face_count()), seconds),
      console.out);
  return absl::OkStatus();
}

absl::Status Run(const ApplyFlags& flags, CommandLine& line) {
  if (flags.vertices_only) return RunVerticesOnly(flags, line.console);
  LATTICED_RETURN_IF_ERROR(CheckToleranceOfPatches(flags.view, flags.tolerance.number > 0));
  const absl::Time start = absl::Now();
  LATTICED_ASSIGN_OR_RETURN(const auto file, ReadMeshFile(flags.mesh));
  LATTICED_ASSIGN_OR_RETURN(auto lattices, ReadLattices(flags.lattices));
  return WithSession(
      flags.session, line, line.interruption.Catch(), [&](Session& session) -> absl::Status {
        LATTICED_ASSIGN_OR_RETURN(const auto surface, Deform(session.client(), flags, file,
                                                             std::move(lattices), line.console));
        LATTICED_RETURN_IF_ERROR(WriteMeshFile(
            flags.output, Welded(surface.mesh),
            {.units = surface.mesh.units, .source = file.bytes, .source_format = file.format}));
        PrintApplied(flags, surface, absl::Now() - start, line.console);
        return absl::OkStatus();
      });
}

void AddVerticesOnlyFlag(CLI::App& command, bool& vertices_only) {
  CLI::Option* flag = command.add_flag(
      "--vertices-only", vertices_only,
      "Ordinary deformation: moves the vertices and keeps the faces, without a server");
  for (const char* of_server :
       {"--segments", "--tolerance", "--normals", "--crease-angle", "--weights", "--encoding",
        "--position-bits", "--normal-bits", "--pipeline", "--server", "--backend"}) {
    CLI::Option* option = command.get_option(of_server);
    flag->excludes(option);
    option->remove_excludes(flag);  // the help says it once; one direction suffices for the check
  }
}

}  // namespace

void AddApplyCommand(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<ApplyFlags>();
  flags->view.set_encoding(v1::ENCODING_RAW);
  CLI::App* command = app.add_subcommand("apply", "Deforms a mesh by a lattice, or by several");
  command->add_option("mesh", flags->mesh, "OBJ, PLY, STL, GLB or DRC file")
      ->required()
      ->type_name(kFileType);
  command->add_option("--lattice", flags->lattices, kLatticesHelp)
      ->required()
      ->take_all()
      ->type_name(kFileType);
  command->add_option("-o,--output", flags->output, "PLY, OBJ, STL, GLB, USDA or DRC file to write")
      ->required()
      ->type_name(kFileType)
      ->check(CheckMeshFileName);
  AddUnitsFlags(*command, flags->units);
  AddCreaseFlag(*command, flags->crease_angle);
  AddWeightsFlag(*command, flags->weights);
  AddViewFlags(*command, flags->view, ViewDefaults::kOfServer);
  AddToleranceFlag(*command, flags->tolerance);
  command->get_option("--encoding")->default_str("raw");
  AddPipelineFlag(*command, flags->pipeline);
  AddSessionFlags(*command, flags->session, ServerChoice::kInProcess);
  AddVerticesOnlyFlag(*command, flags->vertices_only);
  SetExample(*command, "apply vase.obj --lattice L.json -o out.ply");
  AddJsonFlag(*command, flags->json);
  SetAction(*command, line, [flags, &line] { return Run(*flags, line); });
}

}  // namespace latticed::client
