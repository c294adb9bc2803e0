// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/patches/patch_places.h"

#include <algorithm>
#include <cmath>

namespace latticed {
namespace {

uint32_t PlaceInSpan(double fraction) {
  return static_cast<uint32_t>(std::lround(kPlacesPerSpan * std::clamp(fraction, 0.0, 1.0)));
}

}  // namespace

KnotPlanes::KnotPlanes(const LatticeStructure& structure) {
  for (size_t a = 0; a < 3; ++a) {
    const std::vector<double>& knots = structure.knots[a];
    for (int k = structure.degree[a]; k < structure.size[a]; ++k) {
      const auto i = static_cast<size_t>(k);
      if (!(knots[i] < knots[i + 1])) continue;
      planes_[a].push_back(knots[i]);
      spans_[a].push_back(k);
    }
    planes_[a].push_back(structure.domain_end(static_cast<int>(a)));
  }
}

Places KnotPlanes::PlacesOf(Vec3d parameter) const {
  Places places;
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<size_t>(a);
    const std::vector<double>& planes = planes_[axis];
    const auto above = std::upper_bound(planes.begin() + 1, planes.end() - 1, parameter[a]);
    const auto span = static_cast<uint32_t>(above - planes.begin()) - 1;
    const double begin = planes[span], end = planes[span + 1];
    places[axis] = kPlacesPerSpan * span + PlaceInSpan((parameter[a] - begin) / (end - begin));
  }
  return places;
}

Bounds OutsideBox(const Bounds& outside_pieces) {
  Bounds box = outside_pieces;
  if (box.empty()) return box;
  const Vec3d extent = box.extent();
  const double longest = std::max({extent.x, extent.y, extent.z});
  for (int a = 0; a < 3; ++a) {
    // Far from the origin, the longest side alone might be rounded away.
    if (!(box.max[a] > box.min[a])) box.max[a] += std::max(longest, 0x1p-20 * std::abs(box.max[a]));
  }
  return box;
}

Places OutsidePlaces(const Bounds& outside_box, Vec3d world) {
  Places places;
  for (int a = 0; a < 3; ++a) {
    places[static_cast<size_t>(a)] =
        PlaceInSpan((world[a] - outside_box.min[a]) / (outside_box.max[a] - outside_box.min[a]));
  }
  return places;
}

}  // namespace latticed
