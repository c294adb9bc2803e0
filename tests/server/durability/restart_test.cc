// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A server that is started again on its folder: the same meshes, scenes, lattices and undo steps, also where another
// part of the folder is damaged.
#include <filesystem>
#include <fstream>

#include "server/store/records/scene_log.pb.h"
#include "server/store/sqlite_store.h"
#include "tests/server/support/server_test.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

// As servers wrote headers before lists woke nothing.
template <typename Header>
std::string WithoutListing(const std::string& bytes) {
  Header header;
  EXPECT_TRUE(header.ParseFromString(bytes));
  EXPECT_FALSE(header.listing().empty());
  header.clear_listing();
  return header.SerializeAsString();
}

class RestartTest : public SceneFixture {
 protected:
  void SetUp() override { Restart(); }
  void Restart() {
    server_.reset();
    Options options;
    options.data_dir = folder_.Path("data");
    SceneFixture::StartServer(options);  // uploads kGridObj, which may be there already
  }
  std::string MeshFile(const std::string& id) const { return folder_.Path("data/meshes/" + id); }

  TemporaryFolder folder_;
};

TEST_F(RestartTest, AServerSaysWhetherItKeepsWhatItIsGiven) {
  EXPECT_TRUE(Info().durable());
  server_.reset();
  SceneFixture::StartServer({});
  EXPECT_FALSE(Info().durable());
}

TEST_F(RestartTest, WeightsComeBack) {
  v1::CreateSceneRequest request = SceneRequest();
  const std::vector<float> weights = {0, 0.25f, 0.5f, 1, 1, 0.75f, 0, 0, 1};
  request.mutable_weights()->set_values(reinterpret_cast<const char*>(weights.data()),
                                        weights.size() * sizeof(float));
  ASSERT_OK(Create(request));
  ASSERT_OK(Apply(Move("ann", 1, 5, 0.5)));
  const std::string ply = Ply();

  Restart();

  EXPECT_TRUE(Get().weighted());
  EXPECT_EQ(Ply(), ply);
  EXPECT_OK(Create(request));  // the same request is still the same scene
  ExpectRefused(Create(SceneRequest()), absl::StatusCode::kAlreadyExists, "ALREADY_EXISTS");
}

TEST_F(RestartTest, ScenesAndMeshesComeBackWithAllTheirBits) {
  const std::string cube = Upload(CubeObj());
  ASSERT_OK(Create(SceneRequest()));
  ASSERT_OK(Apply(Move("ann", 1, 5, 0.1)));
  ASSERT_OK(Apply(Move("bob", 1, 6, 1e-17)));
  ASSERT_OK(Apply(Knot("ann", 2)));
  const v1::Scene scene = Get();
  const v1::LatticeState lattice = Lattice();
  const std::string ply = Ply();

  Restart();
  EXPECT_EQ(MeshCount(), 2);
  EXPECT_EQ(SceneCount(), 1);
  const v1::Scene again = Get();
  EXPECT_EQ(again.revision(), 3u);
  EXPECT_EQ(again.structure_id(), scene.structure_id());
  EXPECT_EQ(again.patches(), scene.patches());
  EXPECT_EQ(again.mesh(), scene.mesh());
  EXPECT_EQ(again.name(), scene.name());
  EXPECT_EQ(again.create_time().nanos(), scene.create_time().nanos());
  EXPECT_EQ(Lattice().SerializeAsString(), lattice.SerializeAsString());
  EXPECT_EQ(Ply(), ply);

  // The same request is still the same scene, and an edit that comes again counts once.
  EXPECT_OK(Create(SceneRequest()));
  v1::EditResult result;
  EXPECT_OK(Apply(Knot("ann", 2), &result));
  EXPECT_EQ(result.revision(), 3u);
  EXPECT_OK(Apply(UndoMine("ann", 3)));
  EXPECT_OK(Apply(UndoMine("ann", 4)));
  EXPECT_OK(Apply(UndoMine("bob", 2)));
  ExpectRefused(Apply(UndoMine("bob", 3)), absl::StatusCode::kFailedPrecondition,
                "NOTHING_TO_UNDO");
  EXPECT_EQ(Get().revision(), 6u);
}

TEST_F(RestartTest, ConstraintsAreKeptAndHonoured) {
  mesh_ = Upload(CubeObj());
  ASSERT_OK(Create(SceneRequest()));
  v1::EditBatch batch = Move("ann", 1, 0, 0);
  auto& constraints = *batch.mutable_edits(0)->mutable_set_constraints()->mutable_constraints();
  constraints.add_held(21);
  constraints.mutable_volume();
  ASSERT_OK(Apply(batch));
  ASSERT_OK(Apply(Move("ann", 2, 22, 0.1)));
  const v1::LatticeState before = Lattice();
  const double kept = MeasuredVolume();

  Restart();

  EXPECT_EQ(Lattice().SerializeAsString(), before.SerializeAsString());
  EXPECT_EQ(MeasuredVolume(), kept);
  ASSERT_OK(Apply(Move("ann", 3, 21, 0.3)));  // held
  EXPECT_EQ(Lattice().lattice().control_points(3 * 21), before.lattice().control_points(3 * 21));
  ASSERT_OK(Apply(Move("ann", 4, 22, 0.3)));
  EXPECT_NEAR(MeasuredVolume() / kept, 1, 2e-12);
  EXPECT_NE(Lattice().lattice().control_points(3 * 22), before.lattice().control_points(3 * 22));
  // Undo goes back over the restart, to before the constraints.
  for (uint64_t sequence = 5; sequence <= 8; ++sequence)
    ASSERT_OK(Apply(UndoMine("ann", sequence)));
  EXPECT_FALSE(Lattice().has_constraints());
}

TEST_F(RestartTest, WhatWasDeletedStaysDeleted) {
  const std::string cube = Upload(CubeObj());
  ASSERT_OK(Create(SceneRequest()));
  ASSERT_OK(DeleteScene());
  ASSERT_OK(DeleteMesh(cube));

  Restart();
  EXPECT_EQ(SceneCount(), 0);
  EXPECT_EQ(MeshCount(), 1);
  EXPECT_OK(Create(SceneRequest()));
  EXPECT_EQ(Get().revision(), 0u);
}

TEST_F(RestartTest, AListWakesNothing) {
  v1::CreateSceneRequest request = SceneRequest();
  request.set_name("a grid");
  (*request.mutable_labels())["kind"] = "test";
  ASSERT_OK(Create(request));
  ASSERT_OK(Apply(Move("ann", 1, 5, 0.1)));
  Restart();
  const auto list = [this](const std::string& filter) {
    v1::ListScenesRequest ask;
    ask.set_filter(filter);
    v1::ListScenesResponse page;
    EXPECT_OK(Call(&Scenes::ListScenes, ask, &page));
    return page;
  };
  for (int i = 0; i < 2; ++i) {
    const v1::ListScenesResponse page = list("kind=test");
    ASSERT_EQ(page.scenes_size(), 1);
    EXPECT_TRUE(page.scenes(0).asleep());
    EXPECT_EQ(page.scenes(0).name(), "a grid");
    EXPECT_EQ(page.scenes(0).mesh(), mesh_);
    EXPECT_EQ(page.scenes(0).revision(), 0u);
  }
  EXPECT_EQ(list("kind=other").scenes_size(), 0);
  EXPECT_EQ(Get().revision(), 1u);
  EXPECT_FALSE(list("").scenes(0).asleep());
  EXPECT_EQ(list("").scenes(0).revision(), 1u);
}

TEST_F(RestartTest, ListsShowWhatAnOlderServerKept) {
  ASSERT_OK(Create(SceneRequest()));
  server_.reset();
  {
    ASSERT_OK_AND_ASSIGN(const auto store, OpenSqliteStore({.folder = folder_.Path("data")}));
    ASSERT_OK_AND_ASSIGN(const std::string scene, store->ReadSceneHeader(kScene));
    ASSERT_OK(store->DeleteScene(kScene));
    ASSERT_OK(store->CreateScene(kScene, WithoutListing<store::SceneHeader>(scene)));
    ASSERT_OK_AND_ASSIGN(const std::string mesh, store->ReadMeshHeader(mesh_));
    ASSERT_OK_AND_ASSIGN(const std::string bytes, store->ReadMesh(mesh_));
    ASSERT_OK(store->DeleteMesh(mesh_));
    ASSERT_OK(store->PutMesh(mesh_, WithoutListing<store::MeshHeader>(mesh), bytes));
  }
  Options options;
  options.data_dir = folder_.Path("data");
  ServerTest::StartServer(options);
  EXPECT_EQ(MeshCount(), 1);
  EXPECT_EQ(SceneCount(), 1);
}

TEST_F(RestartTest, ADamagedMeshCanBeDeleted) {
  const std::string cube = Upload(CubeObj());
  server_.reset();
  std::ofstream(MeshFile(cube), std::ios::app) << "more";
  Restart();
  v1::GetMeshRequest get;
  get.set_mesh(cube);
  EXPECT_THAT(Call(&Meshes::GetMesh, get), StatusIs(absl::StatusCode::kDataLoss, HasSubstr(cube)));
  EXPECT_OK(DeleteMesh(cube));
  EXPECT_THAT(Call(&Meshes::GetMesh, get), StatusIs(absl::StatusCode::kNotFound));
}

TEST_F(RestartTest, AMeshOfASleepingSceneIsInUse) {
  ASSERT_OK(Create(SceneRequest()));
  Restart();
  ExpectRefused(DeleteMesh(mesh_), absl::StatusCode::kFailedPrecondition, "MESH_IN_USE");
  EXPECT_OK(DeleteMesh(mesh_, true));
  EXPECT_EQ(SceneCount(), 0);
  Restart();
  EXPECT_EQ(SceneCount(), 0);
}

TEST_F(RestartTest, AMeshWithAFlippedBitIsNamedAndOtherScenesGoOn) {
  const std::string cube = Upload(CubeObj());
  ASSERT_OK(Create(SceneRequest()));
  v1::CreateSceneRequest other = SceneRequest("scene-two");
  other.set_mesh(cube);
  ASSERT_OK(Create(other));
  server_.reset();
  {
    std::fstream file(MeshFile(cube), std::ios::in | std::ios::out | std::ios::binary);
    ASSERT_TRUE(file.good());
    const char first = static_cast<char>(file.peek());
    file.seekp(0);
    file.put(static_cast<char>(first ^ 1));
  }

  Restart();
  EXPECT_OK(Apply(Move("ann", 1, 5, 0.1)));
  const absl::Status lost = Call(&Scenes::GetScene, For<v1::GetSceneRequest>("scene-two"));
  EXPECT_THAT(lost, StatusIs(absl::StatusCode::kDataLoss, HasSubstr(cube)));
  EXPECT_OK(DeleteScene("scene-two"));
}

TEST_F(RestartTest, ASecondServerOnTheFolderIsRefusedInOneSentence) {
  Options options;
  options.data_dir = folder_.Path("data");
  options.backend = "cpu";
  options.log_level = "off";
  const auto second = InProcessServer::Start(options);
  EXPECT_THAT(second.status(),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr(folder_.Path("data"))));
  EXPECT_OK(Create(SceneRequest()));
}

TEST_F(RestartTest, AFolderThatCannotBeMadeIsRefusedInOneSentence) {
  Options options;
  options.data_dir = folder_.Write("file", "not a folder") + "/data";
  options.backend = "cpu";
  options.log_level = "off";
  EXPECT_THAT(InProcessServer::Start(options).status(),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("/file/data")));
}

}  // namespace
}  // namespace latticed::testing
