// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes with vertex weights through the stub: where the weights come from, what they do, and what does not take them.
#include <cmath>
#include <limits>

#include "core/mesh/mesh_io.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;
using ::testing::HasSubstr;

// kGridObj has 3 x 3 vertices on [0,2]^2: those at x = 0 rest, those at x = 2 follow.
const std::vector<float> kGridWeights = {0, 0.5f, 1, 0, 0.5f, 1, 0, 0.5f, 1};
// A triangle whose third vertex has the weight 1/2, and one that it leaves out.
constexpr char kWeightedPly[] =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
    "z\n"
    "property float weight\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0 0\n2 0 0 1\n0 2 0 0.5\n3 0 1 2\n";

std::string BytesOf(const std::vector<float>& weights) {
  return {reinterpret_cast<const char*>(weights.data()), weights.size() * sizeof(float)};
}

class WeightsTest : public SceneFixture {
 protected:
  v1::CreateSceneRequest Weighted(const std::vector<float>& weights = kGridWeights) const {
    v1::CreateSceneRequest request = SceneRequest();
    request.mutable_weights()->set_values(BytesOf(weights));
    return request;
  }
  // Lifts all control points by `z`.
  absl::Status Lift(double z) {
    v1::EditBatch lift = Move("ann", 1, 0, 0);
    auto* all = lift.mutable_edits(0)->mutable_move_control_points();
    all->clear_indices();
    for (uint32_t i = 0; i < 64; ++i) all->add_indices(i);
    all->mutable_offset()->set_z(z);
    return Apply(lift);
  }
  // Where the second face's triangle (1,0), (2,0), (2,1) has its point with these barycentrics.
  static v1::SurfacePoint PointAt(double a, double b, double c) {
    v1::SurfacePoint point;
    point.set_face(1);
    for (const uint32_t corner : {4u, 5u, 6u}) point.add_corners(corner);
    for (const double number : {a, b, c}) point.add_barycentrics(number);
    return point;
  }
  void ExpectRefusedForWeights(const absl::Status& status, const std::string& what,
                               const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
    ExpectRefusal(status, {Code::kFailedPrecondition, "VERTEX_WEIGHTS", "", what}, file, line);
  }
};

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

TEST_F(WeightsTest, RefusesScenesThatDoNotTakeThem) {
  v1::CreateSceneRequest request = Weighted();
  request.mutable_diagnostics()->set_pipeline(v1::PIPELINE_GEMM);
  ExpectRefusedForWeights(Create(request), "a pipeline other than fused");
  request = Weighted();
  request.set_fold_watch(true);
  ExpectRefusedForWeights(Create(request), "fold_watch");
  request = Weighted();
  request.mutable_default_view()->set_encoding(v1::ENCODING_PATCHES);
  ExpectRefusedForWeights(Create(request), "the encoding patches");
  EXPECT_EQ(SceneCount(), 0);
}

TEST_F(WeightsTest, RefusesWhatDoesNotTakeThem) {
  ASSERT_OK(Create(Weighted()));
  EventLog log;
  auto update = For<v1::GetUpdateRequest>();
  update.mutable_view()->set_encoding(v1::ENCODING_PATCHES);
  ExpectRefusedForWeights(Update(update, log), "the encoding patches");

  auto exported = For<v1::ExportRequest>();
  exported.set_format(v1::EXPORT_FORMAT_CONTROL_NETS);
  ExpectRefusedForWeights(Export(exported).status(), "a control net");

  ExpectRefusedForWeights(Call(&Scenes::CertifyFolds, For<v1::CertifyFoldsRequest>()),
                          "a report of folds");
}

TEST_F(WeightsTest, RefusesEditsThatDoNotTakeThem) {
  ASSERT_OK(Create(Weighted()));
  v1::EditBatch batch = Move("ann", 1, 21, 0.1);
  batch.set_refuse_folds(true);
  ExpectRefusedForWeights(Apply(batch), "refuse_folds");
  EXPECT_EQ(Get().revision(), 0u);
}

TEST_F(WeightsTest, ViewsWithAToleranceAreWithinIt) {
  v1::CreateSceneRequest request = Weighted();
  request.mutable_default_view()->set_tolerance(0.01);
  ASSERT_OK(Create(request));
  const auto update_of = [&](EventLog& log) {
    auto update = For<v1::GetUpdateRequest>();
    update.mutable_view()->set_tolerance(1e-3);
    update.mutable_view()->set_encoding(v1::ENCODING_RAW);
    update.mutable_view()->set_normals(v1::NORMAL_MODE_NONE);
    return Update(update, log);
  };
  const auto points = [](const EventLog& log) {
    size_t bytes = 0;
    for (const auto& [chunk, data] : log.chunks) bytes += data.size();
    return bytes / (3 * sizeof(float));
  };
  EventLog lifted, bent;
  ASSERT_OK(Lift(3));
  ASSERT_OK(update_of(lifted));
  v1::EditBatch batch = Move("ann", 2, 21, 0.7);
  ASSERT_OK(Apply(batch));
  ASSERT_OK(update_of(bent));

  EXPECT_LE(lifted.ends.back().certified_error(), 1e-3);
  EXPECT_LE(bent.ends.back().certified_error(), 1e-3);
  // w and the lift are linear: the corners of patches suffice.
  EXPECT_EQ(points(lifted), 3 * Get().patches());
  EXPECT_GT(points(bent), 3 * Get().patches());
}

// A unit cube whose bottom rests and whose top follows.
class WeightedCubeTest : public WeightsTest {
 protected:
  void SetUp() override {
    WeightsTest::SetUp();
    mesh_ = Upload(CubeObj());
    ASSERT_OK(Create(Weighted({0, 0, 0, 0, 1, 1, 1, 1})));
  }
  v1::MeasureSceneResponse Measured() {
    auto request = For<v1::MeasureSceneRequest>();
    for (const auto measure :
         {v1::MEASURE_VOLUME, v1::MEASURE_AREA, v1::MEASURE_CENTROID, v1::MEASURE_BOUNDS}) {
      request.add_measures(measure);
    }
    request.set_with_gradient(true);
    v1::MeasureSceneResponse response;
    EXPECT_OK(Call(&Scenes::MeasureScene, request, &response));
    return response;
  }
  // The derivative when all control points move along z.
  static double SumOfZ(const google::protobuf::RepeatedField<double>& gradient) {
    double sum = 0;
    for (int i = 2; i < gradient.size(); i += 3) sum += gradient[i];
    return sum;
  }
};

TEST_F(WeightedCubeTest, MeasuresTheWeightedSurface) {
  ASSERT_OK(Lift(1));

  const v1::MeasureSceneResponse got = Measured();

  EXPECT_NEAR(got.volume(), 2, 1e-12);
  EXPECT_NEAR(got.area(), 10, 1e-5);
  EXPECT_LE(got.area_error(), 1e-6 * got.area());
  EXPECT_NEAR(got.centroid().x(), 0.5, 1e-12);
  EXPECT_NEAR(got.centroid().z(), 1, 1e-12);
  EXPECT_NEAR(got.least().z(), 0, 1e-9);
  EXPECT_NEAR(got.greatest().z(), 2, 1e-8);
  EXPECT_NEAR(SumOfZ(got.volume_gradient()), 1, 1e-12);
  EXPECT_NEAR(SumOfZ(got.area_gradient()), 4, 1e-5);
  ASSERT_EQ(got.centroid_gradient_size(), 9 * 64);
  double rise = 0;  // three derivatives for each coordinate; z by z is the last
  for (int i = 8; i < got.centroid_gradient_size(); i += 9) rise += got.centroid_gradient(i);
  EXPECT_NEAR(rise, 0.5, 1e-12);
}

TEST_F(WeightedCubeTest, KeepsAVolume) {
  v1::EditBatch batch = Move("ann", 1, 42, 0.5);
  batch.mutable_keep_volume();
  ASSERT_OK(Apply(batch));
  EXPECT_NEAR(Measured().volume(), 1, 1e-12);
  EXPECT_GT(std::abs(Measured().centroid().x() - 0.5), 1e-4);
}

TEST_F(WeightsTest, AnOpenWeightedSurfaceHasNoVolume) {
  ASSERT_OK(Create(Weighted()));
  auto request = For<v1::MeasureSceneRequest>();
  request.add_measures(v1::MEASURE_VOLUME);
  ExpectRefused(Call(&Scenes::MeasureScene, request), Code::kFailedPrecondition, "OPEN_SURFACE");
  v1::EditBatch batch = Move("ann", 1, 21, 0.1);
  batch.mutable_keep_volume();
  ExpectRefused(Apply(batch), Code::kFailedPrecondition, "OPEN_SURFACE");
  EXPECT_EQ(Get().revision(), 0u);
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
