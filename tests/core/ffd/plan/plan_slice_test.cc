// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A slice has the same data for each of its patches as the plan.
#include "core/ffd/plan/plan_slice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "core/ffd/direct_ffd.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

std::shared_ptr<const DeformPlan> TestPlan() {
  PolygonMesh mesh = TorusMesh(16, 9);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {.scale = 0.8});
  auto plan = MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), structure);
  EXPECT_OK(plan);
  return *plan;
}

void ExpectSamePatch(const DeformPlan& slice, size_t p, const DeformPlan& plan, size_t q) {
  const Patch& got = slice.patches[p];
  const Patch& want = plan.patches[q];
  ASSERT_EQ(got.box, want.box);
  ASSERT_EQ(got.edge_reversed, want.edge_reversed);
  for (size_t i = 0; i < 3; ++i) {
    const PlanVertex& a = slice.vertices[got.vertex[i]];
    const PlanVertex& b = plan.vertices[want.vertex[i]];
    ASSERT_EQ(a.world, b.world);
    ASSERT_EQ(a.parameter, b.parameter);
    ASSERT_EQ(a.box, b.box);
    ASSERT_EQ(a.seam, b.seam);
    const PlanEdge& e = slice.edges[got.edge[i]];
    const PlanEdge& f = plan.edges[want.edge[i]];
    ASSERT_EQ(e.box, f.box);
    ASSERT_EQ(e.seam, f.seam);
    for (size_t end = 0; end < 2; ++end) {
      ASSERT_EQ(slice.vertices[e.vertex[end]].world, plan.vertices[f.vertex[end]].world);
    }
  }
  const DirectFfd a(slice, slice.identity_points), b(plan, plan.identity_points);
  ASSERT_EQ(a.RestFacetNormal(p), b.RestFacetNormal(q));
  ASSERT_EQ(a.RestSmoothNormal(p, {0.2, 0.3, 0.5}), b.RestSmoothNormal(q, {0.2, 0.3, 0.5}));
}

TEST(PlanSlice, PatchesAreThoseOfThePlan) {
  const auto plan = TestPlan();
  const size_t chunks = plan->chunk_count();
  ASSERT_GT(chunks, 8u);
  for (const auto& [first, last] :
       {std::pair<size_t, size_t>{0, 1}, {0, chunks}, {3, 7}, {chunks - 1, chunks}}) {
    const auto slice = SlicePlan(*plan, first, last);

    const size_t begin = plan->ChunkPatches(first)[0];
    ASSERT_EQ(slice->patches.size(), plan->ChunkPatches(last - 1)[1] - begin);
    ASSERT_EQ(slice->chunk_count(), last - first);
    ASSERT_EQ(slice->outside_box(), plan->outside_box());
    ASSERT_EQ(slice->local_origin, plan->local_origin);
    ASSERT_EQ(slice->seams.size(), plan->seams.size());
    for (size_t p = 0; p < slice->patches.size(); ++p) {
      ExpectSamePatch(*slice, p, *plan, begin + p);
    }
    for (uint32_t box = 0; box <= slice->outside_box(); ++box) {
      for (uint32_t p = slice->box_patches[box]; p < slice->box_patches[box + 1]; ++p) {
        ASSERT_EQ(slice->patches[p].box, box);
      }
    }
    ASSERT_EQ(slice->box_patches.back(), slice->patches.size());
    uint32_t used = 0;  // edges are numbered in the order of first use
    for (const Patch& patch : slice->patches) {
      for (const uint32_t edge : patch.edge) {
        ASSERT_LE(edge, used);
        used = std::max(used, edge + 1);
      }
    }
    ASSERT_EQ(used, slice->edges.size());
  }
}

}  // namespace
}  // namespace latticed::testing
