// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/command_line/message_flags.h"

#include <cmath>

#include "absl/strings/numbers.h"
#include "client/cpp/latticectl/command_line/value_types.h"
#include "core/base/limits.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr NamedValues<v1::NormalMode, 3> kNormalModes{{{"facet", v1::NORMAL_MODE_FACET},
                                                       {"smooth", v1::NORMAL_MODE_SMOOTH},
                                                       {"none", v1::NORMAL_MODE_NONE}}};
constexpr NamedValues<v1::Encoding, 6> kEncodings{{{"raw", v1::ENCODING_RAW},
                                                   {"draco", v1::ENCODING_DRACO_POINTS},
                                                   {"draco-mesh", v1::ENCODING_DRACO_MESH},
                                                   {"meshopt", v1::ENCODING_MESHOPT},
                                                   {"quantised", v1::ENCODING_QUANTISED},
                                                   {"patches", v1::ENCODING_PATCHES}}};
constexpr NamedValues<v1::Pipeline, 4> kPipelines{{{"fused", v1::PIPELINE_FUSED},
                                                   {"gemm", v1::PIPELINE_GEMM},
                                                   {"gemm12", v1::PIPELINE_GEMM12},
                                                   {"control-net", v1::PIPELINE_CONTROL_NET}}};

template <typename Number>
CLI::Option* AddNumber(CLI::App& command, const char* option, v1::ViewOptions& view,
                       void (v1::ViewOptions::*set)(Number), const char* text) {
  return command.add_option_function<Number>(
      option, [&view, set](const Number& number) { (view.*set)(number); }, text);
}

CLI::Validator PositionBits() {
  return CLI::Range(limits::kMinPositionBits, limits::kMaxPositionBits);
}
CLI::Validator NormalBits() { return CLI::Range(limits::kMinNormalBits, limits::kMaxNormalBits); }

constexpr NamedValues<v1::UpAxis, 3> kUpAxes{
    {{"x", v1::UP_AXIS_X}, {"y", v1::UP_AXIS_Y}, {"z", v1::UP_AXIS_Z}}};

// A check for CLI11. CLI11's own range check would print the largest double with 309 digits.
std::string CheckLength(const std::string& text) {
  double length = 0;
  const bool good = absl::SimpleAtod(text, &length) && length > 0 && std::isfinite(length);
  return good ? "" : fmt::format("'{}' is not a length above 0", text);
}

}  // namespace

void AddViewFlags(CLI::App& command, v1::ViewOptions& view, ViewDefaults defaults) {
  const auto shown = [defaults](const char* of_server) {
    return defaults == ViewDefaults::kOfServer ? of_server : "scene's";
  };
  using View = v1::ViewOptions;
  AddNumber(command, "--segments", view, &View::set_segments, "Subdivisions per patch edge")
      ->check(CLI::Range(limits::kMinSegments, limits::kMaxSegments))
      ->default_str(shown("10"));
  AddNamedOption<v1::NormalMode>(
      command, "--normals", kNormalModes, [&view](auto normals) { view.set_normals(normals); },
      "Normals; smooth is the default of a mesh that has normals, facet of others")
      ->default_str(shown("mesh's"));
  AddNamedOption<v1::Encoding>(
      command, "--encoding", kEncodings, [&view](auto encoding) { view.set_encoding(encoding); },
      "How the surface is streamed; of patches the client makes the points, as --tolerance says")
      ->default_str(shown("draco"));
  AddNumber(command, "--position-bits", view, &View::set_position_bits,
            "Bits per quantised coordinate")
      ->check(PositionBits())
      ->default_str(shown("12"));
  AddNumber(command, "--normal-bits", view, &View::set_normal_bits,
            "Bits per quantised normal coordinate")
      ->check(NormalBits())
      ->default_str(shown("8"));
}

void AddDragFlags(CLI::App& command, v1::ViewOptions& view) {
  using View = v1::ViewOptions;
  AddNumber(command, "--max-points", view, &View::set_max_points,
            "Most points of an update while edits come: the server takes fewer segments then")
      ->default_str("unlimited");
  AddNumber(command, "--max-bytes-per-second", view, &View::set_max_bytes_per_second,
            "Most bytes per second while edits come: the server takes fewer segments then")
      ->default_str("unlimited");
  AddNumber(command, "--drag-position-bits", view, &View::set_drag_position_bits,
            "Bits per coordinate while a gesture is open")
      ->check(PositionBits())
      ->default_str("--position-bits");
  AddNumber(command, "--drag-normal-bits", view, &View::set_drag_normal_bits,
            "Bits per normal coordinate while a gesture is open")
      ->check(NormalBits())
      ->default_str("--normal-bits");
}

void AddPipelineFlag(CLI::App& command, v1::Pipeline& pipeline) {
  AddNamedOption<v1::Pipeline>(
      command, "--pipeline", kPipelines, [&pipeline](auto named) { pipeline = named; },
      "How vertices are computed")
      ->default_str("fused");
}

std::string EncodingName(v1::Encoding encoding) { return NameOf(kEncodings, encoding, "default"); }

std::string NormalModeName(v1::NormalMode normals) {
  return NameOf(kNormalModes, normals, "default");
}

void AddUnitsFlags(CLI::App& command, v1::MeshUnits& units) {
  AddNamedOption<v1::UpAxis>(
      command, "--up-axis,--up", kUpAxes, [&units](auto axis) { units.set_up_axis(axis); },
      "Axis of the mesh that points up; by default y of a GLB file");
  command
      .add_option_function<double>(
          "--meters-per-unit", [&units](double length) { units.set_meters_per_unit(length); },
          "Length of the mesh's unit, such as 0.001 for millimetres; by default 1 of a GLB file")
      ->check(CheckLength);
}

void AddCreaseFlag(CLI::App& command, std::optional<double>& angle) {
  command
      .add_option("--crease-angle", angle,
                  "Degrees between faces above which smooth normals are split; by default those of "
                  "the mesh, or 30")
      ->check(CLI::Range(0., 180.));
}

void AddWeightsFlag(CLI::App& command, std::string& source) {
  command
      .add_option("--weights", source,
                  "How much of the deformation each vertex takes, 0 to 1: 'attribute' for those in "
                  "the mesh's file (PLY weight, GLB _WEIGHT), or a .npy or .csv file of numbers")
      ->type_name(kFileType);
}

std::string UpAxisName(v1::UpAxis axis) { return NameOf(kUpAxes, axis, ""); }

}  // namespace latticed::client
