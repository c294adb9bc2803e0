// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A patch plan as a client keeps it: what patches.proto sends, decoded.
//
//   edges     numbered in the order of first use: by patches in order, in a patch by its edges 0, 1, 2
//   seams     vertex_seams and edge_seams have kNoSeam for what is on no seam
//
// Threads  plain data; immutable once read
#ifndef LATTICED_CORE_PATCHES_PATCH_PLAN_H_
#define LATTICED_CORE_PATCHES_PATCH_PLAN_H_

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/vec.h"
#include "core/patches/patch_places.h"
#include "core/patches/patch_plan_parts.h"

namespace latticed {

struct PatchPlan {
  static constexpr uint32_t kNoSeam = ~uint32_t{0};

  struct Patch {
    std::array<uint32_t, 3> vertex{};
    std::array<uint32_t, 3> edge{};    // edge[e] joins corner e and corner (e + 1) % 3
    std::array<uint32_t, 3> normal{};  // by corner; a facet's three are equal; 0 without normals
  };

  PatchPlanHeader header;
  std::vector<Patch> patches;
  std::vector<Places> places;       // by vertex
  std::vector<Vec3f> rest_normals;  // unit facet normals, or smooth normals up to 1 long
  std::vector<uint16_t> weights;    // by vertex, times kWeightUnit; empty without weights
  std::vector<Vec3f> slopes;  // by patch, of the weight; empty without weights or without normals
  std::vector<std::array<uint32_t, 6>> seam_ranges;  // i_0 i_1 j_0 j_1 k_0 k_1
  std::vector<uint32_t> vertex_seams;                // by vertex; empty without seams
  std::vector<Places> outside_places;                // by vertex; empty without seams
  std::vector<uint32_t> edge_seams;                  // by edge; empty without seams
  std::vector<Vec3d> identity_points;                // empty without seams

  size_t inside_patches() const { return patches.size() - header.patches_outside; }
};

}  // namespace latticed

#endif  // LATTICED_CORE_PATCHES_PATCH_PLAN_H_
