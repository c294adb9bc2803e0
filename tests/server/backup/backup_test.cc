// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a backup has and what a restore makes: while scenes are edited, of scenes asleep, for other callers, before a kill.
#include <signal.h>

#include <atomic>
#include <thread>

#include "server/store/memory_store.h"
#include "server/store/records/scene_log.pb.h"
#include "tests/server/backup/backup_fixture.h"
#include "tests/server/daemon/daemon_process.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

class BackupTest : public BackupFixture {
 protected:
  void SetUp() override { Start("first"); }
  // A server on a folder of its own.
  void Start(const std::string& folder) {
    server_.reset();
    Options options;
    options.data_dir = folder_.Path(folder);
    ServerTest::StartServer(options);
  }
  void MakeScenes(int count) {
    mesh_ = Upload(kGridObj);
    for (int n = 0; n < count; ++n) ASSERT_OK(Create(SceneRequest(fmt::format("scene-{:02}", n))));
  }

  TemporaryFolder folder_;
};

TEST_F(BackupTest, WhileItIsEditedASceneIsAtOneRevision) {
  mesh_ = Upload(kGridObj);
  ASSERT_OK(Create(SceneRequest()));
  const v1::Lattice initial = Lattice().lattice();
  std::atomic<uint64_t> acknowledged = 0;
  std::atomic<bool> stop = false;
  std::thread editor([&] {
    for (uint64_t n = 1; !stop; ++n) {
      v1::EditBatch batch = Move("ann", n, 0, 0);
      auto& set = *batch.mutable_edits(0)->mutable_set_control_points();
      for (uint32_t point = 0; point < 8; ++point) set.add_indices(point);
      for (int xyz = 0; xyz < 24; ++xyz) set.add_positions(static_cast<double>(n));
      if (Apply(batch).ok()) acknowledged = n;
    }
  });
  std::vector<BackupParts> backups;
  std::vector<std::pair<uint64_t, uint64_t>> bounds;
  for (int n = 0; n < 10; ++n) {
    while (acknowledged < static_cast<uint64_t>(10 * n)) std::this_thread::yield();
    const uint64_t before = acknowledged;
    auto parts = Backup();
    EXPECT_OK(parts);
    if (parts.ok()) backups.push_back(*std::move(parts));
    bounds.emplace_back(before, acknowledged + 1);
  }
  stop = true;
  editor.join();

  ASSERT_EQ(backups.size(), 10u);
  for (size_t n = 0; n < backups.size(); ++n) {
    Start(fmt::format("copy {}", n));
    ASSERT_OK(Restore(backups[n]));
    const v1::LatticeState state = Lattice();
    EXPECT_GE(state.revision(), bounds[n].first);
    EXPECT_LE(state.revision(), bounds[n].second);
    v1::Lattice expected = initial;
    for (int xyz = 0; state.revision() > 0 && xyz < 24; ++xyz) {
      expected.set_control_points(xyz, static_cast<double>(state.revision()));
    }
    EXPECT_EQ(state.lattice().SerializeAsString(), expected.SerializeAsString());
  }
}

TEST_F(BackupTest, HoldsWeights) {
  mesh_ = Upload(kGridObj);
  v1::CreateSceneRequest request = SceneRequest();
  const std::vector<float> weights = {0, 0.25f, 0.5f, 1, 1, 0.75f, 0, 0, 1};
  request.mutable_weights()->set_values(reinterpret_cast<const char*>(weights.data()),
                                        weights.size() * sizeof(float));
  ASSERT_OK(Create(request));
  ASSERT_OK(Apply(Move("ann", 1, 5, 0.5)));
  const auto ply = Export(For<v1::ExportRequest>());
  ASSERT_OK(ply);

  ASSERT_OK_AND_ASSIGN(const BackupParts parts, Backup());
  Start("second");
  ASSERT_OK(Restore(parts));

  EXPECT_TRUE(Get().weighted());
  const auto restored = Export(For<v1::ExportRequest>());
  ASSERT_OK(restored);
  EXPECT_EQ(*restored, *ply);
}

TEST_F(BackupTest, WakesNothingOnEitherSide) {
  MakeScenes(3);
  Start("first");

  ASSERT_OK_AND_ASSIGN(const BackupParts parts, Backup());
  EXPECT_EQ(Metric("latticed_scenes"), 0);
  Start("second");
  ASSERT_OK(Restore(parts));

  EXPECT_EQ(Metric("latticed_scenes"), 0);
  EXPECT_EQ(Metric("latticed_scenes_asleep"), 3);
  EXPECT_EQ(Get("scene-01").revision(), 0u);
}

TEST_F(BackupTest, NamedScenesComeWithTheirMeshesOnly) {
  MakeScenes(3);
  Upload(CubeObj());

  ASSERT_OK_AND_ASSIGN(const BackupParts parts, Backup({"scene-02", "scene-00"}));

  const auto items = ItemsOf(parts);
  ASSERT_EQ(items.size(), 3u);
  EXPECT_EQ(items[0].item.mesh(), mesh_);
  EXPECT_EQ(items[1].item.scene(), "scene-00");
  EXPECT_EQ(items[2].item.scene(), "scene-02");
  ExpectRefused(Backup({"scene-00", "no-such-scene"}).status(), absl::StatusCode::kNotFound,
                "NOT_FOUND");
  ExpectRefused(Backup({"scene-00", "scene-00"}).status(), absl::StatusCode::kInvalidArgument,
                "INVALID_FIELD", "scenes");
}

TEST_F(BackupTest, ASceneThatIsThereStays) {
  MakeScenes(3);
  ASSERT_OK_AND_ASSIGN(const BackupParts parts, Backup());
  ASSERT_OK(DeleteScene("scene-01"));
  v1::EditBatch edit = Move("ann", 1, 5, 0.1);
  edit.set_scene("scene-00");
  ASSERT_OK(Apply(edit));

  const absl::Status refused = Restore(parts).status();
  ExpectRefused(refused, absl::StatusCode::kAlreadyExists, "ALREADY_EXISTS");
  EXPECT_THAT(refused.message(), HasSubstr("scene-00"));
  EXPECT_EQ(SceneCount(), 2);
  ASSERT_OK_AND_ASSIGN(const auto done, Restore(parts, /*skip_existing=*/true));

  EXPECT_EQ(done.present_meshes(), 1u);
  EXPECT_EQ(done.scenes(), 1u);
  EXPECT_EQ(done.skipped_scenes(), 2u);
  EXPECT_EQ(Get("scene-00").revision(), 1u);
  EXPECT_EQ(SceneCount(), 3);
}

TEST_F(BackupTest, OwnersAreKeptForAdminsOnly) {
  mesh_ = Upload(kGridObj);
  ASSERT_OK(Create(SceneRequest()));
  ASSERT_OK_AND_ASSIGN(const BackupParts parts, Backup());
  auto items = ItemsOf(parts);
  for (BackedUp& of : items) {
    std::string header;
    if (of.item.has_mesh()) {
      store::MeshHeader mesh;
      ASSERT_TRUE(mesh.ParseFromString(of.header()));
      mesh.set_owner("olga");
      header = mesh.SerializeAsString();
    } else {
      store::SceneHeader scene;
      ASSERT_TRUE(scene.ParseFromString(of.header()));
      scene.set_owner("olga");
      header = scene.SerializeAsString();
    }
    of.data = header + of.content();
    of.item.set_header_bytes(header.size());
    Fit(of);
  }
  const auto tokens = folder_.Write(
      "tokens",
      fmt::format("{} admin ada\n{} edit ed\n", Sha256Hex("token-a"), Sha256Hex("token-e")));
  for (const auto& [token, owner] : {std::pair("token-a", "olga"), std::pair("token-e", "ed")}) {
    Options options;
    options.token_file = tokens;
    options.data_dir = folder_.Path(token);
    ServerTest::StartServer(options);
    const Metadata bearer{{"authorization", std::string("Bearer ") + token}};
    ASSERT_OK(Restore(PartsOf(items), false, bearer));
    v1::ListScenesResponse asleep;
    ASSERT_OK(Call(&Scenes::ListScenes, {}, &asleep, bearer));
    EXPECT_EQ(asleep.scenes(0).owner(), owner);
    v1::Scene scene;
    ASSERT_OK(Call(&Scenes::GetScene, For<v1::GetSceneRequest>(), &scene, bearer));
    EXPECT_EQ(scene.owner(), owner);
    v1::Mesh mesh;
    v1::GetMeshRequest get;
    get.set_mesh(mesh_);
    ASSERT_OK(Call(&Meshes::GetMesh, get, &mesh, bearer));
    EXPECT_EQ(mesh.owner(), owner);
  }
}

// A tenant's backup has neither what others own nor the secret of the scene's tokens, and belongs to whoever restores it.
TEST_F(BackupTest, IsOfOneTenantAndRestoredForAnother) {
  server_.reset();
  const auto store = std::make_shared<MemoryStore>();
  Options options;
  options.token_file =
      folder_.Write("tokens", fmt::format("{} edit ann red\n{} edit bob blue\n",
                                          Sha256Hex("token-a"), Sha256Hex("token-b")));
  StartEmpty(store, options);
  const Metadata ann{{"authorization", "Bearer token-a"}}, bob{{"authorization", "Bearer token-b"}};
  v1::Mesh mesh;
  ASSERT_OK(ServerTest::Upload(ObjHeader(kGridObj), kGridObj, &mesh, ann));
  mesh_ = mesh.id();
  ASSERT_OK(Call(&Scenes::CreateScene, SceneRequest(), nullptr, ann));
  ASSERT_OK(Call(&Scenes::ApplyEdits, Move("ann", 1, 5, 0.1), nullptr, ann));

  ASSERT_OK_AND_ASSIGN(const BackupParts of_bob, Backup({}, bob));
  EXPECT_TRUE(ItemsOf(of_bob).empty());
  ExpectRefused(Backup({kScene}, bob).status(), absl::StatusCode::kNotFound, "NOT_FOUND");
  ExpectRefused(Backup({std::string("red/") + kScene}, bob).status(), absl::StatusCode::kNotFound,
                "NOT_FOUND");
  ASSERT_OK_AND_ASSIGN(const BackupParts of_ann, Backup({}, ann));
  const auto items = ItemsOf(of_ann);
  ASSERT_EQ(items.size(), 2u);
  EXPECT_EQ(items[0].item.mesh(), mesh_);
  EXPECT_EQ(items[1].item.scene(), kScene);
  store::SceneHeader copied;
  ASSERT_TRUE(copied.ParseFromString(items[1].header()));
  EXPECT_EQ(copied.token_key(), "");
  EXPECT_EQ(copied.tenant(), "");
  ASSERT_OK(Restore(of_ann, false, bob));

  v1::Scene scene;
  ASSERT_OK(Call(&Scenes::GetScene, For<v1::GetSceneRequest>(), &scene, bob));
  EXPECT_EQ(scene.revision(), 1u);
  EXPECT_EQ(scene.owner(), "bob");
  store::SceneHeader red, blue;
  ASSERT_OK_AND_ASSIGN(const SceneLog of_red, store->CopyScene(std::string("red/") + kScene));
  ASSERT_OK_AND_ASSIGN(const SceneLog of_blue, store->CopyScene(std::string("blue/") + kScene));
  ASSERT_TRUE(red.ParseFromString(of_red.header));
  ASSERT_TRUE(blue.ParseFromString(of_blue.header));
  EXPECT_NE(blue.token_key(), "");
  EXPECT_NE(blue.token_key(), red.token_key());
  server_.reset();  // before the store
}

TEST_F(BackupTest, ARestoredSceneSurvivesAKill) {
  mesh_ = Upload(kGridObj);
  ASSERT_OK(Create(SceneRequest()));
  ASSERT_OK(Apply(Move("ann", 1, 5, 0.1)));
  const v1::LatticeState lattice = Lattice();
  ASSERT_OK_AND_ASSIGN(const BackupParts parts, Backup());
  const std::vector<std::string> arguments = {"--listen",   "127.0.0.1:0",         "--backend",
                                              "cpu",        "--threads",           "1",
                                              "--data-dir", folder_.Path("killed")};
  const auto restore_at = [&](const std::string& address) {
    grpc::ClientContext context;
    const auto channel = grpc::CreateChannel(address, grpc::InsecureChannelCredentials());
    const auto stub = v1::BackupService::NewStub(channel);
    v1::RestoreResponse response;
    const auto writer = stub->Restore(&context, &response);
    v1::RestoreRequest request;
    request.mutable_options();
    writer->Write(request);
    for (const v1::BackupPart& part : parts) {
      *request.mutable_part() = part;
      writer->Write(request);
    }
    writer->WritesDone();
    return client::FromGrpc(writer->Finish());
  };
  Daemon first(arguments);
  ASSERT_OK(restore_at(first.Address()));
  first.Signal(SIGKILL);
  first.Wait();

  Daemon second(arguments);
  Reach(grpc::CreateChannel(second.Address(), grpc::InsecureChannelCredentials()));

  EXPECT_EQ(Lattice().lattice().SerializeAsString(), lattice.lattice().SerializeAsString());
  EXPECT_EQ(Lattice().revision(), 1u);
  EXPECT_OK(Apply(Move("ann", 2, 5, 0.2)));
  EXPECT_OK(Apply(UndoMine("ann", 3)));
  second.Signal(SIGKILL);
  second.Wait();
}

TEST_F(BackupTest, ADamagedMeshIsNamedAndTheRestIsCopied) {
  MakeScenes(1);
  const std::string cube = Upload(CubeObj());
  Start("first");
  folder_.Write("first/meshes/" + mesh_, "v 0 0 0\n");

  ASSERT_OK_AND_ASSIGN(const BackupParts parts, Backup());
  Start("second");
  ASSERT_OK_AND_ASSIGN(const auto done, Restore(parts));

  int damaged = 0;
  for (const BackedUp& of : ItemsOf(parts)) {
    if (of.item.mesh() == cube) continue;
    ++damaged;
    EXPECT_THAT(of.item.damage(), HasSubstr(mesh_));
    EXPECT_EQ(of.data, "");
  }
  EXPECT_EQ(damaged, 2);
  EXPECT_EQ(done.meshes(), 1u);
  EXPECT_EQ(done.damaged(), 2u);
}

}  // namespace
}  // namespace latticed::testing
