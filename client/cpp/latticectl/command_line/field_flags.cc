// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/command_line/field_flags.h"

#include <CLI/CLI.hpp>
#include <array>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "client/cpp/latticectl/command_line/value_types.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr char kLatticeFlag[] = "--lattice";

constexpr auto kFieldFlags = std::to_array<FieldFlag>({
    {"lattices.fit.size", "--size"},
    {"lattices.fit.degree", "--degree"},
    {"lattices.fit.padding", "--padding"},
    {"lattices.fit.outside", "--outside"},
    {"lattices.lattice", kLatticeFlag},
    {"units.up_axis", "--up-axis"},
    {"units.meters_per_unit", "--meters-per-unit"},
    {"default_view.segments", "--segments"},
    {"default_view.tolerance", "--tolerance"},
    {"default_view.normals", "--normals"},
    {"default_view.encoding", "--encoding"},
    {"default_view.position_bits", "--position-bits"},
    {"default_view.normal_bits", "--normal-bits"},
    {"crease_angle", "--crease-angle"},
    {"weights.values", "--weights"},
    {"weights.from_mesh", "--weights"},
    {"weights", "--weights"},
    {"diagnostics.pipeline", "--pipeline"},
    {"scene_id", "--id"},
    {"name", "--name"},
    {"strength", "--strength"},
    {"view.segments", "--segments"},
    {"view.tolerance", "--tolerance"},
    {"view.normals", "--normals"},
    {"view.encoding", "--encoding"},
    {"view.position_bits", "--position-bits"},
    {"view.normal_bits", "--normal-bits"},
    {"view.max_points", "--max-points"},
    {"view.max_bytes_per_second", "--max-bytes-per-second"},
    {"view.drag_position_bits", "--drag-position-bits"},
    {"view.drag_normal_bits", "--drag-normal-bits"},
    {"header.name", "--name"},
    {"header.labels", "--label"},
    {"header.units.up_axis", "--up-axis"},
    {"header.units.meters_per_unit", "--meters-per-unit"},
    {"filter", "--filter"},
    {"revision", "--revision"},
    {"ray", "--ray"},
    {"surface_points.points", "--at"},
    {"editor_id", "--editor"},
    {"edits.move_control_points.indices", "--point"},
    {"edits.move_control_points.offset", "--by"},
    {"edits.set_control_points.indices", "--point"},
    {"edits.set_control_points.positions", "--to"},
    {"edits.carry_control_points.indices", "--point"},
    {"edits.carry_control_points.parent", kLatticeFlag},
    {"edits.drag_points.points", "--at"},
    {"edits.drag_points.targets", "--to"},
    {"edits.drag_points.targets", "--by"},
    {"edits.insert_knot.axis", "axis"},
    {"edits.insert_knot.value", "value"},
    {"edits.insert_knot", "value"},
    {"edits.replace_lattice.lattice.size", "--size"},
    {"edits.replace_lattice.lattice.degree", "--degree"},
    {"edits.replace_lattice.lattice.outside", "outside"},
    {"edits.replace_lattice.lattice", kLatticeFlag},
    {"edits.reset.target", "--to"},
    {"edits.set_strength.strength", "strength"},
    {"edits.set_weights.values", "weights"},
    {"edits.undo.scope", "--scope"},
    {"keep_volume", "--keep-volume"},
    // Without a server, latticectl checks a fit and a lattice itself.
    {"fit.size", "--size"},
    {"fit.degree", "--degree"},
    {"fit.padding", "--padding"},
    {"lattice.outside", "--outside"},
    {"lattice", kLatticeFlag},
});

std::string WithoutIndex(const std::string& segment) {
  return segment.substr(0, segment.find('['));
}

// The option for this field that was given, else the first that the command has.
const CLI::Option* OptionFor(const CLI::App& command, std::string_view field,
                             std::string_view* flag) {
  const CLI::Option* found = nullptr;
  for (const FieldFlag& entry : kFieldFlags) {
    if (entry.field != field) continue;
    const CLI::Option* option = command.get_option_no_throw(std::string(entry.flag));
    if (option == nullptr || (found != nullptr && option->count() == 0)) continue;
    found = option;
    *flag = entry.flag;
  }
  return found;
}

// The files of lattices are JSON: control_points is controlPoints there.
std::string JsonName(const std::string& path) {
  std::string name;
  bool upper = false;
  for (const char c : path) {
    if (c != '_') name += upper ? absl::ascii_toupper(static_cast<unsigned char>(c)) : c;
    upper = c == '_';
  }
  return name;
}

}  // namespace

std::span<const FieldFlag> FieldFlags() { return kFieldFlags; }

std::optional<std::string> InWordsOf(const CLI::App& command, std::string_view field) {
  const std::vector<std::string> segments = absl::StrSplit(std::string(field), '.');
  std::vector<std::string> plain;  // without indices
  plain.reserve(segments.size());
  for (const std::string& segment : segments) plain.push_back(WithoutIndex(segment));
  for (size_t n = segments.size(); n > 0; --n) {
    std::string_view flag;
    const auto end = static_cast<std::ptrdiff_t>(n);
    const auto* option =
        OptionFor(command, absl::StrJoin(plain.begin(), plain.begin() + end, "."), &flag);
    if (option == nullptr) continue;
    std::string words(flag);
    // The index counts the values of an option that may be repeated, not the numbers of one value.
    const std::string index = segments[n - 1].substr(plain[n - 1].size());
    int number = 0;
    if (TakesAnyNumber(*option) && index.size() > 2 &&
        absl::SimpleAtoi(index.substr(1, index.size() - 2), &number)) {
      words += fmt::format(", number {}", number + 1);
    }
    const std::string rest = absl::StrJoin(segments.begin() + end, segments.end(), ".");
    if (!rest.empty()) words += ", " + (flag == kLatticeFlag ? JsonName(rest) : rest);
    return words;
  }
  return std::nullopt;
}

}  // namespace latticed::client
