// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Topology parts cover every patch once, fit in a message, and place each patch in its source face.
#include "server/rpc/topology.h"

#include "core/base/limits.h"
#include "server/engine/scene/topology_id.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed {
namespace {

std::shared_ptr<const DeformPlan> Plan(PolygonMesh mesh, const testing::LatticeOptions& options) {
  const LatticeStructure structure = testing::MakeStructure(mesh.ComputeBounds(), options);
  return *MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), structure);
}

TEST(TopologyTest, BarycentricsPlaceThePatchInItsFace) {
  const auto plan = Plan(testing::TorusMesh(10, 7), {});
  const v1::TopologyPart part = MakeTopologyPart(*plan, "id", 0);

  const PolygonMesh& mesh = *plan->mesh;
  ASSERT_EQ(static_cast<size_t>(part.faces_size()), plan->patches.size());
  EXPECT_EQ(part.patch_count(), plan->patches.size());
  EXPECT_EQ(part.topology_id(), "id");
  for (int p = 0; p < part.faces_size(); ++p) {
    for (int c = 0; c < 3; ++c) {
      Vec3d world;
      for (int k = 0; k < 3; ++k) {
        const uint32_t corner = part.corners(3 * p + k);
        ASSERT_GE(corner, mesh.face_offsets[part.faces(p)]);
        ASSERT_LT(corner, mesh.face_offsets[part.faces(p) + 1]);
        world +=
            part.barycentrics(9 * p + 3 * c + k) * mesh.positions[mesh.corner_vertices[corner]];
      }
      const uint32_t vertex = plan->patches[static_cast<size_t>(p)].vertex[static_cast<size_t>(c)];
      ASSERT_LE(Norm(world - plan->vertices[vertex].world), 1e-12);
    }
  }
}

TEST(TopologyTest, PartsCoverThePatchesAndFitAMessage) {
  const auto plan = Plan(testing::TorusMesh(100, 90), {});
  const size_t patches = plan->patches.size();
  ASSERT_GT(patches, 2 * kPatchesPerTopologyPart);

  size_t seen = 0;
  while (seen < patches) {
    const v1::TopologyPart part = MakeTopologyPart(*plan, "id", seen);
    EXPECT_EQ(part.first_patch(), seen);
    EXPECT_LE(part.ByteSizeLong(), limits::kMaxPartBytes);
    ASSERT_GT(part.faces_size(), 0);
    seen += static_cast<size_t>(part.faces_size());
  }
  EXPECT_EQ(seen, patches);
}

TEST(TopologyTest, MarksPatchesOnTheLatticesFaces) {
  const auto inside = Plan(testing::TorusMesh(10, 7), {.scale = 1.5});
  const auto cut = Plan(testing::TorusMesh(10, 7), {.scale = 0.8});
  const auto count = [](const DeformPlan& plan) {
    const v1::TopologyPart part = MakeTopologyPart(plan, "id", 0);
    return static_cast<uint64_t>(
        std::count(part.on_lattice_face().begin(), part.on_lattice_face().end(), true));
  };
  EXPECT_EQ(count(*inside), 0u);
  EXPECT_GT(count(*cut), 0u);
  EXPECT_EQ(count(*cut), cut->seam_patches);
}

TEST(TopologyTest, KnowsItsIds) {
  const auto plan = Plan(testing::OneTriangle(), {});
  const auto other = Plan(testing::OneTriangle(), {.scale = 2});
  const std::string id = TopologyId("mesh", *plan, 7);
  const int of_tolerance = TopologySegments({.segments = 7, .tolerance = 0.5});
  EXPECT_EQ(of_tolerance, TopologySegments({.segments = 3, .tolerance = 2}));
  EXPECT_TRUE(IsTopologyOf(TopologyId("mesh", *plan, of_tolerance), "mesh", *plan));
  EXPECT_EQ(TopologySegments({.segments = 7}), 7);
  EXPECT_TRUE(IsTopologyOf(id, "mesh", *plan));
  EXPECT_FALSE(IsTopologyOf(id, "another", *plan));
  EXPECT_FALSE(IsTopologyOf(id, "mesh", *other));
  EXPECT_FALSE(IsTopologyOf("", "mesh", *plan));
}

}  // namespace
}  // namespace latticed
