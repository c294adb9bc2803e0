// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <memory>
#include <ostream>
#include <string>

#include "client/cpp/latticectl/command_line/failure.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/session.h"
#include "core/base/error.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

struct MeasureFlags : ServerFlags {
  std::string scene;
  bool volume = false, area = false, centroid = false, bounds = false, gradient = false;
  double area_tolerance = 0;
  uint32_t lattice_number = 0;
};

v1::MeasureSceneRequest RequestOf(const MeasureFlags& flags) {
  v1::MeasureSceneRequest request;
  request.set_scene(flags.scene);
  request.set_lattice(flags.lattice_number);
  if (flags.volume) request.add_measures(v1::MEASURE_VOLUME);
  if (flags.area) request.add_measures(v1::MEASURE_AREA);
  if (flags.centroid) request.add_measures(v1::MEASURE_CENTROID);
  if (flags.bounds) request.add_measures(v1::MEASURE_BOUNDS);
  if (request.measures().empty()) {
    for (const v1::Measure measure :
         {v1::MEASURE_VOLUME, v1::MEASURE_AREA, v1::MEASURE_CENTROID, v1::MEASURE_BOUNDS}) {
      request.add_measures(measure);
    }
  }
  request.set_with_gradient(flags.gradient);
  if (flags.area_tolerance > 0) request.set_area_tolerance(flags.area_tolerance);
  return request;
}

std::string TextOf(const v1::Vec3& v) {
  return fmt::format("{:.15g}, {:.15g}, {:.15g}", v.x(), v.y(), v.z());
}

// An open or torn surface has no volume, but all else.
absl::Status ExplainOpen(const absl::Status& status) {
  error::Details details = error::DetailsOf(status);
  if (details.reason != "OPEN_SURFACE") return status;
  details.metadata[kAdviceKey] = "'measure --area --bounds' works on open and torn surfaces";
  return error::WithDetails(status, details);
}

absl::Status RunMeasure(const MeasureFlags& flags, Client& client, Console console) {
  const auto answer = client.MeasureScene(RequestOf(flags));
  if (!answer.ok()) return ExplainOpen(answer.status());
  const v1::MeasureSceneResponse& measured = *answer;
  std::string text = fmt::format("revision {}\n", measured.revision());
  if (measured.has_volume()) text += fmt::format("volume   {:.15g}\n", measured.volume());
  if (measured.has_area()) {
    text +=
        fmt::format("area     {:.15g}, within {:.1e}\n", measured.area(), measured.area_error());
  }
  if (measured.has_centroid()) text += fmt::format("centroid {}\n", TextOf(measured.centroid()));
  if (measured.has_least()) {
    text +=
        fmt::format("bounds   {} to {}\n", TextOf(measured.least()), TextOf(measured.greatest()));
  }
  PrintResult(flags.json, measured, text, console.out);
  return absl::OkStatus();
}

}  // namespace

void AddMeasureCommand(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<MeasureFlags>();
  CLI::App* command = app.add_subcommand(
      "measure", "Measures the exact deformed surface: all of it, or what is asked for");
  command->add_option("scene", flags->scene, "Id of the scene")->required();
  command->add_flag("--volume", flags->volume, "The enclosed volume; the surface must be closed");
  command->add_flag("--area", flags->area, "The area");
  command->add_flag("--centroid", flags->centroid,
                    "The centroid of that volume; the surface must be closed");
  command->add_flag("--bounds", flags->bounds, "The least and the greatest coordinates");
  command
      ->add_option("--area-tolerance", flags->area_tolerance,
                   "Largest error of the area, as a fraction of it")
      ->check(CLI::Range(1e-12, 0.1))
      ->default_str("1e-6");
  command->add_flag("--gradient", flags->gradient,
                    "Derivatives by all control points too; shown with --json");
  command->add_option("--lattice-number", flags->lattice_number,
                      "By whose control points, from 0, where the scene has several lattices");
  SetExample(*command, "measure my-scene --volume --area");
  SetServerAction(*command, flags, line, RunMeasure);
}

}  // namespace latticed::client
