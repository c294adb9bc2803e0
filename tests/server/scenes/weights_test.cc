// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes with vertex weights through the stub: where the weights come from, what they do, and what does not take them. What
// follows their surface is in weighted_surface_test.cc.
#include <cmath>
#include <limits>

#include "core/mesh/mesh_io.h"
#include "tests/server/scenes/weights_fixture.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;
using ::testing::HasSubstr;

// A triangle whose third vertex has the weight 1/2, and one that it leaves out.
constexpr char kWeightedPly[] =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
    "z\n"
    "property float weight\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0 0\n2 0 0 1\n0 2 0 0.5\n3 0 1 2\n";

class WeightsTest : public WeightsFixture {};

TEST_F(WeightsTest, ExportsMoveByTheirWeights) {
  v1::Scene scene;
  ASSERT_OK(Create(Weighted(), &scene));
  EXPECT_TRUE(scene.weighted());
  EXPECT_TRUE(Get().weighted());
  ASSERT_OK(Lift(3));

  for (const auto geometry : {v1::EXPORT_GEOMETRY_UNSPECIFIED, v1::EXPORT_GEOMETRY_ORIGINAL}) {
    auto request = For<v1::ExportRequest>();
    request.set_geometry(geometry);
    const auto bytes = Export(request);
    ASSERT_OK(bytes);
    const auto mesh = ReadMesh(MeshFormat::kPly, *bytes);
    ASSERT_OK(mesh);
    ASSERT_GE(mesh->positions.size(), 9u);
    for (const Vec3d p : mesh->positions) EXPECT_NEAR(p.z, 3 * p.x / 2, 1e-5);
  }
}

TEST_F(WeightsTest, EvaluatedPointsHaveTheWeightsNormals) {
  ASSERT_OK(Create(Weighted()));
  ASSERT_OK(Lift(3));
  auto request = For<v1::EvaluatePointsRequest>();
  *request.mutable_surface_points()->add_points() = PointAt(0.5, 0.25, 0.25);
  v1::EvaluatePointsResponse response;
  ASSERT_OK(Call(&Scenes::EvaluatePoints, request, &response));

  // At x = 1.5 the weight is 3/4, and the plane rises by 3 over a width of 2.
  EXPECT_NEAR(response.positions(0), 1.5, 1e-12);
  EXPECT_NEAR(response.positions(2), 3 * 0.75, 1e-12);
  EXPECT_NEAR(response.normals(0), -1.5 / std::sqrt(3.25), 1e-12);
  EXPECT_NEAR(response.normals(2), 1 / std::sqrt(3.25), 1e-12);
  EXPECT_NEAR(response.jacobians(2), 1.5, 1e-12) << "dz / dx";
}

TEST_F(WeightsTest, PointsOfTheWorldFollowTheLattice) {
  ASSERT_OK(Create(Weighted()));
  ASSERT_OK(Lift(3));
  auto request = For<v1::EvaluatePointsRequest>();
  for (const double x : {0.5, 0.5, 0.0}) request.mutable_world_points()->add_positions(x);
  v1::EvaluatePointsResponse response;
  ASSERT_OK(Call(&Scenes::EvaluatePoints, request, &response));
  EXPECT_NEAR(response.positions(0), 0.5, 1e-12);
  EXPECT_NEAR(response.positions(2), 3, 1e-12);
  EXPECT_NEAR(response.jacobians(2), 0, 1e-12) << "dz / dx";
}

TEST_F(WeightsTest, DraggedPointsReachTheirTargets) {
  ASSERT_OK(Create(Weighted()));
  v1::EditBatch batch = Move("ann", 1, 0, 0);
  auto* drag = batch.mutable_edits(0)->mutable_drag_points();
  *drag->add_points() = PointAt(0.5, 0.25, 0.25);
  for (const double x : {1.4, 0.3, 0.8}) drag->add_targets(x);
  v1::EditResult result;
  ASSERT_OK(Apply(batch, &result));
  EXPECT_LE(result.drag_residual(), 1e-12);

  auto request = For<v1::EvaluatePointsRequest>();
  *request.mutable_surface_points()->add_points() = PointAt(0.5, 0.25, 0.25);
  v1::EvaluatePointsResponse response;
  ASSERT_OK(Call(&Scenes::EvaluatePoints, request, &response));
  EXPECT_NEAR(response.positions(0), 1.4, 1e-12);
  EXPECT_NEAR(response.positions(1), 0.3, 1e-12);
  EXPECT_NEAR(response.positions(2), 0.8, 1e-12);
}

TEST_F(WeightsTest, APointOfWeightZeroCannotBeDragged) {
  ASSERT_OK(Create(Weighted(std::vector<float>(9, 0.0f))));
  v1::EditBatch batch = Move("ann", 1, 0, 0);
  auto* drag = batch.mutable_edits(0)->mutable_drag_points();
  *drag->add_points() = PointAt(0.5, 0.25, 0.25);
  for (const double x : {1.5, 0.25, 2.0}) drag->add_targets(x);
  v1::EditResult result;
  ASSERT_OK(Apply(batch, &result));
  EXPECT_NEAR(result.drag_residual(), 2, 1e-12);
}

TEST_F(WeightsTest, ComeFromTheMeshsFile) {
  v1::MeshHeader header = ObjHeader(kWeightedPly);
  header.set_format(v1::MESH_FORMAT_PLY);
  v1::Mesh mesh;
  ASSERT_OK(ServerTest::Upload(header, kWeightedPly, &mesh));
  EXPECT_TRUE(mesh.has_weights());
  v1::CreateSceneRequest request = SceneRequest();
  request.set_mesh(mesh.id());
  request.mutable_weights()->set_from_mesh(true);
  ASSERT_OK(Create(request));
  ASSERT_OK(Lift(4));
  auto points = For<v1::EvaluatePointsRequest>();
  for (size_t corner = 0; corner < 3; ++corner) {
    v1::SurfacePoint& point = *points.mutable_surface_points()->add_points();
    for (uint32_t c = 0; c < 3; ++c) {
      point.add_corners(c);
      point.add_barycentrics(c == corner ? 1 : 0);
    }
  }
  v1::EvaluatePointsResponse response;
  ASSERT_OK(Call(&Scenes::EvaluatePoints, points, &response));
  EXPECT_NEAR(response.positions(2), 0, 1e-12);
  EXPECT_NEAR(response.positions(5), 4, 1e-12);
  EXPECT_NEAR(response.positions(8), 2, 1e-12);
}

TEST_F(WeightsTest, ComeWithRawArrays) {
  const auto append = [](const auto& values, std::string& bytes) {
    bytes.append(reinterpret_cast<const char*>(values.data()),
                 values.size() * sizeof(values.front()));
  };
  std::string bytes;
  append(std::vector<float>{0, 0, 0, 2, 0, 0, 0, 2, 0}, bytes);
  append(std::vector<uint32_t>{0, 1, 2}, bytes);
  append(std::vector<float>{1, 0.25f, 0}, bytes);
  v1::MeshHeader header = ObjHeader(bytes);
  header.set_format(v1::MESH_FORMAT_RAW);
  header.mutable_raw_layout()->set_vertex_count(3);
  header.mutable_raw_layout()->set_face_count(1);
  header.mutable_raw_layout()->set_face_size(3);
  ExpectRefused(ServerTest::Upload(header, bytes), Code::kInvalidArgument, "INVALID_FIELD",
                "header.raw_layout");
  header.mutable_raw_layout()->set_weights(true);
  v1::Mesh mesh;
  ASSERT_OK(ServerTest::Upload(header, bytes, &mesh));
  v1::CreateSceneRequest request = SceneRequest();
  request.set_mesh(mesh.id());
  request.mutable_weights()->set_from_mesh(true);
  ASSERT_OK(Create(request));
  ASSERT_OK(Lift(4));
  auto points = For<v1::EvaluatePointsRequest>();
  v1::SurfacePoint& point = *points.mutable_surface_points()->add_points();
  for (uint32_t c = 0; c < 3; ++c) {
    point.add_corners(c);
    point.add_barycentrics(c == 1 ? 1 : 0);
  }
  v1::EvaluatePointsResponse response;
  ASSERT_OK(Call(&Scenes::EvaluatePoints, points, &response));
  EXPECT_NEAR(response.positions(2), 1, 1e-12);
}

TEST_F(WeightsTest, RefusesOtherCountsAndValues) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const auto& [bad, problem] :
       std::initializer_list<std::pair<std::vector<float>, std::string>>{
           {{}, "there are 0 for a mesh of 9 vertices"},
           {{0, 1}, "there are 2 for a mesh of 9 vertices"},
           {{0, 0, 0, 0, nan, 0, 0, 0, 0}, "the weight of vertex 4 is nan"},
           {{0, 0, 0, 0, 0, 0, 0, 0, 1.5f}, "the weight of vertex 8 is 1.5"}}) {
    ExpectRefusal(Create(Weighted(bad)),
                  {Code::kInvalidArgument, "INVALID_FIELD", "weights", problem});
  }
  v1::CreateSceneRequest request = SceneRequest();
  request.mutable_weights()->set_values("abc");
  ExpectRefused(Create(request), Code::kInvalidArgument, "INVALID_FIELD", "weights.values");
  request.mutable_weights()->set_from_mesh(true);
  ExpectRefused(Create(request), Code::kInvalidArgument, "INVALID_FIELD", "weights.from_mesh");
  request.mutable_weights()->set_from_mesh(false);
  ExpectRefused(Create(request), Code::kInvalidArgument, "INVALID_FIELD", "weights.from_mesh");
  request.mutable_weights()->clear_source();
  ExpectRefused(Create(request), Code::kInvalidArgument, "INVALID_FIELD", "weights");
  EXPECT_EQ(SceneCount(), 0);
}

TEST_F(WeightsTest, AllPipelinesTakeThem) {
  v1::CreateSceneRequest request = Weighted();
  request.mutable_diagnostics()->set_pipeline(v1::PIPELINE_GEMM);
  v1::Scene scene;
  ASSERT_OK(Create(request, &scene));
  EXPECT_EQ(scene.pipeline(), v1::PIPELINE_GEMM);
}

TEST_F(WeightsTest, RefusesWhatDoesNotTakeThem) {
  ASSERT_OK(Create(Weighted()));
  auto folds = For<v1::CertifyFoldsRequest>();
  folds.set_scope(v1::FOLD_SCOPE_VOLUME);
  ExpectRefusedForWeights(Call(&Scenes::CertifyFolds, folds), "a report of folds in the volume");
}

TEST_F(WeightsTest, PicksHitTheWeightedSurface) {
  ASSERT_OK(Create(Weighted()));
  ASSERT_OK(Lift(3));
  auto pick = For<v1::PickRequest>();
  *pick.mutable_ray()->mutable_origin() = ToVec3({1.5, 0.25, 9});
  *pick.mutable_ray()->mutable_direction() = ToVec3({0, 0, -1});
  v1::SurfacePoint point;
  ASSERT_OK(Call(&Scenes::Pick, pick, &point));
  EXPECT_NEAR(point.position().x(), 1.5, 1e-9);
  EXPECT_NEAR(point.position().z(), 3 * 0.75, 1e-9);
  EXPECT_NEAR(point.normal().x(), -1.5 / std::sqrt(3.25), 1e-9);
}

TEST_F(WeightsTest, OtherWeightsAreAnotherScene) {
  ASSERT_OK(Create(Weighted()));
  EXPECT_OK(Create(Weighted()));
  ExpectRefused(Create(SceneRequest()), Code::kAlreadyExists, "ALREADY_EXISTS");
  ExpectRefused(Create(Weighted(std::vector<float>(9, 0.5f))), Code::kAlreadyExists,
                "ALREADY_EXISTS");
}

TEST_F(WeightsTest, StayWithAnInsertedKnot) {
  ASSERT_OK(Create(Weighted()));
  ASSERT_OK(Lift(3));
  ASSERT_OK(Apply(Knot("ann", 2)));
  const auto mesh = ReadMesh(MeshFormat::kPly, Ply());
  ASSERT_OK(mesh);
  for (const Vec3d p : mesh->positions) EXPECT_NEAR(p.z, 3 * p.x / 2, 1e-5);
}

}  // namespace
}  // namespace latticed::testing
