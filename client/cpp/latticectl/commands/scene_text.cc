// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/commands/scene_text.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "client/cpp/latticectl/command_line/message_flags.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/library/patches/lattice_from_proto.h"
#include "core/ffd/sum/lattice_sum.h"
#include "core/mesh/mesh_units.h"
#include "fmt/format.h"
#include "fmt/ranges.h"

namespace latticed::client {
namespace {

std::string Axes(const v1::LatticeAxes& axes) {
  return fmt::format("{},{},{}", axes.u(), axes.v(), axes.w());
}

std::string ToleranceText(const v1::ViewOptions& view) {
  return view.tolerance() > 0 ? fmt::format("tolerance {:.6g}, at most ", view.tolerance()) : "";
}

std::string OutsideText(const v1::LatticeOutside& outside) {
  if (outside.mode() <= v1::OUTSIDE_MODE_FIXED) return "";
  const char* kind = outside.mode() == v1::OUTSIDE_MODE_LINEAR ? "linear" : "falloff";
  return fmt::format(", {} outside of widths {}", kind, fmt::join(outside.widths(), ","));
}

// A structure that has the frame alone, in the parameters of a box of one cell.
LatticeStructure FrameOf(const v1::LatticeSummary& lattice) {
  const v1::LatticeFrame& frame = lattice.frame();
  LatticeStructure structure{.degree = {1, 1, 1}, .size = {2, 2, 2}};
  structure.knots.fill(ClampedUniformKnots(1, 2));
  structure.frame = {FromProto(frame.origin()),
                     {FromProto(frame.u()), FromProto(frame.v()), FromProto(frame.w())}};
  return structure;
}

std::string TurnedText(const v1::Scene& scene, const v1::LatticeSummary& lattice) {
  const v1::LatticeSummary& first = scene.lattices(0);
  if (AreParallel(FrameOf(first), FrameOf(lattice))) return "";
  return fmt::format(", turned against lattice {}", first.index());
}

std::string AxisName(v1::LatticeAxis axis) {
  return std::string(1, static_cast<char>('u' + (axis - v1::LATTICE_AXIS_U)));
}

// "1,1,3 and 2,1,3": the first few points.
std::string PointsText(const google::protobuf::RepeatedField<uint32_t>& indices,
                       const v1::LatticeAxes& size) {
  constexpr int kShown = 8;
  std::vector<std::string> points;
  for (const uint32_t index : indices) {
    if (points.size() == kShown) break;
    const auto u = static_cast<uint32_t>(size.u()), v = static_cast<uint32_t>(size.v());
    points.push_back(fmt::format("{},{},{}", index % u, index / u % v, index / u / v));
  }
  const int more = indices.size() - kShown;
  return fmt::format("{}{}", fmt::join(points, " "),
                     more > 0 ? fmt::format(" and {} more", more) : "");
}

std::string VolumeText(const v1::KeptVolume& kept) {
  const std::string which =
      kept.has_volume() ? fmt::format("{:.15g}", kept.volume()) : "that of the mesh at rest";
  if (kept.axis() == v1::LATTICE_AXIS_UNSPECIFIED) return which;
  return which + ", by moves along " + AxisName(kept.axis());
}

void AddStrength(const std::string& whose, double strength, TextTable& table) {
  if (strength != 1) table.AddRow({"strength" + whose, fmt::format("{}", strength)});
}

// A row for each kind of constraint that is set.
void AddConstraints(const std::string& whose, const v1::LatticeState& state, TextTable& table) {
  const v1::Constraints& kept = state.constraints();
  if (kept.held_size() > 0) {
    table.AddRow({"held points" + whose, PointsText(kept.held(), state.lattice().size())});
  }
  std::vector<std::string> layers;
  for (const v1::HeldLayers& held : kept.held_layers()) {
    layers.push_back(fmt::format("{}{}{}", AxisName(std::max(held.axis(), v1::LATTICE_AXIS_U)),
                                 held.at_end() ? '+' : '-', held.layers()));
  }
  if (!layers.empty()) {
    table.AddRow({"held layers" + whose, fmt::format("{}", fmt::join(layers, " "))});
  }
  if (kept.mirror() != v1::LATTICE_AXIS_UNSPECIFIED) {
    table.AddRow({"mirror" + whose, "on " + AxisName(kept.mirror())});
  }
  if (kept.has_volume()) table.AddRow({"kept volume" + whose, VolumeText(kept.volume())});
}

}  // namespace

std::string ScenesText(const std::vector<v1::Scene>& scenes) {
  TextTable table({"SCENE", "NAME", "MESH", "SIZE", "REVISION", "PATCHES", "CHUNKS"});
  for (const v1::Scene& scene : scenes) {
    const std::string size = scene.lattices_size() > 0 ? Axes(scene.lattices(0).size()) : "";
    const auto count = [&scene](uint64_t number) {
      return scene.asleep() ? "asleep" : FormatCount(number);
    };
    table.AddRow({scene.id(), scene.name(), scene.mesh().substr(0, 12), size,
                  count(scene.revision()), count(scene.patches()), count(scene.chunks())});
  }
  return table.Text();
}

std::string SceneText(const v1::Scene& scene, std::span<const v1::LatticeState> states) {
  TextTable table;
  table.AddRow({"scene", scene.id()});
  table.AddRow({"name", scene.name()});
  table.AddRow({"mesh", scene.mesh()});
  const MeshUnits units{UpAxisName(scene.units().up_axis()), scene.units().meters_per_unit()};
  table.AddRow({"units", units.known() ? Describe(units) : "unknown"});
  if (scene.has_crease_angle()) {
    table.AddRow({"crease angle", fmt::format("{} degrees", scene.crease_angle())});
  }
  for (const auto& lattice : scene.lattices()) {
    const std::string label =
        scene.lattices_size() == 1 ? "lattice" : fmt::format("lattice {}", lattice.index());
    table.AddRow(
        {label, fmt::format("size {}, degree {}{}{}", Axes(lattice.size()), Axes(lattice.degree()),
                            OutsideText(lattice.outside()), TurnedText(scene, lattice))});
  }
  table.AddRow({"revision", FormatCount(scene.revision())});
  table.AddRow({"structure", FormatCount(scene.structure_id())});
  table.AddRow(
      {"patches",
       fmt::format("{} ({} outside, {} on lattice faces)", FormatCount(scene.patches()),
                   FormatCount(scene.patches_outside()), FormatCount(scene.patches_on_faces()))});
  table.AddRow({"chunks", FormatCount(scene.chunks())});
  const v1::ViewOptions& view = scene.default_view();
  table.AddRow(
      {"default view",
       fmt::format("{}{} segments, {} normals, {}, {}/{} bits", ToleranceText(view),
                   view.segments(), NormalModeName(view.normals()), EncodingName(view.encoding()),
                   view.position_bits() == 0 ? "chosen" : std::to_string(view.position_bits()),
                   view.normal_bits())});
  if (states.empty() && scene.has_strength()) AddStrength("", scene.strength(), table);
  for (const v1::LatticeState& state : states) {
    const bool is_only = scene.lattices_size() == 1;
    const std::string whose = is_only ? "" : fmt::format(" of {}", state.index());
    AddStrength(whose, state.has_strength() ? state.strength() : 1, table);
    AddConstraints(whose, state, table);
  }
  if (scene.weighted()) table.AddRow({"weights", "of vertices"});
  if (scene.fold_watch()) table.AddRow({"folds", "reported with every edit"});
  for (const auto& [purpose, bytes] : scene.bytes()) {
    table.AddRow({"bytes of " + purpose, FormatBytes(bytes)});
  }
  return table.Text();
}

nlohmann::json SceneJson(const v1::Scene& scene, std::span<const v1::LatticeState> states) {
  const auto parse = [](const google::protobuf::Message& message) {
    return nlohmann::json::parse(MessageJson(message), nullptr, /*allow_exceptions=*/false);
  };
  nlohmann::json json = parse(scene);
  for (int n = 0; n < scene.lattices_size(); ++n) {
    const uint32_t index = scene.lattices(n).index();
    const auto state =
        std::find_if(states.begin(), states.end(),
                     [index](const v1::LatticeState& one) { return one.index() == index; });
    if (state == states.end()) continue;
    nlohmann::json& lattice = json["lattices"][static_cast<size_t>(n)];
    lattice["strength"] = state->has_strength() ? state->strength() : 1.;
    if (state->has_constraints()) lattice["constraints"] = parse(state->constraints());
  }
  return json;
}

}  // namespace latticed::client
