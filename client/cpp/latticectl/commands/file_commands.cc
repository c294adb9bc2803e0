// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Commands that write a file without a server.
#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <ostream>
#include <vector>

#include "absl/strings/numbers.h"
#include "client/cpp/latticectl/command_line/value_types.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/geometry/bent_lattice.h"
#include "client/cpp/latticectl/geometry/files.h"
#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "client/cpp/latticectl/geometry/outside_text.h"
#include "client/cpp/latticectl/geometry/turn_lattice.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/library/patches/lattice_from_proto.h"
#include "core/base/status_macros.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/sample_meshes.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr double kMostDegrees = 3'600;  // ten turns

double Radians(double degrees) { return degrees * std::numbers::pi / 180; }

struct LatticeFlags {
  std::string mesh;
  FitFlags fit;
  std::vector<double> box;  // in place of the fit's: the lowest and the highest corner
  std::string outside;
  double twist = 0, bend = 0;  // degrees
  std::vector<double> turn;    // degrees about x, y and z; empty: not turned
  std::string output;
  bool json = false;
};

// The box of a lattice: that of --box, or the mesh's with --padding.
absl::StatusOr<Lattice> LatticeOf(const LatticeFlags& flags, const PolygonMesh& mesh) {
  Bounds bounds = mesh.ComputeBounds();
  double padding = flags.fit.padding;
  if (!flags.box.empty()) {
    bounds = {{flags.box[0], flags.box[1], flags.box[2]},
              {flags.box[3], flags.box[4], flags.box[5]}};
    padding = 0;
    const bool is_box = IsFinite(bounds.extent()) && bounds.extent().x > 0 &&
                        bounds.extent().y > 0 && bounds.extent().z > 0;
    if (!is_box) {
      return absl::InvalidArgumentError(
          "--box: each coordinate of the second corner must be above the first one's");
    }
  }
  return FitLattice(bounds, ParseAxes(flags.fit.size), ParseAxes(flags.fit.degree), padding);
}

absl::Status RunLattice(const LatticeFlags& flags, Console console) {
  LATTICED_ASSIGN_OR_RETURN(const auto file, ReadMeshFile(flags.mesh));
  LATTICED_ASSIGN_OR_RETURN(const auto mesh, ParseMesh(file));
  LATTICED_ASSIGN_OR_RETURN(auto lattice, LatticeOf(flags, mesh));
  BendLattice(Radians(flags.twist), Radians(flags.bend), lattice);
  if (!flags.turn.empty()) TurnLattice({flags.turn[0], flags.turn[1], flags.turn[2]}, lattice);
  v1::Lattice proto = ToProto(lattice);
  if (!flags.outside.empty()) {
    LATTICED_ASSIGN_OR_RETURN(*proto.mutable_outside(), ParseOutside(flags.outside));
    LATTICED_RETURN_IF_ERROR(FromProto(proto, mesh.positions).status());
  }
  const std::string json = MessageJson(proto);
  if (flags.output.empty()) {
    console.out << json;
    return absl::OkStatus();
  }
  LATTICED_RETURN_IF_ERROR(WriteFile(flags.output, json));
  const size_t points = lattice.control_points.size();
  PrintResult(flags.json, nlohmann::json{{"output", flags.output}, {"controlPoints", points}},
              fmt::format("{}: {} control points\n", flags.output, points), console.out);
  return absl::OkStatus();
}

struct SampleFlags {
  std::string name;
  int resolution = kDefaultSampleResolution;
  std::string output;
  bool json = false;
};

absl::Status RunSample(const SampleFlags& flags, Console console) {
  LATTICED_ASSIGN_OR_RETURN(const auto mesh, MakeSampleMesh(flags.name, flags.resolution));
  LATTICED_RETURN_IF_ERROR(WriteFile(flags.output, WriteObj(mesh)));
  PrintResult(flags.json,
              nlohmann::json{{"output", flags.output},
                             {"vertices", mesh.positions.size()},
                             {"faces", mesh.face_count()}},
              fmt::format("{}: {} vertices, {} faces\n", flags.output,
                          FormatCount(mesh.positions.size()), FormatCount(mesh.face_count())),
              console.out);
  return absl::OkStatus();
}

// A check for CLI11, whose own range check would accept NaN.
std::string CheckAngle(const std::string& text) {
  double angle = 0;
  const bool good = absl::SimpleAtod(text, &angle) && std::abs(angle) <= kMostDegrees;
  return good ? ""
              : fmt::format("'{}' is not an angle of -{} to {} degrees", text, kMostDegrees,
                            kMostDegrees);
}

std::string CheckIsObj(const std::string& path) {
  const auto format = MeshFormatFromFileName(path);
  return format.ok() && *format == MeshFormat::kObj ? "" : "samples are written as .obj files";
}

}  // namespace

void AddLatticeCommand(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<LatticeFlags>();
  CLI::App* command = app.add_subcommand(
      "lattice", "Writes the lattice around a mesh as JSON: at rest, or twisted, bent and turned");
  command->add_option("mesh", flags->mesh, "OBJ, PLY, STL, GLB or DRC file")
      ->required()
      ->type_name(kFileType);
  AddFitFlags(*command, flags->fit);
  command
      ->add_option("--box", flags->box,
                   "Box X,Y,Z,X,Y,Z of the lattice, by two corners, in place of the mesh's")
      ->delimiter(',')
      ->expected(6)
      ->excludes(command->get_option("--padding"));
  command->add_option("--outside", flags->outside, kOutsideHelp)->check(CheckOutside);
  const auto add_angle = [&](const char* name, double& angle, const char* text) {
    command->add_option(name, angle, text)->check(CheckAngle)->capture_default_str();
  };
  add_angle("--twist", flags->twist, "Degrees from one end of the longest edge to the other");
  add_angle("--bend", flags->bend, "Degrees of the arc that the longest edge becomes");
  command
      ->add_option("--turn", flags->turn,
                   "Turns the lattice, fitted or of --box, about the centre of its box: degrees "
                   "RX,RY,RZ about the world's x axis, then y, then z, as Blender's Euler XYZ and "
                   "USD's rotateXYZ. It is not fitted again")
      ->delimiter(',')
      ->expected(3)
      ->check(CheckAngle);
  command->add_option("-o,--output", flags->output, "JSON file to write; by default it is printed")
      ->type_name(kFileType);
  AddJsonFlag(*command, flags->json);
  SetExample(*command, "lattice beam.obj --size 9,3,3 --twist 180 --bend 90 -o L.json");
  SetAction(*command, line, [flags, &line] { return RunLattice(*flags, line.console); });
}

void AddSampleCommand(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<SampleFlags>();
  CLI::App* command = app.add_subcommand("sample", "Writes a sample mesh");
  const auto names = SampleMeshNames();
  command->add_option("name", flags->name, "Which one")
      ->required()
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())));
  command
      ->add_option("--resolution", flags->resolution,
                   "Detail; the number of faces grows with its square, but the beam always has 18")
      ->check(CLI::Range(kMinSampleResolution, kMaxSampleResolution))
      ->capture_default_str();
  command->add_option("-o,--output", flags->output, "OBJ file to write")
      ->required()
      ->type_name(kFileType)
      ->check(CheckIsObj);
  AddJsonFlag(*command, flags->json);
  SetExample(*command, "sample vase -o vase.obj");
  SetAction(*command, line, [flags, &line] { return RunSample(*flags, line.console); });
}

}  // namespace latticed::client
