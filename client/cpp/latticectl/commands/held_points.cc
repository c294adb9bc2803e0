// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/commands/held_points.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <vector>

#include "fmt/format.h"

namespace latticed::client {
namespace {

using Point = std::array<int, 3>;

size_t PlaceOf(v1::LatticeAxis axis) {
  return static_cast<size_t>(std::max(axis, v1::LATTICE_AXIS_U) - v1::LATTICE_AXIS_U);
}

// Those that the constraints name, by index. A mirror holds the images too.
std::vector<bool> HeldPointsOf(const v1::LatticeState& state) {
  const v1::LatticeAxes& axes = state.lattice().size();
  const Point size{axes.u(), axes.v(), axes.w()};
  const v1::Constraints& kept = state.constraints();
  std::vector<bool> named(static_cast<size_t>(size[0] * size[1] * size[2]));
  for (const uint32_t index : kept.held()) {
    if (index < named.size()) named[index] = true;
  }
  const auto index_of = [&](const Point& p) {
    return static_cast<size_t>(p[0] + size[0] * (p[1] + size[1] * p[2]));
  };
  const auto in_layer = [&](const Point& p) {
    for (const v1::HeldLayers& held : kept.held_layers()) {
      const size_t axis = PlaceOf(held.axis());
      const int depth = held.at_end() ? size[axis] - 1 - p[axis] : p[axis];
      if (depth < held.layers()) return true;
    }
    return false;
  };
  std::vector<bool> all(named.size());
  for (size_t n = 0; n < all.size(); ++n) {
    const int index = static_cast<int>(n);
    const Point p{index % size[0], index / size[0] % size[1], index / size[0] / size[1]};
    Point image = p;
    if (kept.mirror() != v1::LATTICE_AXIS_UNSPECIFIED) {
      const size_t axis = PlaceOf(kept.mirror());
      image[axis] = size[axis] - 1 - p[axis];
    }
    all[n] = named[n] || in_layer(p) || named[index_of(image)] || in_layer(image);
  }
  return all;
}

// The control points that an edit names; nullopt for an edit that names none.
std::optional<std::vector<uint32_t>> NamedPoints(const v1::Edit& edit, size_t points) {
  const auto all = [points] {
    std::vector<uint32_t> indices(points);
    std::iota(indices.begin(), indices.end(), 0U);
    return indices;
  };
  const auto these = [](const auto& indices) {
    return std::vector<uint32_t>(indices.begin(), indices.end());
  };
  if (edit.has_move_control_points()) return these(edit.move_control_points().indices());
  if (edit.has_set_control_points()) return these(edit.set_control_points().indices());
  if (edit.has_reset()) return all();
  if (!edit.has_carry_control_points()) return std::nullopt;
  const auto& carried = edit.carry_control_points().indices();
  return carried.empty() ? all() : these(carried);
}

}  // namespace

std::string HeldLine(const v1::Edit& edit, const v1::LatticeState& before) {
  if (!before.has_constraints()) return "";
  const std::vector<bool> held = HeldPointsOf(before);
  const auto named = NamedPoints(edit, held.size());
  if (!named.has_value()) return "";
  const auto stay = std::ranges::count_if(
      *named, [&](uint32_t index) { return index < held.size() && held[index]; });
  if (stay == 0) return "";
  return fmt::format("{} of {} control points {} held and did not move\n", stay, named->size(),
                     stay == 1 ? "is" : "are");
}

}  // namespace latticed::client
