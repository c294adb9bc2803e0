// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// points: deforms points of files, and applies the derivative by control points. Each command makes a point set and
// deletes it.
#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "client/cpp/latticectl/command_line/value_types.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/geometry/files.h"
#include "client/cpp/latticectl/geometry/point_table.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/session.h"
#include "client/cpp/latticectl/vtk/vtk_file.h"
#include "core/base/read_file.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr size_t kPlain = 3, kWithNormals = 6;        // columns
constexpr char kVelocityName[] = "lattice_velocity";  // many a mesh of VTK has a velocity

struct PointsFlags : ServerFlags {
  std::string scene, points, vectors, output, point_set;
  uint32_t lattice_number = 0;
};

// Points of a file, and the file itself if it is one of VTK.
struct PointsInput {
  PointTable table;
  std::optional<VtkFile> vtk;
};

absl::Status AboutFile(const std::string& path, const absl::Status& why) {
  return absl::InvalidArgumentError(fmt::format("{} {}", path, std::string(why.message())));
}

absl::StatusOr<PointsInput> ReadPoints(const std::string& path) {
  PointsInput input;
  if (!IsVtkFileName(path)) {
    LATTICED_ASSIGN_OR_RETURN(input.table, ReadPointTable(path));
    return input;
  }
  LATTICED_ASSIGN_OR_RETURN(std::string bytes, ReadFile(path));
  auto file = VtkFile::Parse(std::move(bytes), IsXmlVtkFileName(path));
  if (file.ok() && file->points().empty()) file = absl::InvalidArgumentError("has no points");
  if (!file.ok()) return AboutFile(path, file.status());
  for (const Vec3d p : file->points()) {
    for (int axis = 0; axis < 3; ++axis) input.table.numbers.push_back(p[axis]);
  }
  input.vtk = *std::move(file);
  return input;
}

std::string CheckPointsOrVtk(const std::string& path) {
  return IsVtkFileName(path) || CheckPointFileName(path).empty()
             ? ""
             : fmt::format("{}: the extension must be .csv, .npy, .vtk, .vtu, .vtp or .vts", path);
}

// A VTK file is the one that was read with other points.
absl::Status CheckVtkOutput(const PointsFlags& flags) {
  const std::filesystem::path from(flags.points), to(flags.output);
  if (!IsVtkFileName(flags.output) || from.extension() == to.extension()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("{}: a {} file is written from one, with its cells and data; {} is none",
                  flags.output, to.extension().string(), flags.points));
}

// First the columns x y z of all rows, then those of normals: as the server has them.
std::vector<Vec3d> VectorsOf(const PointTable& table) {
  std::vector<Vec3d> vectors;
  vectors.reserve(table.numbers.size() / kPlain);
  for (size_t first = 0; first < table.columns; first += kPlain) {
    for (size_t at = first; at < table.numbers.size(); at += table.columns) {
      vectors.push_back({table.numbers[at], table.numbers[at + 1], table.numbers[at + 2]});
    }
  }
  return vectors;
}

// The inverse of VectorsOf.
PointTable PointTableOf(const std::vector<Vec3d>& vectors, size_t columns) {
  PointTable table{.columns = columns};
  const size_t rows = vectors.size() * kPlain / columns;
  table.numbers.reserve(vectors.size() * kPlain);
  for (size_t row = 0; row < rows; ++row) {
    for (size_t at = row; at < vectors.size(); at += rows) {
      for (int axis = 0; axis < 3; ++axis) table.numbers.push_back(vectors[at][axis]);
    }
  }
  return table;
}

// Runs `use` on a point set of the file's points, and deletes it.
absl::Status WithPoints(const PointsFlags& flags, const PointTable& table, Client& client,
                        const std::function<absl::Status(const v1::PointSet&)>& use) {
  v1::PointSetHeader header;
  header.set_scene(flags.scene);
  header.mutable_world()->set_points(table.rows());
  header.mutable_world()->set_with_normals(table.columns == kWithNormals);
  const std::vector<Vec3d> vectors = VectorsOf(table);
  LATTICED_ASSIGN_OR_RETURN(
      const v1::PointSet set,
      client.CreatePointSet(
          header, {reinterpret_cast<const double*>(vectors.data()), vectors.size() * kPlain}));
  const absl::Status used = use(set);
  const absl::Status deleted = client.DeletePointSet(flags.scene, set.id());
  return used.ok() ? deleted : used;
}

template <class Request>
Request RequestFor(const PointsFlags& flags, const v1::PointSet& set) {
  Request request;
  request.set_scene(flags.scene);
  request.set_point_set(set.id());
  request.set_with_normals(set.has_normals());
  return request;
}

// `vtk` is what a VTK file holds, for those.
absl::Status Finish(const PointsFlags& flags, const std::vector<Vec3d>& vectors, size_t columns,
                    uint64_t revision, std::string_view what, Console console,
                    const std::string& vtk = "") {
  const PointTable table = PointTableOf(vectors, columns);
  LATTICED_RETURN_IF_ERROR(IsVtkFileName(flags.output) ? WriteFile(flags.output, vtk)
                                                       : WritePointTable(flags.output, table));
  PrintResult(flags.json,
              nlohmann::json{{"output", flags.output},
                             {"rows", table.rows()},
                             {"columns", columns},
                             {"revision", revision}},
              fmt::format("{}: {} {}, revision {}\n", flags.output, FormatCount(table.rows()), what,
                          revision),
              console.out);
  return absl::OkStatus();
}

absl::Status RunDeform(const PointsFlags& flags, Client& client, Console console) {
  LATTICED_RETURN_IF_ERROR(CheckVtkOutput(flags));
  LATTICED_ASSIGN_OR_RETURN(const PointsInput input, ReadPoints(flags.points));
  const PointTable& table = input.table;
  return WithPoints(flags, table, client, [&](const v1::PointSet& set) -> absl::Status {
    LATTICED_ASSIGN_OR_RETURN(
        const auto deformed,
        client.DeformPointSet(RequestFor<v1::DeformPointSetRequest>(flags, set)));
    const bool as_vtk = IsVtkFileName(flags.output);
    return Finish(flags, deformed.vectors, table.columns, deformed.header.revision(), "points",
                  console, as_vtk ? input.vtk.value().WithPoints(deformed.vectors) : "");
  });
}

// Refuses a file of vectors that has not a row for each of `wanted` things, before it is sent.
absl::Status CheckRows(const std::string& file, size_t rows, size_t wanted,
                       const std::string& things) {
  if (rows == wanted) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("{}: has {} rows, {} {}: a row for each is needed", file, rows, wanted, things));
}

// A lattice that the scene does not have is left to the server.
absl::Status CheckTangents(const PointsFlags& flags, const PointTable& tangents, Client& client) {
  if (tangents.columns != kPlain) {
    return absl::InvalidArgumentError(
        fmt::format("{}: has {} columns, a velocity has 3", flags.vectors, tangents.columns));
  }
  LATTICED_ASSIGN_OR_RETURN(const auto scene, client.GetScene(flags.scene));
  for (const auto& lattice : scene.lattices()) {
    if (lattice.index() != flags.lattice_number) continue;
    const v1::LatticeAxes& size = lattice.size();
    return CheckRows(flags.vectors, tangents.rows(),
                     static_cast<size_t>(size.u()) * static_cast<size_t>(size.v()) *
                         static_cast<size_t>(size.w()),
                     fmt::format("control points are in lattice {}", lattice.index()));
  }
  return absl::OkStatus();
}

absl::Status RunVelocities(const PointsFlags& flags, Client& client, Console console) {
  LATTICED_RETURN_IF_ERROR(CheckVtkOutput(flags));
  LATTICED_ASSIGN_OR_RETURN(const PointsInput input, ReadPoints(flags.points));
  const PointTable& table = input.table;
  LATTICED_ASSIGN_OR_RETURN(const PointTable tangents, ReadPointTable(flags.vectors));
  LATTICED_RETURN_IF_ERROR(CheckTangents(flags, tangents, client));
  return WithPoints(flags, table, client, [&](const v1::PointSet& set) -> absl::Status {
    auto request = RequestFor<v1::ApplyJacobianRequest>(flags, set);
    request.set_lattice(flags.lattice_number);
    request.set_tangents(reinterpret_cast<const char*>(tangents.numbers.data()),
                         tangents.numbers.size() * sizeof(double));
    LATTICED_ASSIGN_OR_RETURN(const auto moved, client.ApplyJacobian(request));
    std::string vtk;
    if (IsVtkFileName(flags.output)) {
      auto file = input.vtk.value().WithVectors(kVelocityName, moved.vectors);
      if (!file.ok()) return AboutFile(flags.points, file.status());
      vtk = *std::move(file);
    }
    return Finish(flags, moved.vectors, table.columns, moved.header.revision(), "velocities",
                  console, vtk);
  });
}

absl::Status RunGradient(const PointsFlags& flags, Client& client, Console console) {
  LATTICED_ASSIGN_OR_RETURN(const PointsInput input, ReadPoints(flags.points));
  const PointTable& table = input.table;
  LATTICED_ASSIGN_OR_RETURN(const PointTable cotangents, ReadPointTable(flags.vectors));
  LATTICED_RETURN_IF_ERROR(CheckRows(flags.vectors, cotangents.rows(), table.rows(),
                                     fmt::format("points are in {}", flags.points)));
  return WithPoints(flags, table, client, [&](const v1::PointSet& set) -> absl::Status {
    auto header = RequestFor<v1::CotangentHeader>(flags, set);
    header.set_with_normals(cotangents.columns == kWithNormals);
    header.set_lattice(flags.lattice_number);
    LATTICED_ASSIGN_OR_RETURN(const auto gradient,
                              client.ApplyJacobianTranspose(header, VectorsOf(cotangents)));
    return Finish(flags, gradient.vectors, kPlain, gradient.revision, "derivatives", console);
  });
}

absl::Status RunListSets(const PointsFlags& flags, Client& client, Console console) {
  LATTICED_ASSIGN_OR_RETURN(const auto sets, client.ListPointSets(flags.scene));
  if (flags.json) {
    PrintJsonArray(sets, console.out);
    return absl::OkStatus();
  }
  TextTable table({"POINT SET", "POINTS", "OUTSIDE", "NORMALS", "BYTES"});
  for (const v1::PointSet& set : sets) {
    table.AddRow({set.id(), FormatCount(set.points()), FormatCount(set.points_outside()),
                  set.has_normals() ? "yes" : "no", FormatBytes(set.bytes())});
  }
  console.out << table.Text();
  return absl::OkStatus();
}

absl::Status RunDeleteSet(const PointsFlags& flags, Client& client, Console console) {
  LATTICED_RETURN_IF_ERROR(client.DeletePointSet(flags.scene, flags.point_set));
  PrintResult(flags.json, nlohmann::json{{"deleted", std::vector{flags.point_set}}},
              fmt::format("point set {} is deleted\n", flags.point_set), console.out);
  return absl::OkStatus();
}

}  // namespace

void AddPointsCommands(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<PointsFlags>();
  CLI::App* points = app.add_subcommand(
      "points", "Deforms points of files, and applies derivatives by control points");
  points->require_subcommand(0, 1);
  const auto add = [&](const char* name, const char* text, const char* example) {
    CLI::App* command = points->add_subcommand(name, text);
    command->add_option("scene", flags->scene, "Id of the scene")->required();
    SetExample(*command, example);
    return command;
  };
  const auto add_file = [](CLI::App* command, const char* name, std::string& value,
                           const char* text, std::string (*check)(const std::string&)) {
    command->add_option(name, value, text)->required()->type_name(kFileType)->check(check);
  };
  const auto add_lattice = [flags](CLI::App* command) {
    command->add_option("--lattice-number", flags->lattice_number,
                        "Which of the scene's lattices, from 0");
  };
  constexpr char kPoints[] =
      "CSV or NPY file of points at rest, x y z or x y z and a normal; or a mesh of VTK: .vtk, "
      ".vtu, .vtp or .vts";
  constexpr char kOutput[] = "CSV or NPY file to write";

  CLI::App* deform = add("deform", "Writes the deformed points, and their normals if they have any",
                         "points deform my-scene nodes.npy -o deformed.npy");
  add_file(deform, "points", flags->points, kPoints, CheckPointsOrVtk);
  add_file(deform, "-o,--output", flags->output,
           "CSV or NPY file to write; or the .vtk, .vtu, .vtp or .vts file with moved points and "
           "how they moved",
           CheckPointsOrVtk);
  SetServerAction(*deform, flags, line, RunDeform);

  CLI::App* velocities =
      add("velocities", "Writes how the points move when the control points move: forward mode",
          "points velocities my-scene nodes.npy tangents.csv -o velocities.npy");
  add_file(velocities, "points", flags->points, kPoints, CheckPointsOrVtk);
  add_file(velocities, "tangents", flags->vectors,
           "CSV or NPY file: a velocity of every control point, u fastest", CheckPointFileName);
  add_file(velocities, "-o,--output", flags->output,
           "CSV or NPY file to write; or the .vtk, .vtu, .vtp or .vts file with the velocities as "
           "point data lattice_velocity",
           CheckPointsOrVtk);
  add_lattice(velocities);
  SetServerAction(*velocities, flags, line, RunVelocities);

  CLI::App* gradient =
      add("gradient", "Writes the derivative of a value by all control points: reverse mode",
          "points gradient my-scene nodes.npy cotangents.npy -o gradient.csv");
  add_file(gradient, "points", flags->points, kPoints, CheckPointsOrVtk);
  add_file(
      gradient, "cotangents", flags->vectors,
      "CSV or NPY file: the derivative of the value by every deformed point, and by its normal",
      CheckPointFileName);
  add_file(gradient, "-o,--output", flags->output, kOutput, CheckPointFileName);
  add_lattice(gradient);
  SetServerAction(*gradient, flags, line, RunGradient);

  SetServerAction(*add("list", "Lists the point sets of a scene", "points list my-scene"), flags,
                  line, RunListSets);
  CLI::App* remove = add("delete", "Deletes a point set", "points delete my-scene SET");
  remove->add_option("point_set", flags->point_set, "Id of the set")->required();
  SetServerAction(*remove, flags, line, RunDeleteSet);
}

}  // namespace latticed::client
