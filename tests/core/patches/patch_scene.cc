// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/core/patches/patch_scene.h"

#include <algorithm>
#include <utility>

#include "core/adaptive/adaptive_reference.h"
#include "core/base/status_macros.h"
#include "core/patches/edge_bound.h"
#include "core/patches/patch_plan_reader.h"
#include "core/patches/patch_plan_writer.h"

namespace latticed::testing {
std::vector<uint8_t> EdgeBounds(std::shared_ptr<const DeformPlan> plan,
                                std::span<const Vec3d> control_points) {
  const auto bounds = AdaptiveReference(plan).Bounds(control_points);
  std::vector<double> largest(plan->edges.size());
  for (size_t p = 0; p < plan->patches.size(); ++p) {
    for (size_t e = 0; e < 3; ++e) {
      double& of_edge = largest[plan->patches[p].edge[e]];
      of_edge = std::max(of_edge, bounds[p].edge[e]);
    }
  }
  std::vector<uint8_t> bytes;
  const double unit = CurvatureUnit(plan->mesh_bounds);
  for (const double bound : largest) bytes.push_back(EdgeBoundByte(bound, unit));
  return bytes;
}

PlanMessages WritePlan(std::shared_ptr<const DeformPlan> plan, RestNormals normals) {
  auto writer = PatchPlanWriter::Create(std::move(plan), normals);
  PlanMessages messages{.header = writer->header()};
  for (auto run = writer->NextRun(); run.value().has_value(); run = writer->NextRun()) {
    messages.runs.push_back(**run);
  }
  for (auto seams = writer->NextSeams(); seams.has_value(); seams = writer->NextSeams()) {
    messages.seams.push_back(*seams);
  }
  return messages;
}

absl::StatusOr<PatchPlan> ReadPlan(const PlanMessages& messages) {
  PatchPlanReader reader(messages.header);
  for (const PatchRun& run : messages.runs) LATTICED_RETURN_IF_ERROR(reader.Add(run));
  for (const PatchSeams& seams : messages.seams) LATTICED_RETURN_IF_ERROR(reader.Add(seams));
  return reader.Finish();
}

double PatchScene::size() const {
  Bounds bounds;
  for (const Vec3d& p : control_points) bounds.Extend(p);
  return bounds.diagonal();
}

PatchScene MakePatchScene(const PolygonMesh& mesh, const LatticeStructure& structure,
                          std::vector<Vec3d> control_points, RestNormals normals,
                          VertexWeights weights) {
  PatchScene scene{.plan = MakePlan(std::make_shared<PolygonMesh>(mesh), structure, {}, NeverStop,
                                    std::move(weights))
                               .value(),
                   .control_points = std::move(control_points)};
  scene.read = std::make_shared<PatchPlan>(ReadPlan(WritePlan(scene.plan, normals)).value());
  scene.edge_bounds = EdgeBounds(scene.plan, scene.control_points);
  return scene;
}

PatchScene DrawPatchScene(uint32_t seed, double jitter, RestNormals normals) {
  const RandomCase random = DrawCase(seed);
  const LatticeStructure structure = MakeStructure(random.mesh.ComputeBounds(), random.options);
  return MakePatchScene(random.mesh, structure, Jitter(structure, jitter, seed), normals);
}

}  // namespace latticed::testing
