// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The parts of a patch plan as patches.proto defines them, without protobuf: a header, then runs of patches, then
// seams.
//
// Threads  plain data
#ifndef LATTICED_CORE_PATCHES_PATCH_PLAN_PARTS_H_
#define LATTICED_CORE_PATCHES_PATCH_PLAN_PARTS_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/vec.h"

namespace latticed {

// Which rest normals a plan has.
enum class RestNormals { kNone, kFacet, kSmooth };

constexpr size_t RestNormalsPerPatch(RestNormals normals) {
  return normals == RestNormals::kNone ? 0 : normals == RestNormals::kFacet ? 1 : 3;
}
// Octahedral s and t, or x, y and z.
constexpr size_t NumbersPerRestNormal(RestNormals normals) {
  return normals == RestNormals::kSmooth ? 3 : 2;
}

inline constexpr int kRestNormalBits = 16;         // of octahedral normals
inline constexpr double kRestNormalUnit = 32'767;  // of the components of smooth normals
inline constexpr double kWeightUnit = 65'535;      // of weights
inline constexpr uint32_t kMaxRunPatches = 4'096;
// Seams, vertices and edges of one message of seams. It is then below limits::kMaxPartBytes: a seam takes 6 numbers of
// at most 2 bytes, a vertex 5 of 17 in all, an edge 2 of 8.
inline constexpr size_t kMaxSeamMembers = 16'384;

struct PatchPlanHeader {
  RestNormals normals = RestNormals::kNone;
  uint64_t patch_count = 0, patches_outside = 0, vertex_count = 0, edge_count = 0, normal_count = 0;
  Vec3d origin;
  Vec3d outside_lower, outside_upper;  // equal where no patch is outside
  double curvature_unit = 1;
  bool weighted = false;
};

struct PatchRun {
  uint64_t first_patch = 0;
  uint32_t patches = 0, new_vertices = 0, new_normals = 0;
  std::string data;  // a zlib stream
};

struct PatchSeams {
  std::vector<uint32_t> ranges;
  std::vector<uint32_t> vertices, vertex_seams, outside_places;
  std::vector<uint32_t> edges, edge_seams;
  std::vector<double> identity_points;
};

}  // namespace latticed

#endif  // LATTICED_CORE_PATCHES_PATCH_PLAN_PARTS_H_
