// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the fused kernel's 24 bytes per patch with the plan. Needs no device.
#include "cuda/plan/pack_patches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "cuda/plan/feature_uses.h"
#include "tests/backend/conformance.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

// Partly outside, on knot planes (the cube's faces), and with boxes in every direction.
std::vector<Plan> Plans() {
  std::vector<Plan> plans;
  for (PolygonMesh& mesh : std::vector<PolygonMesh>{TorusMesh(16, 9), CubeMesh(4)}) {
    for (const std::array<int, 3> extra : {std::array{2, 2, 2}, std::array{0, 3, 1}}) {
      for (const double scale : {0.7, 1.0}) {
        const LatticeStructure structure =
            MakeStructure(mesh.ComputeBounds(), {.extra = extra, .scale = scale});
        plans.push_back(MakeTestPlan(mesh, structure));
      }
    }
  }
  return plans;
}

uint32_t StepDown(const DeformPlan& plan, uint32_t box, uint32_t steps) {
  const std::array<uint32_t, 3> strides = BoxStrides(plan.structure);
  for (size_t axis = 0; axis < 3; ++axis) box -= (steps >> axis & 1) * strides[axis];
  return box;
}

TEST(PackPatches, OwnersAreThoseOfThePlan) {
  size_t steps = 0, seams = 0;
  for (const Plan& plan : Plans()) {
    ASSERT_NE(plan, nullptr);
    const auto packed = PackPatches(*plan);
    ASSERT_TRUE(packed.ok()) << packed.status();
    ASSERT_EQ(packed->patches.size(), plan->patches.size());
    std::map<uint32_t, uint32_t> seam_of;
    for (const kernels::SeamUse& use : packed->seam_uses) seam_of[use.key] = use.seam;
    EXPECT_TRUE(std::is_sorted(packed->seam_uses.begin(), packed->seam_uses.end(),
                               [](const auto& a, const auto& b) { return a.key < b.key; }));
    for (uint32_t p = 0; p < plan->patches.size(); ++p) {
      const Patch& patch = plan->patches[p];
      const kernels::DevicePatch& device = packed->patches[p];
      ASSERT_EQ(device.Box(), patch.box);
      for (int slot = 0; slot < 3; ++slot) {
        const auto s = static_cast<uint32_t>(slot);
        ASSERT_EQ(device.Vertex(slot), patch.vertex[s]);
        if (patch.box == plan->outside_box()) {
          ASSERT_EQ(device.CornerSteps(slot) | device.EdgeSteps(slot), 0u);
          ASSERT_FALSE(device.CornerOnSeam(slot) || device.EdgeOnSeam(slot));
          continue;
        }
        const PlanVertex& corner = plan->vertices[patch.vertex[s]];
        const PlanEdge& edge = plan->edges[patch.edge[s]];
        ASSERT_EQ(StepDown(*plan, patch.box, device.CornerSteps(slot)), corner.box);
        ASSERT_EQ(StepDown(*plan, patch.box, device.EdgeSteps(slot)), edge.box);
        ASSERT_EQ(device.CornerOnSeam(slot), corner.seam != kNoIndex);
        ASSERT_EQ(device.EdgeOnSeam(slot), edge.seam != kNoIndex);
        ASSERT_EQ(seam_of.contains(p * 8 + s) ? seam_of[p * 8 + s] : kNoIndex, corner.seam);
        ASSERT_EQ(seam_of.contains(p * 8 + 3 + s) ? seam_of[p * 8 + 3 + s] : kNoIndex, edge.seam);
        steps += device.CornerSteps(slot) != 0;
        seams += device.EdgeOnSeam(slot);
      }
    }
  }
  EXPECT_GT(steps, 100u);
  EXPECT_GT(seams, 20u);
}

// Every use of a corner or an edge names the first use, with its direction. The two sides of a seam
// are counted apart.
TEST(FeatureUses, NumberTheDistinctCornersAndEdgesOfAChunk) {
  for (const Plan& plan : Plans()) {
    ASSERT_NE(plan, nullptr);
    const std::vector<kernels::FeatureUses> uses = PackFeatureUses(*plan);
    ASSERT_EQ(uses.size(), plan->patches.size());
    for (size_t chunk = 0; chunk < plan->chunk_count(); ++chunk) {
      const auto [first, last] = plan->ChunkPatches(chunk);
      std::vector<std::pair<uint32_t, bool>> edges, corners;  // (entity, outside), by number
      std::vector<bool> back;
      for (size_t p = first; p < last; ++p) {
        const Patch& patch = plan->patches[p];
        const bool outside = patch.box == plan->outside_box();
        for (int slot = 0; slot < 3; ++slot) {
          const auto s = static_cast<size_t>(slot);
          if (uses[p].IsFirstOfEdge(slot)) {
            ASSERT_EQ(uses[p].Edge(slot), edges.size());
            ASSERT_FALSE(uses[p].IsReversed(slot));
            edges.emplace_back(patch.edge[s], outside);
            back.push_back(patch.edge_reversed[s]);
          }
          if (uses[p].IsFirstOfCorner(slot)) {
            ASSERT_EQ(uses[p].Corner(slot), corners.size());
            corners.emplace_back(patch.vertex[s], outside);
          }
          ASSERT_EQ(edges.at(uses[p].Edge(slot)), std::pair(patch.edge[s], outside));
          ASSERT_EQ(corners.at(uses[p].Corner(slot)), std::pair(patch.vertex[s], outside));
          ASSERT_EQ(uses[p].IsReversed(slot), patch.edge_reversed[s] != back[uses[p].Edge(slot)]);
        }
      }
      ASSERT_EQ(std::set(edges.begin(), edges.end()).size(), edges.size());
      ASSERT_EQ(std::set(corners.begin(), corners.end()).size(), corners.size());
    }
  }
}

}  // namespace
}  // namespace latticed::testing
