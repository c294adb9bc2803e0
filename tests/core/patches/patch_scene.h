// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene whose patches a client evaluates: the plan of a server, the same plan as its messages tell it, and edge bounds
// from the reference in double.
#ifndef LATTICED_TESTS_CORE_PATCHES_PATCH_SCENE_H_
#define LATTICED_TESTS_CORE_PATCHES_PATCH_SCENE_H_

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/vec.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/mesh/polygon_mesh.h"
#include "core/patches/patch_plan.h"
#include "core/patches/patch_plan_parts.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {

inline constexpr int kRandomPatchScenes = 90;
inline constexpr double kSceneTolerance = 1e-3;  // of the size of a scene

// The messages of a plan.
struct PlanMessages {
  PatchPlanHeader header;
  std::vector<PatchRun> runs;
  std::vector<PatchSeams> seams;
};
[[nodiscard]] PlanMessages WritePlan(std::shared_ptr<const DeformPlan> plan, RestNormals normals);
[[nodiscard]] absl::StatusOr<PatchPlan> ReadPlan(const PlanMessages& messages);

struct PatchScene {
  std::shared_ptr<const DeformPlan> plan;
  std::shared_ptr<const PatchPlan> read;
  std::vector<Vec3d> control_points;
  std::vector<uint8_t> edge_bounds;  // a byte for each edge

  // Of the control points: what world units a tolerance is measured by.
  double size() const;
};

// A byte for each edge, from bounds in double.
[[nodiscard]] std::vector<uint8_t> EdgeBounds(std::shared_ptr<const DeformPlan> plan,
                                              std::span<const Vec3d> control_points);

[[nodiscard]] PatchScene MakePatchScene(const PolygonMesh& mesh, const LatticeStructure& structure,
                                        std::vector<Vec3d> control_points, RestNormals normals,
                                        VertexWeights weights = nullptr);
// A random mesh in a random lattice (DrawCase), with control points moved by `jitter`.
[[nodiscard]] PatchScene DrawPatchScene(uint32_t seed, double jitter, RestNormals normals);

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CORE_PATCHES_PATCH_SCENE_H_
