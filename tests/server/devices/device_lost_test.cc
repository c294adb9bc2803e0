// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The device is lost while the server runs. Health turns to NOT_SERVING, calls that need the device
// are refused with DEVICE_LOST, other calls are answered, and the process goes on.
#include <utility>
#include <vector>

#include "server/engine/render/device_health.h"
#include "tests/server/devices/device_fixture.h"
#include "tests/server/support/raw_call.h"

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
    StartOnDevice(uint64_t{1} << 30, kGridObj);
    ASSERT_OK(Create(SceneRequest()));
  }

  static void ExpectLost(const absl::Status& status) {
    ExpectRefused(status, absl::StatusCode::kUnavailable, "DEVICE_LOST");
    EXPECT_THAT(status.message(), HasSubstr("illegal memory access"));
    EXPECT_THAT(status.message(), HasSubstr("call another"));
    EXPECT_GT(error::DetailsOf(status).retry_after_ms, 0u);
  }
};

TEST_F(DeviceLostTest, HealthTurnsForEveryService) {
  for (const char* service : kHealthNames) ASSERT_EQ(Health(server_->channel(), service), "1");
  EXPECT_EQ(Info().backends(0).lost(), "");

  backend_->script().LoseDevice();
  ExpectLost(Update(2));

  for (const char* service : kHealthNames) {
    EXPECT_EQ(Health(server_->channel(), service), "2") << service;
  }
  EXPECT_THAT(Info().backends(0).lost(), HasSubstr("illegal memory access"));
}

TEST_F(DeviceLostTest, WhatNeedsTheDeviceSaysSoAndTheDeviceIsAskedNoMore) {
  backend_->script().LoseDevice();

  ExpectLost(Export(For<v1::ExportRequest>()).status());
  ExpectLost(Create(SceneRequest("scene-two")));
  ExpectLost(Apply(Knot("alice", 1)));
  ExpectLost(Update(3));
  ExpectLost(ReadAll(&Scenes::Watch, For<v1::WatchRequest>()));

  EXPECT_EQ(backend_->script().calls_after_loss(), 1);
}

TEST_F(DeviceLostTest, WhatDoesNotNeedItIsAnswered) {
  backend_->script().LoseDevice();
  ExpectLost(Update(2));

  EXPECT_OK(Apply(Move("alice", 1, 0, 0.1)));
  EXPECT_EQ(Lattice().revision(), 1u);
  EXPECT_EQ(Get().revision(), 1u);
  EXPECT_FALSE(Upload(PlaneObj(3)).empty());
  EXPECT_OK(DeleteScene());
}

TEST_F(DeviceLostTest, AnOpenStreamEndsWithItsNextUpdate) {
  auto watch = For<v1::WatchRequest>();
  watch.set_editor_id("alice");
  DeformClient client(*scenes_, watch);
  client.ReadUntilRevision(0);

  backend_->script().LoseDevice();
  ASSERT_TRUE(client.Send(Move("alice", 1, 0, 0.1)));

  ExpectLost(client.Finish());
  EXPECT_EQ(Health(server_->channel(), ""), "2");
}

}  // namespace
}  // namespace latticed::testing
