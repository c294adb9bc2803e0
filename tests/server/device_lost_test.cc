// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The device is lost while the server runs: balancers are told, calls that need it say so, the rest
// is answered, and nothing ends the process.
#include <thread>
#include <utility>
#include <vector>

#include "server/engine/render/device_health.h"
#include "tests/server/device_fixture.h"
#include "tests/server/health_probe.h"
#include "tests/server/stream_support.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

TEST(DeviceHealthTest, TheFirstLossIsForGoodAndToldOnce) {
  DeviceHealth health;
  std::vector<absl::Status> told;
  health.SetObserver([&told](const absl::Status& why) { told.push_back(why); });

  health.Note(absl::OkStatus());
  health.Note(error::OutOfMemory("the view", 2, 1));
  EXPECT_OK(health.status());
  health.Note(error::Unavailable("DEVICE_LOST", "first words", 0));
  health.Note(error::Unavailable("DEVICE_LOST", "second words", 0));
  health.Note(absl::OkStatus());

  EXPECT_THAT(health.status(), StatusIs(absl::StatusCode::kUnavailable, HasSubstr("first words")));
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0], health.status());
}

TEST(DeviceHealthTest, ALateObserverIsToldAtOnceAndARemovedOneNever) {
  DeviceHealth health;
  int removed = 0, late = 0;
  health.SetObserver([&removed](const absl::Status&) { ++removed; });
  health.SetObserver(nullptr);

  health.Note(error::Unavailable("DEVICE_LOST", "words", 0));
  health.SetObserver([&late](const absl::Status&) { ++late; });

  EXPECT_EQ(removed, 0);
  EXPECT_EQ(late, 1);
}

class DeviceLostTest : public DeviceFixture {
 protected:
  void SetUp() override {
    StartOnDevice(uint64_t{1} << 30);
    mesh_ = Upload(kGridObj);
    ASSERT_OK(Create(SceneRequest()));
  }

  static void ExpectLost(const absl::Status& status) {
    ExpectRefused(status, absl::StatusCode::kUnavailable, "DEVICE_LOST");
    EXPECT_THAT(status.message(), HasSubstr("illegal memory access"));
    EXPECT_THAT(status.message(), HasSubstr("call another"));
    EXPECT_GT(error::DetailsOf(status).retry_after_ms, 0u);
  }
};

TEST_F(DeviceLostTest, HealthTurnsForEveryServiceAndStaysSo) {
  for (const char* service : kHealthNames) ASSERT_EQ(Health(server_->channel(), service), "1");
  EXPECT_EQ(Info().backends(0).lost(), "");

  backend_->Lose();
  ExpectLost(Update(2));

  for (int i = 0; i < 3; ++i) {
    for (const char* service : kHealthNames) {
      EXPECT_EQ(Health(server_->channel(), service), "2") << service;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_THAT(Info().backends(0).lost(), HasSubstr("illegal memory access"));
}

TEST_F(DeviceLostTest, WhatNeedsTheDeviceSaysSoAndTheDeviceIsAskedNoMore) {
  backend_->Lose();

  ExpectLost(Export());
  ExpectLost(Create(SceneRequest("scene-two")));
  ExpectLost(Apply(Knot("alice", 1)));
  ExpectLost(Update(3));
  v1::WatchRequest watch;
  watch.set_scene("scene-one");
  grpc::ClientContext context;
  std::vector<v1::SceneEvent> events;
  ExpectLost(ReadAll(*stub_->Watch(&context, watch), events));

  EXPECT_EQ(backend_->calls_after_loss(), 1);
}

TEST_F(DeviceLostTest, WhatDoesNotNeedItIsAnswered) {
  backend_->Lose();
  ExpectLost(Update(2));

  EXPECT_OK(Apply(Move("alice", 1, 0, 0.1)));
  EXPECT_EQ(Lattice().revision(), 1u);
  v1::GetSceneRequest get;
  get.set_scene("scene-one");
  v1::Scene scene;
  EXPECT_OK(Call(&v1::SceneService::Stub::GetScene, get, &scene));
  EXPECT_FALSE(Upload(PlaneObj(3)).empty());
  v1::DeleteSceneRequest remove;
  remove.set_scene("scene-one");
  v1::DeleteSceneResponse removed;
  EXPECT_OK(Call(&v1::SceneService::Stub::DeleteScene, remove, &removed));
}

TEST_F(DeviceLostTest, AnOpenStreamEndsWithItsNextUpdate) {
  DeformClient client(*stub_);
  v1::WatchRequest watch;
  watch.set_scene("scene-one");
  watch.set_editor_id("alice");
  client.Open(watch);
  client.ReadUntilRevision(0);

  backend_->Lose();
  ASSERT_TRUE(client.Send(Move("alice", 1, 0, 0.1)));

  ExpectLost(client::FromGrpc(client.Finish()));
  EXPECT_EQ(Health(server_->channel(), ""), "2");
}

}  // namespace
}  // namespace latticed::testing
