// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// GetPatchPlan through the stub. tests/core/patches checks the numbers in it.
#include <vector>

#include "tests/server/watch/patches_fixture.h"

namespace latticed::testing {
namespace {

class PatchPlanTest : public PatchesTest {
 protected:
  std::string TopologyId() {
    EventLog log;
    EXPECT_OK(Update(PatchesUpdate(), log));
    return log.topologies.at(0).topology_id();
  }
};

TEST_F(PatchPlanTest, IsAHeaderAndRunsThatAddUp) {
  ASSERT_OK(DeleteScene());
  CreateScene(60);  // 7,200 triangles: several runs
  const std::string id = TopologyId();
  for (const auto& [asked, told] : {std::pair{v1::NORMAL_MODE_UNSPECIFIED, v1::NORMAL_MODE_FACET},
                                    {v1::NORMAL_MODE_NONE, v1::NORMAL_MODE_NONE},
                                    {v1::NORMAL_MODE_FACET, v1::NORMAL_MODE_FACET},
                                    {v1::NORMAL_MODE_SMOOTH, v1::NORMAL_MODE_SMOOTH}}) {
    std::vector<v1::PatchPlanPart> parts;
    ASSERT_OK(GetPlanParts(id, asked, &parts));
    ASSERT_GT(parts.size(), 2u);
    const v1::PatchPlanHeader& header = parts[0].header();
    EXPECT_EQ(header.topology_id(), id);
    EXPECT_EQ(header.normals(), told);
    EXPECT_EQ(header.patch_count(), Get().patches());
    EXPECT_EQ(header.curvature_unit(), 0x1p-31);  // D is 1.47
    EXPECT_FALSE(header.has_outside_lower());
    uint64_t patches = 0, vertices = 0, normals = 0;
    for (size_t i = 1; i < parts.size(); ++i) {
      EXPECT_LT(parts[i].ByteSizeLong(), size_t{1} << 20);
      const v1::PatchRun& run = parts[i].run();
      EXPECT_EQ(run.first_patch(), patches);
      EXPECT_LE(run.patches(), 4'096u);
      patches += run.patches();
      vertices += run.new_vertices();
      normals += run.new_normals();
    }
    EXPECT_EQ(patches, header.patch_count());
    EXPECT_EQ(vertices, header.vertex_count());
    EXPECT_EQ(normals, header.normal_count());
    EXPECT_EQ(normals == 0, told == v1::NORMAL_MODE_NONE);
    EXPECT_OK(Decode(parts).status());
  }
}

TEST_F(PatchPlanTest, HasSeamsWhereTheSurfaceGoesOnOutside) {
  v1::CreateSceneRequest create = SceneRequest("half");
  SetFrame(*create.add_lattices()->mutable_lattice()->mutable_frame(), {-0.1, -0.1, -1},
           {0.7, 1.2, 2});
  v1::Scene scene;
  ASSERT_OK(Create(create, &scene));
  ASSERT_GT(scene.patches_on_faces(), 0u);
  auto update = PatchesUpdate();
  update.set_scene("half");
  EventLog log;
  ASSERT_OK(Update(update, log));
  auto request = For<v1::GetPatchPlanRequest>("half");
  request.set_topology_id(log.topologies.at(0).topology_id());
  std::vector<v1::PatchPlanPart> parts;
  ASSERT_OK(ReadAll(&Scenes::GetPatchPlan, request, &parts));

  EXPECT_TRUE(parts.front().header().has_outside_lower());
  EXPECT_EQ(parts.front().header().patches_outside(), scene.patches_outside());
  EXPECT_TRUE(parts.back().has_seams());
  EXPECT_GT(parts.back().seams().identity_points_size(), 0);
  EXPECT_OK(Decode(parts).status());
}

TEST_F(PatchPlanTest, OfAnotherTopologyIsNotFound) {
  const std::string id = TopologyId();
  EventLog uniform;
  ASSERT_OK(Update(4, kScene, &uniform));
  for (const std::string& other :
       {std::string(), std::string("nothing"), uniform.topologies.at(0).topology_id()}) {
    ExpectRefused(GetPlanParts(other, v1::NORMAL_MODE_NONE, nullptr), absl::StatusCode::kNotFound,
                  "NOT_FOUND");
  }
  v1::EditBatch knot = Move(1, 0, 0);
  knot.mutable_edits(0)->mutable_insert_knot()->set_value(0.4);
  ASSERT_OK(Apply(knot));
  ExpectRefused(GetPlanParts(id, v1::NORMAL_MODE_NONE, nullptr), absl::StatusCode::kNotFound,
                "NOT_FOUND");
  ASSERT_OK(GetPlanParts(TopologyId(), v1::NORMAL_MODE_NONE, nullptr));
}

TEST_F(PatchPlanTest, UnknownNormalsAreRefused) {
  ExpectRefused(GetPlanParts(TopologyId(), static_cast<v1::NormalMode>(99), nullptr),
                absl::StatusCode::kInvalidArgument, "UNSUPPORTED", "normals");
}

TEST_F(PatchPlanTest, DoesNotChangeWithControlPoints) {
  const std::string id = TopologyId();
  std::vector<v1::PatchPlanPart> before, after;
  ASSERT_OK(GetPlanParts(id, v1::NORMAL_MODE_SMOOTH, &before));
  ASSERT_OK(Apply(Move(1, 62, 0.3)));
  ASSERT_OK(GetPlanParts(id, v1::NORMAL_MODE_SMOOTH, &after));
  ASSERT_EQ(before.size(), after.size());
  for (size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(before[i].SerializeAsString(), after[i].SerializeAsString());
  }
}

}  // namespace
}  // namespace latticed::testing
