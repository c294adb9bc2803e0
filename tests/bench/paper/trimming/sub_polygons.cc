// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/trimming/sub_polygons.h"

#include <algorithm>
#include <array>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "fmt/format.h"

namespace latticed::bench {
namespace {

using Edge = std::array<uint32_t, 2>;

// The edges of one patch only, each in its patch's winding.
std::vector<Edge> Sides(const DeformPlan& plan, const std::vector<uint32_t>& patches) {
  std::vector<Edge> sides;
  for (const uint32_t patch : patches) {
    const auto& vertex = plan.patches[patch].vertex;
    for (size_t e = 0; e < 3; ++e) {
      const Edge edge{vertex[e], vertex[(e + 1) % 3]};
      const auto back = std::find(sides.begin(), sides.end(), Edge{edge[1], edge[0]});
      if (back == sides.end()) {
        sides.push_back(edge);
      } else {
        sides.erase(back);
      }
    }
  }
  return sides;
}

// Joins the sides end to end. Empty if they are not one ring.
std::vector<uint32_t> Ring(std::vector<Edge> sides) {
  std::vector<uint32_t> corners;
  while (!sides.empty()) {
    const auto next = std::find_if(sides.begin(), sides.end(), [&](const Edge& side) {
      return corners.empty() || side[0] == corners.back();
    });
    if (next == sides.end()) return {};
    if (corners.empty()) corners.push_back((*next)[0]);
    corners.push_back((*next)[1]);
    sides.erase(next);
    if (corners.back() == corners.front() && !sides.empty()) return {};
  }
  if (corners.size() < 4 || corners.back() != corners.front()) return {};
  corners.pop_back();
  return corners;
}

}  // namespace

absl::StatusOr<std::vector<SubPolygon>> FindSubPolygons(const DeformPlan& plan) {
  if (plan.outside_patches > 0) {
    return absl::UnimplementedError("polygons outside the frame have no knot box");
  }
  using Key = std::pair<uint32_t, std::array<uint32_t, 3>>;  // box, and corners of the triangle
  absl::flat_hash_map<Key, size_t> places;
  places.reserve(plan.patches.size());
  std::vector<SubPolygon> polygons;
  for (size_t patch = 0; patch < plan.patches.size(); ++patch) {
    const Key key{plan.patches[patch].box, plan.sources[patch].corners};
    const auto [it, fresh] = places.try_emplace(key, polygons.size());
    if (fresh) polygons.emplace_back();
    polygons[it->second].patches.push_back(static_cast<uint32_t>(patch));
  }
  for (SubPolygon& polygon : polygons) {
    polygon.corners = Ring(Sides(plan, polygon.patches));
    if (polygon.corners.size() != polygon.patches.size() + 2) {
      return absl::InternalError(fmt::format(
          "patch {} and those of its triangle and box are no polygon", polygon.patches.front()));
    }
  }
  return polygons;
}

}  // namespace latticed::bench
