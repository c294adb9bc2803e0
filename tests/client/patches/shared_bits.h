// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Counts the points that patches share, and those of which two patches have different bits.
#ifndef LATTICED_TESTS_CLIENT_PATCHES_SHARED_BITS_H_
#define LATTICED_TESTS_CLIENT_PATCHES_SHARED_BITS_H_

#include <algorithm>
#include <cstring>
#include <map>
#include <utility>
#include <vector>

#include "tests/client/patches/evaluated_scene.h"

namespace latticed::testing {

// A corner or an edge as patches of one side of a seam share it.
struct SharedKey {
  bool edge = false;
  uint32_t index = 0;
  bool torn_outside = false;  // across a torn seam, nothing is shared
  auto operator<=>(const SharedKey&) const = default;
};

struct SharedCount {
  size_t points = 0, across_boxes = 0, across_seams = 0, different = 0;
};

class SharedPointsCheck {
 public:
  SharedPointsCheck(const PatchScene& scene, const client::PatchSurface& surface)
      : plan_(*scene.plan),
        surface_(surface),
        attached_(AttachedSeams(plan_, scene.control_points)) {}

  SharedCount Count() {
    for (size_t p = 0; p < plan_.patches.size(); ++p) {
      const Patch& patch = plan_.patches[p];
      const AdaptivePattern& pattern = PatternOf(surface_, p);
      for (size_t c = 0; c < 3; ++c) {
        const uint32_t vertex_seam = plan_.vertices[patch.vertex[c]].seam;
        Take({false, patch.vertex[c], Torn(patch, vertex_seam)}, p,
             {pattern.edge_points[c].front()});
        std::vector<uint16_t> along = pattern.edge_points[c];
        if (patch.edge_reversed[c]) std::reverse(along.begin(), along.end());
        along.erase(along.begin());  // ends are vertices
        along.pop_back();
        Take({true, patch.edge[c], Torn(patch, plan_.edges[patch.edge[c]].seam)}, p, along);
      }
    }
    return count_;
  }

 private:
  bool Torn(const Patch& patch, uint32_t seam) const {
    return patch.box == plan_.outside_box() && seam != kNoIndex && !attached_[seam];
  }

  void Take(SharedKey key, size_t patch, const std::vector<uint16_t>& points) {
    std::vector<Vec3f> positions;
    for (const uint16_t i : points)
      positions.push_back(surface_.positions[surface_.first_points[patch] + i]);
    const auto [first, is_new] = first_.try_emplace(key, patch, positions);
    if (is_new) return;
    const auto& [first_patch, first_positions] = first->second;
    ASSERT_EQ(positions.size(), first_positions.size());
    const uint32_t box = plan_.patches[patch].box, first_box = plan_.patches[first_patch].box;
    for (size_t i = 0; i < positions.size(); ++i) {
      ++count_.points;
      count_.across_boxes += box != first_box;
      count_.across_seams += (box == plan_.outside_box()) != (first_box == plan_.outside_box());
      count_.different += std::memcmp(&positions[i], &first_positions[i], sizeof(Vec3f)) != 0;
    }
  }

  const DeformPlan& plan_;
  const client::PatchSurface& surface_;
  const std::vector<bool> attached_;
  std::map<SharedKey, std::pair<size_t, std::vector<Vec3f>>> first_;
  SharedCount count_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CLIENT_PATCHES_SHARED_BITS_H_
