// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// SceneService's unary rpcs through the stub: their replies, and every refusal with its reason and
// field.
#include <limits>

#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

using ::testing::ElementsAre;
using Code = absl::StatusCode;

class SceneServiceTest : public SceneFixture {};

TEST_F(SceneServiceTest, CreatesASceneWithTheDefaults) {
  v1::Scene scene;
  ASSERT_OK(Create(SceneRequest(), &scene));

  EXPECT_EQ(scene.id(), "scene-one");
  EXPECT_EQ(scene.mesh(), mesh_);
  ASSERT_EQ(scene.lattices_size(), 1);
  EXPECT_EQ(scene.lattices(0).size().u(), 4);
  EXPECT_EQ(scene.lattices(0).degree().w(), 2);
  // Bounds 2 x 2 x 0, padding 0.05 of the longest edge on every side.
  EXPECT_NEAR(scene.lattices(0).frame().origin().z(), -0.1, 1e-12);
  EXPECT_NEAR(scene.lattices(0).frame().w().z(), 0.2, 1e-12);
  EXPECT_EQ(scene.default_view().segments(), 10);
  EXPECT_EQ(scene.default_view().normals(), v1::NORMAL_MODE_FACET);
  EXPECT_EQ(scene.idle_ttl().seconds(), 86400);
  EXPECT_EQ(scene.pipeline(), v1::PIPELINE_FUSED);
  EXPECT_EQ(scene.revision(), 0u);
  EXPECT_EQ(scene.structure_id(), 1u);
  EXPECT_GE(scene.patches(), 8u);
  EXPECT_EQ(scene.patches_outside(), 0u);
  EXPECT_EQ(scene.chunks(), (scene.patches() + 31) / 32);
  EXPECT_GT(scene.bytes().at("plan"), 0u);
  EXPECT_GT(scene.create_time().seconds(), 0);
  EXPECT_NEAR(static_cast<double>(scene.expire_time().seconds() - scene.create_time().seconds()),
              86400, 2);
}

TEST_F(SceneServiceTest, CreatesASceneAsTold) {
  v1::CreateSceneRequest request = SceneRequest();
  auto* fit = request.add_lattices()->mutable_fit();
  SetAxes(*fit->mutable_size(), 5, 4, 3);
  SetAxes(*fit->mutable_degree(), 3, 1, 2);
  request.mutable_default_view()->set_segments(3);
  request.mutable_default_view()->set_encoding(v1::ENCODING_RAW);
  request.mutable_idle_ttl()->set_seconds(90);
  request.mutable_idle_ttl()->set_nanos(500'000'000);
  (*request.mutable_labels())["team"] = "red";
  request.mutable_diagnostics()->set_pipeline(v1::PIPELINE_GEMM);

  v1::Scene scene;
  ASSERT_OK(Create(request, &scene));

  EXPECT_EQ(scene.lattices(0).degree().u(), 3);
  EXPECT_EQ(scene.lattices(0).size().w(), 3);
  EXPECT_EQ(scene.default_view().segments(), 3);
  EXPECT_EQ(scene.default_view().encoding(), v1::ENCODING_RAW);
  EXPECT_EQ(scene.idle_ttl().seconds(), 90);
  EXPECT_EQ(scene.idle_ttl().nanos(), 500'000'000);
  EXPECT_EQ(scene.labels().at("team"), "red");
  EXPECT_EQ(scene.pipeline(), v1::PIPELINE_GEMM);
}

TEST_F(SceneServiceTest, UnitsAreThoseOfTheSceneElseOfTheMesh) {
  v1::Scene scene;
  ASSERT_OK(Create(SceneRequest("unknown-units"), &scene));
  EXPECT_EQ(scene.units().up_axis(), v1::UP_AXIS_UNSPECIFIED);
  EXPECT_EQ(scene.units().meters_per_unit(), 0);

  v1::MeshHeader header = ObjHeader(CubeObj(3));
  header.mutable_units()->set_up_axis(v1::UP_AXIS_X);
  header.mutable_units()->set_meters_per_unit(0.01);
  v1::Mesh mesh;
  ASSERT_OK(Upload(header, CubeObj(3), &mesh));
  v1::CreateSceneRequest request = SceneRequest("units-of-the-mesh");
  request.set_mesh(mesh.id());
  ASSERT_OK(Create(request, &scene));
  EXPECT_EQ(scene.units().up_axis(), v1::UP_AXIS_X);
  EXPECT_EQ(scene.units().meters_per_unit(), 0.01);

  request.set_scene_id("another-up-axis");
  request.mutable_units()->set_up_axis(v1::UP_AXIS_Y);
  ASSERT_OK(Create(request, &scene));
  EXPECT_EQ(scene.units().up_axis(), v1::UP_AXIS_Y);
  EXPECT_EQ(scene.units().meters_per_unit(), 0.01);

  request.set_scene_id("bad-units");
  request.mutable_units()->set_meters_per_unit(-1);
  ExpectRefused(Create(request), Code::kInvalidArgument, "OUT_OF_RANGE", "units.meters_per_unit");
  request.mutable_units()->set_meters_per_unit(0);
  request.mutable_units()->set_up_axis(static_cast<v1::UpAxis>(9));
  ExpectRefused(Create(request), Code::kInvalidArgument, "UNSUPPORTED", "units.up_axis");
}

TEST_F(SceneServiceTest, ANameIsTheMeshsUnlessOneIsGiven) {
  v1::MeshHeader header = ObjHeader(CubeObj(3));
  header.set_name("big.cow.obj");
  v1::Mesh mesh;
  ASSERT_OK(Upload(header, CubeObj(3), &mesh));
  v1::CreateSceneRequest request = SceneRequest("c");
  request.set_mesh(mesh.id());
  v1::Scene scene;
  ASSERT_OK(Create(request, &scene));
  EXPECT_EQ(scene.name(), "big.cow");

  request.set_scene_id("d");
  request.set_name("../Kuh: Ä");
  ASSERT_OK(Create(request, &scene));
  EXPECT_EQ(scene.name(), "../Kuh: Ä");
  request.set_scene_id("e");
  request.set_name(std::string(256, 'a'));
  ExpectRefused(Create(request), Code::kInvalidArgument, "OUT_OF_RANGE", "name");
}

TEST_F(SceneServiceTest, ACreaseAngleIsKeptAndMakesShadingSmooth) {
  v1::Mesh mesh;
  ASSERT_OK(Upload(ObjHeader(CubeObj(3)), CubeObj(3), &mesh));
  v1::CreateSceneRequest request = SceneRequest("no-crease-angle");
  request.set_mesh(mesh.id());
  v1::Scene scene;
  ASSERT_OK(Create(request, &scene));
  EXPECT_FALSE(scene.has_crease_angle());
  EXPECT_EQ(scene.default_view().normals(), v1::NORMAL_MODE_FACET);

  request.set_scene_id("a-crease-angle");
  request.set_crease_angle(0);
  ASSERT_OK(Create(request, &scene));
  EXPECT_TRUE(scene.has_crease_angle());
  EXPECT_EQ(scene.crease_angle(), 0);
  EXPECT_EQ(scene.default_view().normals(), v1::NORMAL_MODE_SMOOTH);

  request.set_scene_id("a-wrong-crease-angle");
  for (const double wrong : {-1., 180.5, std::numeric_limits<double>::quiet_NaN()}) {
    request.set_crease_angle(wrong);
    ExpectRefused(Create(request), Code::kInvalidArgument, "OUT_OF_RANGE", "crease_angle");
  }
}

TEST_F(SceneServiceTest, TheSameRequestReturnsTheSameScene) {
  ASSERT_OK(Create(SceneRequest()));
  ASSERT_OK(Apply(Move("ann", 1, 0, 0.1)));

  v1::Scene again;
  ASSERT_OK(Create(SceneRequest(), &again));
  EXPECT_EQ(again.revision(), 1u);

  v1::CreateSceneRequest other = SceneRequest();
  other.mutable_idle_ttl()->set_seconds(5);
  ExpectRefused(Create(other), Code::kAlreadyExists, "ALREADY_EXISTS");
}

TEST_F(SceneServiceTest, RefusesBadCreations) {
  for (const std::string id : {"", "Upper-case", "under_score"}) {
    ExpectRefused(Create(SceneRequest(id)), Code::kInvalidArgument, "INVALID_FIELD", "scene_id");
  }
  ExpectRefused(Create(SceneRequest(std::string(64, 'a'))), Code::kInvalidArgument, "INVALID_FIELD",
                "scene_id");
  ASSERT_OK(Create(SceneRequest(std::string(63, 'a'))));

  v1::CreateSceneRequest request = SceneRequest();
  request.set_mesh("");
  ExpectRefused(Create(request), Code::kInvalidArgument, "INVALID_FIELD", "mesh");
  request.set_mesh("nothing");
  ExpectRefused(Create(request), Code::kNotFound, "NOT_FOUND");

  request = SceneRequest();
  (*request.mutable_labels())["No Good"] = "";
  ExpectRefused(Create(request), Code::kInvalidArgument, "INVALID_FIELD", "labels");

  request = SceneRequest();
  request.mutable_diagnostics()->set_pipeline(static_cast<v1::Pipeline>(99));
  ExpectRefused(Create(request), Code::kInvalidArgument, "UNSUPPORTED", "diagnostics.pipeline");
}

TEST_F(SceneServiceTest, RefusesIdleTtlsOutOfRange) {
  struct Ttl {
    int64_t seconds;
    int32_t nanos;
  };
  v1::CreateSceneRequest request = SceneRequest();
  const auto set = [&request](const Ttl& ttl) {
    request.mutable_idle_ttl()->set_seconds(ttl.seconds);
    request.mutable_idle_ttl()->set_nanos(ttl.nanos);
  };
  for (const Ttl ttl :
       {Ttl{0, 0}, {-1, 0}, {0, -1}, {1, -1}, {1, 1'000'000'000}, {315'576'000'001, 0}}) {
    set(ttl);
    const absl::Status status = Create(request);
    ExpectRefused(status, Code::kInvalidArgument, "OUT_OF_RANGE", "idle_ttl");
    EXPECT_EQ(status.message(),
              fmt::format("idle_ttl: got {} s and {} ns, allowed is 0 to 315576000000 s with 0 to "
                          "999999999 ns, not both 0",
                          ttl.seconds, ttl.nanos));
  }
  set({0, 1});
  EXPECT_OK(Create(request));
}

TEST_F(SceneServiceTest, GetsAndDeletes) {
  ASSERT_OK(Create(SceneRequest()));
  EXPECT_EQ(Get().id(), "scene-one");

  ASSERT_OK(DeleteScene());
  ExpectRefused(DeleteScene(), Code::kNotFound, "NOT_FOUND");
  ExpectRefused(Call(&Scenes::GetScene, For<v1::GetSceneRequest>()), Code::kNotFound, "NOT_FOUND");
  ExpectRefused(Apply(Move("ann", 1, 0, 1)), Code::kNotFound, "NOT_FOUND");
  ASSERT_OK(Create(SceneRequest()));
}

TEST_F(SceneServiceTest, SceneIdsAreRequiredAndMustMatchTheMetadata) {
  ASSERT_OK(Create(SceneRequest()));
  ExpectRefused(Call(&Scenes::GetScene, {}), Code::kInvalidArgument, "INVALID_FIELD", "scene");
  const Metadata same = {{"latticed-scene", kScene}}, other = {{"latticed-scene", "scene-two"}};
  EXPECT_OK(Call(&Scenes::GetScene, For<v1::GetSceneRequest>(), nullptr, same));
  for (const absl::Status& status :
       {Call(&Scenes::GetScene, For<v1::GetSceneRequest>(), nullptr, other),
        Call(&Scenes::CreateScene, SceneRequest(), nullptr, other)}) {
    EXPECT_THAT(status, StatusIs(Code::kInvalidArgument));
    EXPECT_EQ(Reason(status), "SCENE_MISMATCH");
  }
}

TEST_F(SceneServiceTest, ListsByPageAndLabelOldestFirst) {
  for (const std::string id : {"zzzzzzzz", "aaaaaaaa", "mmmmmmmm"}) {
    v1::CreateSceneRequest request = SceneRequest(id);
    (*request.mutable_labels())["team"] = id == "aaaaaaaa" ? "blue" : "red";
    ASSERT_OK(Create(request));
  }
  const auto list = [this](int size, const std::string& token, const std::string& filter,
                           std::string* next) {
    v1::ListScenesRequest request;
    request.set_page_size(size);
    request.set_page_token(token);
    request.set_filter(filter);
    v1::ListScenesResponse response;
    EXPECT_OK(Call(&Scenes::ListScenes, request, &response));
    std::vector<std::string> ids;
    for (const v1::Scene& scene : response.scenes()) ids.push_back(scene.id());
    *next = response.next_page_token();
    return ids;
  };
  std::string next;
  EXPECT_THAT(list(0, "", "", &next), ElementsAre("zzzzzzzz", "aaaaaaaa", "mmmmmmmm"));
  EXPECT_EQ(next, "");
  EXPECT_THAT(list(2, "", "", &next), ElementsAre("zzzzzzzz", "aaaaaaaa"));
  EXPECT_THAT(list(2, next, "", &next), ElementsAre("mmmmmmmm"));
  EXPECT_EQ(next, "");
  EXPECT_THAT(list(10, "", "team=red", &next), ElementsAre("zzzzzzzz", "mmmmmmmm"));
  EXPECT_THAT(list(10, "", "team", &next), ElementsAre("zzzzzzzz", "aaaaaaaa", "mmmmmmmm"));
  EXPECT_THAT(list(10, "", "team=green", &next), ElementsAre());

  const auto refuses = [this](int size, const std::string& token, const std::string& filter,
                              const std::string& reason, const std::string& field) {
    v1::ListScenesRequest bad;
    bad.set_page_size(size);
    bad.set_page_token(token);
    bad.set_filter(filter);
    ExpectRefused(Call(&Scenes::ListScenes, bad), Code::kInvalidArgument, reason, field);
  };
  refuses(1001, "", "", "OUT_OF_RANGE", "page_size");
  refuses(1, "nonsense", "", "INVALID_FIELD", "page_token");
  refuses(1, "", "=", "INVALID_FIELD", "filter");
}

TEST_F(SceneServiceTest, EditsChangeTheLattice) {
  ASSERT_OK(Create(SceneRequest()));
  const v1::LatticeState before = Lattice();
  EXPECT_EQ(before.revision(), 0u);
  ASSERT_EQ(before.lattice().control_points_size(), 192);
  EXPECT_EQ(before.lattice().knots_u_size(), 7);

  v1::EditResult result;
  ASSERT_OK(Apply(Move("ann", 1, 21, 0.25), &result));
  EXPECT_EQ(result.sequence(), 1u);
  EXPECT_EQ(result.revision(), 1u);
  EXPECT_EQ(result.largest_move(), 0.25);
  EXPECT_GT(result.boxes_touched(), 0u);
  EXPECT_GT(result.patches_touched(), 0u);
  const v1::LatticeState after = Lattice();
  EXPECT_EQ(after.revision(), 1u);
  EXPECT_NEAR(after.lattice().control_points(63) - before.lattice().control_points(63), 0.25,
              1e-15);

  v1::EditResult again;
  ASSERT_OK(Apply(Move("ann", 1, 21, 0.25), &again));  // a retry
  EXPECT_EQ(again.revision(), 1u);
  EXPECT_EQ(again.patches_touched(), result.patches_touched());
}

TEST_F(SceneServiceTest, RefusedEditsNameTheFieldAndChangeNothing) {
  ASSERT_OK(Create(SceneRequest()));
  ASSERT_OK(Apply(Move("ann", 5, 0, 0.1)));
  ExpectRefused(Apply(Move("ann", 4, 0, 0.1)), Code::kAborted, "OUT_OF_ORDER");
  v1::EditBatch late = Move("ann", 10, 0, 0.1);
  late.set_expected_revision(0);
  ExpectRefused(Apply(late), Code::kAborted, "REVISION_CHANGED");
  v1::EditBatch undo = Move("bob", 1, 0, 0);
  undo.mutable_edits(0)->mutable_undo();
  ExpectRefused(Apply(undo), Code::kFailedPrecondition, "NOTHING_TO_UNDO");
  undo.mutable_edits(0)->mutable_redo();
  undo.set_sequence(2);
  ExpectRefused(Apply(undo), Code::kFailedPrecondition, "NOTHING_TO_REDO");
  ExpectRefused(Apply(Move("", 1, 0, 0.1)), Code::kInvalidArgument, "INVALID_FIELD", "editor_id");

  EXPECT_EQ(Get().revision(), 1u);
}

TEST_F(SceneServiceTest, UndoConflictNamesTheEditor) {
  ASSERT_OK(Create(SceneRequest()));
  ASSERT_OK(Apply(Move("ann", 1, 0, 0.1)));
  ASSERT_OK(Apply(Move("bob", 1, 0, 0.1)));
  v1::EditBatch undo = Move("ann", 2, 0, 0);
  undo.mutable_edits(0)->mutable_undo();

  const absl::Status status = Apply(undo);

  ExpectRefused(status, Code::kAborted, "UNDO_CONFLICT");
  EXPECT_EQ(error::DetailsOf(status).metadata.at("editor_id"), "bob");
}

}  // namespace
}  // namespace latticed::testing
