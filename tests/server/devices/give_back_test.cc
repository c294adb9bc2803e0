// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// When device memory is short, scenes that nobody uses are evicted, the least recently used first. They
// get their memory again when they are used.
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/devices/device_fixture.h"
#include "tests/server/engine/engine_support.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

// The default view at two segments: 6 points of 8 bytes (positions of 12 bits, normals of 8 bits).
constexpr int kWatchedSegments = 2;
constexpr uint64_t kSceneBytesPerPatch = ScriptedBackend::kPlanBytes + uint64_t{6} * 8;

class GiveBackTest : public DeviceFixture {
 protected:
  void SetUp() override {
    StartOnDevice(uint64_t{1} << 30, PlaneObj(20));
    ASSERT_OK(Create(SceneRequest()));
    scene_bytes_ = Get().patches() * kSceneBytesPerPatch;
  }

  // Starts on a device with memory for `scenes` scenes of one view each.
  void Restart(double scenes) {
    StartOnDevice(static_cast<uint64_t>(scenes * static_cast<double>(scene_bytes_)), PlaneObj(20));
  }
  void CreateAndView(const std::string& id) {
    ASSERT_OK(OnceIdle([&] { return Create(SceneRequest(id)); }));
    ASSERT_OK(View(id));
  }
  absl::Status View(const std::string& id, Chunks* chunks = nullptr) {
    return OnceIdle([&] {
      EventLog log;
      const absl::Status status = Update(kWatchedSegments, id, &log);
      if (chunks != nullptr) *chunks = log.chunks;
      return status;
    });
  }
  // Waits until ended streams release their scenes: a watched scene is not evicted.
  void AwaitNoWatchers() {
    EXPECT_TRUE(Becomes(2000, [this] { return Metric("latticed_watchers") == 0; }));
  }
  v1::WatchRequest WatchOf(const std::string& scene) {
    auto watch = For<v1::WatchRequest>(scene);
    watch.set_editor_id("alice");
    watch.set_max_unacked_updates(0);
    watch.mutable_view()->set_segments(kWatchedSegments);
    return watch;
  }

  uint64_t scene_bytes_ = 0;
};

TEST_F(GiveBackTest, TheLeastRecentlyUsedSceneGoesFirst) {
  Restart(3.2);
  for (const char* id : {"scene-no-a", "scene-no-b", "scene-no-c"}) CreateAndView(id);
  ASSERT_OK(View("scene-no-a"));
  AwaitNoWatchers();

  CreateAndView("scene-no-d");

  EXPECT_TRUE(OnDevice("scene-no-a"));
  EXPECT_FALSE(OnDevice("scene-no-b"));
  EXPECT_TRUE(OnDevice("scene-no-c"));
  EXPECT_TRUE(OnDevice("scene-no-d"));
  EXPECT_FALSE(Get("scene-no-b").bytes().contains("device_vertices"));
  EXPECT_GT(Get("scene-no-b").bytes().at("plan"), 0u) << "the plan stays on the host";
  EXPECT_EQ(Info().backends(0).give_backs(), 1u);
  AwaitNoWatchers();
  CreateAndView("scene-no-e");
  EXPECT_FALSE(OnDevice("scene-no-c"));
  EXPECT_TRUE(OnDevice("scene-no-a"));
}

TEST_F(GiveBackTest, ItComesBackAsItWasWithTheEditsMadeMeanwhile) {
  Chunks before, after, edited, expected;
  ASSERT_OK(View("scene-one", &before));
  ASSERT_OK(Apply(Move("alice", 1, 21, 0.2)));
  ASSERT_OK(View("scene-one", &expected));
  ASSERT_FALSE(before.empty());
  ASSERT_NE(before, expected);

  Restart(1.2);
  CreateAndView("scene-one");
  CreateAndView("scene-two");
  EXPECT_FALSE(OnDevice("scene-one"));
  ASSERT_OK(View("scene-one", &after));
  EXPECT_TRUE(OnDevice("scene-one"));
  EXPECT_FALSE(OnDevice("scene-two"));
  EXPECT_EQ(before, after);
  ASSERT_OK(View("scene-two"));
  ASSERT_OK(Apply(Move("alice", 1, 21, 0.2)));
  EXPECT_FALSE(OnDevice("scene-one")) << "an edit that nobody watches needs no device";
  ASSERT_OK(View("scene-one", &edited));
  EXPECT_EQ(edited, expected);
}

TEST_F(GiveBackTest, AnExportComesBackAsWell) {
  Restart(1.2);
  ASSERT_OK(Create(SceneRequest("scene-one")));
  CreateAndView("scene-two");
  const int prepared = backend_->prepared();

  auto request = For<v1::ExportRequest>();
  request.set_format(v1::EXPORT_FORMAT_CONTROL_NETS);
  EXPECT_OK(OnceIdle([&] { return Export(request).status(); }));

  EXPECT_EQ(backend_->prepared(), prepared + 1);
}

TEST_F(GiveBackTest, AWatchedSceneNeverGivesAndTheRefusalSaysWhatIsFree) {
  Restart(2.2);
  CreateAndView("scene-no-a");
  CreateAndView("scene-no-b");
  DeformClient on_a(*scenes_, WatchOf("scene-no-a"));
  on_a.ReadUntilRevision(0);

  CreateAndView("scene-no-c");
  EXPECT_TRUE(OnDevice("scene-no-a")) << "used before b, but watched";
  EXPECT_FALSE(OnDevice("scene-no-b"));
  ASSERT_OK(View("scene-no-b"));
  DeformClient on_b(*scenes_, WatchOf("scene-no-b"));
  on_b.ReadUntilRevision(0);
  EXPECT_FALSE(OnDevice("scene-no-c"));
  const absl::Status refused = Create(SceneRequest("scene-no-d"));

  ExpectRefused(refused, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
  EXPECT_EQ(error::DetailsOf(refused).asked_bytes,
            Get("scene-no-a").patches() * ScriptedBackend::kPlanBytes);
  EXPECT_EQ(error::DetailsOf(refused).free_bytes, Info().backends(0).devices(0).free_bytes());
  v1::EditBatch move = Move("alice", 1, 0, 0.1);
  move.set_scene("scene-no-a");
  ASSERT_TRUE(on_a.Send(move));
  on_a.ReadUntilRevision(1);
}

TEST_F(GiveBackTest, NobodyGivesForOneThatCannotBeServed) {
  Restart(2.2);
  CreateAndView("scene-no-a");
  CreateAndView("scene-no-b");

  const absl::Status refused = Update(32, "scene-no-b");

  ExpectRefused(refused, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
  EXPECT_GT(error::DetailsOf(refused).asked_bytes, error::DetailsOf(refused).free_bytes);
  EXPECT_TRUE(OnDevice("scene-no-a"));
  EXPECT_TRUE(OnDevice("scene-no-b"));
  EXPECT_EQ(Info().backends(0).give_backs(), 0u);
}

TEST_F(GiveBackTest, ManyScenesTakeTurnsOnASmallDevice) {
  Restart(4.2);
  std::vector<std::string> ids;
  for (int i = 0; i < 6; ++i) ids.push_back(fmt::format("scene-{}-of-6", i));
  for (const std::string& id : ids) CreateAndView(id);
  Chunks expected;
  ASSERT_OK(View(ids[0], &expected));
  std::vector<std::thread> threads;
  for (size_t t = 0; t < 2; ++t) {
    threads.emplace_back([&, t] {
      for (size_t i = 0; i < 30; ++i) {
        Chunks bytes;
        EXPECT_OK(View(ids[(5 * i + 3 * t) % 6], &bytes));
        EXPECT_EQ(bytes, expected);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_GT(Info().backends(0).give_backs(), 6u);
}

TEST(GiveBackHeldTest, AHeldSceneKeepsWhatItHas) {
  ScriptedBackend backend(uint64_t{1} << 30);
  SceneRegistry registry(&backend, 1);
  const auto scene = registry.Create(MakeSceneConfig("scene-one"));
  ASSERT_OK(scene);
  const uint64_t bytes = backend.used_bytes();

  auto held = (*scene)->Hold();
  EXPECT_EQ((*scene)->EvictableBytes(), 0u);
  EXPECT_FALSE((*scene)->Evict());
  EXPECT_EQ(backend.used_bytes(), bytes);
  held = nullptr;

  EXPECT_EQ((*scene)->EvictableBytes(), bytes);
  EXPECT_TRUE((*scene)->Evict());
  EXPECT_EQ(backend.used_bytes(), 0u);
  EXPECT_EQ((*scene)->EvictableBytes(), 0u);
}

}  // namespace
}  // namespace latticed::testing
