// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Two servers over one store: each tells who has a scene, and a scene moves when its server drains.
#include <memory>
#include <thread>

#include "core/cpu/cpu_backend.h"
#include "server/store/shared_memory_store.h"
#include "tests/server/durability/scene_owner.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

constexpr uint64_t kLittleMemory = uint64_t{12} << 20;  // of the server "one"
// Of a scene whose server drains: half of what streams may take to end.
constexpr absl::Duration kMostDrainPause = absl::Seconds(20);

class MovesTest : public StreamTest {
 protected:
  // The stubs of the fixture reach the server "one".
  void SetUp() override {
    StartServerOn(MakeCpuBackend({.threads = 1}), OptionsOf("one"),
                  std::make_shared<SharedMemoryStore>(memory_, "one"));
    std::vector<std::unique_ptr<Backend>> backends;
    backends.push_back(MakeCpuBackend({.threads = 1}));
    ASSERT_OK_AND_ASSIGN(
        two_, InProcessServer::Start(OptionsOf("two"), std::move(backends),
                                     std::make_shared<SharedMemoryStore>(memory_, "two")));
    at_two_ = v1::SceneService::NewStub(two_->channel());
  }
  static Options OptionsOf(const std::string& name) {
    Options options;
    if (name == "one") options.memory_bytes = kLittleMemory;
    options.heartbeat_interval = kHeartbeat;
    options.advertise = name;
    options.log_level = "off";
    return options;
  }

  const std::shared_ptr<SharedMemory> memory_ = std::make_shared<SharedMemory>();
  std::unique_ptr<InProcessServer> two_;
  std::unique_ptr<v1::SceneService::Stub> at_two_;
};

TEST_F(MovesTest, EveryReplyNamesTheOwner) {
  CreateScene();
  v1::Scene scene;
  auto [owner, status] = SceneOwner(*scenes_, &scene);
  EXPECT_OK(status);
  EXPECT_EQ(owner, "one");

  std::tie(owner, status) = SceneOwner(*at_two_, &scene);
  ExpectRefusal(status,
                {absl::StatusCode::kUnavailable, "SCENE_MOVED", "", "on another server, one"});
  EXPECT_EQ(owner, "one");

  // A stream through a proxy has the name in its headers, and its goaway says what to do.
  DeformClient client(*at_two_, Watch(), {{"x-forwarded-for", "192.0.2.7"}});
  client.ReadUntil([&] { return !client.log.goaways.empty(); });
  EXPECT_EQ(client.log.goaways[0].reason(), v1::GOAWAY_REASON_MOVED);
  client.HalfClose();
  ExpectRefused(client.Finish(), absl::StatusCode::kUnavailable, "SCENE_MOVED");
  EXPECT_EQ(client.InitialMetadata("latticed-owner"), "one");
}

TEST_F(MovesTest, ASceneMovesAsSoonAsItsServerDrains) {
  CreateScene();
  DeformClient client(*scenes_, Watch());
  client.ReadUpdates(1);
  ASSERT_TRUE(client.Send(Move(1, 62, 0.1)));
  client.ReadUntil([&] { return client.log.results.size() == 1; });
  const v1::LatticeState before = Lattice();

  std::thread drain([this] { server_->Drain(); });
  const absl::Time drained = absl::Now();
  v1::Scene scene;
  auto [owner, status] = SceneOwner(*at_two_, &scene);
  while (!status.ok() && absl::Now() - drained < kHeartbeat) {
    EXPECT_EQ(Reason(status), "SCENE_MOVED");
    absl::SleepFor(absl::Milliseconds(5));
    std::tie(owner, status) = SceneOwner(*at_two_, &scene);
  }
  const absl::Duration pause = absl::Now() - drained;
  (void)client.Finish();
  drain.join();

  ASSERT_OK(status);
  EXPECT_LT(pause, kMostDrainPause);
  EXPECT_EQ(owner, "two");
  EXPECT_EQ(scene.revision(), 1u);
  Reach(two_->channel());
  EXPECT_EQ(Lattice().SerializeAsString(), before.SerializeAsString());
  v1::EditResult again;
  ASSERT_OK(Apply(Move(1, 62, 0.1), &again));
  EXPECT_EQ(again.revision(), 1u) << "it counts once";
}

TEST_F(MovesTest, AFullServerSendsANewSceneToTheFreest) {
  mesh_ = Upload(WavyGridObj(96));
  v1::CreateSceneRequest request = SceneRequest();
  SetAxes(*request.add_lattices()->mutable_fit()->mutable_size(), 16, 16, 16);
  // Servers tell each other once a second what they have free.
  absl::Status status = Create(request);
  for (int i = 0; i < 1'200 && Reason(status) == "OUT_OF_MEMORY"; ++i) {
    absl::SleepFor(absl::Milliseconds(50));
    status = Create(request);
  }
  ExpectRefusal(status,
                {absl::StatusCode::kUnavailable, "SCENE_MOVED", "", "on another server, two"});
  Reach(two_->channel());
  EXPECT_OK(Create(request));

  // Nobody has so much.
  two_.reset();
  Reach(server_->channel());
  request.set_scene_id("scene-two");
  ExpectRefused(Create(request), absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
}

TEST_F(MovesTest, AFullServerSendsAStoredSceneToTheFreest) {
  std::vector<std::unique_ptr<Backend>> backends;
  backends.push_back(MakeCpuBackend({.threads = 1}));
  ASSERT_OK_AND_ASSIGN(
      const auto three,
      InProcessServer::Start(OptionsOf("three"), std::move(backends),
                             std::make_shared<SharedMemoryStore>(memory_, "three")));
  Reach(two_->channel());
  mesh_ = Upload(WavyGridObj(96));
  v1::CreateSceneRequest request = SceneRequest();
  SetAxes(*request.add_lattices()->mutable_fit()->mutable_size(), 16, 16, 16);
  ASSERT_OK(Create(request));
  two_->Drain();
  two_.reset();

  // Servers tell each other once a second what they have free.
  Reach(server_->channel());
  v1::Scene scene;
  auto [owner, status] = SceneOwner(*scenes_, &scene);
  for (int i = 0; i < 1'200 && Reason(status) != "SCENE_MOVED"; ++i) {
    EXPECT_EQ(Reason(status), "OUT_OF_MEMORY");
    absl::SleepFor(absl::Milliseconds(50));
    std::tie(owner, status) = SceneOwner(*scenes_, &scene);
  }

  ExpectRefusal(status,
                {absl::StatusCode::kUnavailable, "SCENE_MOVED", "", "on another server, three"});
  EXPECT_EQ(owner, "three");
  Reach(three->channel());
  EXPECT_OK(SceneOwner(*scenes_, &scene).second);
}

TEST_F(MovesTest, AMeshThatAnotherServerDeletedIsUploadedAnew) {
  const std::string mesh = Upload(kGridObj);
  v1::GetMeshRequest get;
  get.set_mesh(mesh);
  Reach(two_->channel());
  ASSERT_OK(Call(&Meshes::GetMesh, get)) << "it is in the memory of both servers now";
  v1::DeleteMeshRequest deletion;
  deletion.set_mesh(mesh);
  ASSERT_OK(Call(&Meshes::DeleteMesh, deletion));

  Reach(server_->channel());
  ExpectRefused(Call(&Meshes::GetMesh, get), absl::StatusCode::kNotFound, "NOT_FOUND");
  EXPECT_EQ(Upload(kGridObj), mesh);

  Reach(two_->channel());
  EXPECT_OK(Call(&Meshes::GetMesh, get));
  EXPECT_EQ(MeshCount(), 1);
}

TEST_F(MovesTest, TheStreamsOfADrainingServerAreToldToGoOnAtOnce) {
  CreateScene();
  DeformClient client(*scenes_, Watch(), {{"x-forwarded-for", "192.0.2.7"}});
  client.ReadUpdates(1);
  std::thread drain([this] { server_->Drain(); });
  client.ReadUntil([&] { return !client.log.goaways.empty(); });
  client.HalfClose();
  (void)client.Finish();
  drain.join();

  EXPECT_EQ(client.log.goaways[0].reason(), v1::GOAWAY_REASON_MOVED);
  EXPECT_FALSE(client.log.goaways[0].has_retry_after());
}

}  // namespace
}  // namespace latticed::testing
