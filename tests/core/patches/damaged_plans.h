// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A plan with everything that plans can have, and its messages with damage in their arrays.
#ifndef LATTICED_TESTS_CORE_PATCHES_DAMAGED_PLANS_H_
#define LATTICED_TESTS_CORE_PATCHES_DAMAGED_PLANS_H_

#include <memory>
#include <random>
#include <string>

#include "core/patches/zlib_stream.h"
#include "tests/core/patches/patch_scene.h"

namespace latticed::testing {

// Half of a torus in a lattice: patches inside and outside, and seams.
inline std::shared_ptr<const DeformPlan> HalfTorus() {
  const PolygonMesh mesh = TorusMesh(12, 8);
  return MakePlan(std::make_shared<PolygonMesh>(mesh),
                  MakeStructure(mesh.ComputeBounds(), {.shift = {0.5, 0, 0}}))
      .value();
}

inline PlanMessages Whole(RestNormals normals = RestNormals::kFacet) {
  return WritePlan(HalfTorus(), normals);
}

inline std::string Arrays(const PlanMessages& messages, size_t run) {
  const PatchRun& r = messages.runs[run];
  return Inflate("data", r.data,
                 size_t{16} * r.patches + size_t{12} * r.new_vertices + size_t{4} * r.new_normals)
      .value();
}

// Changes some bytes of the arrays of a run. Damage to corners seldom comes past the number of edges, so half of the
// rounds spare them.
inline PlanMessages DamagedArrays(int round, std::mt19937& random) {
  PlanMessages messages = Whole();
  const size_t run = random() % messages.runs.size();
  std::string arrays = Arrays(messages, run);
  const size_t first = round % 2 == 0 ? 0 : size_t{12} * messages.runs[run].patches;
  for (size_t i = 0; i < 1 + random() % 3; ++i) {
    arrays[first + random() % (arrays.size() - first)] = static_cast<char>(random());
  }
  messages.runs[run].data = Deflate(arrays).value();
  return messages;
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CORE_PATCHES_DAMAGED_PLANS_H_
