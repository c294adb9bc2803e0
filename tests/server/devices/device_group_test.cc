// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Several fake devices as one backend, alone and behind a server: where scenes go, what is refused,
// which scenes are evicted, and the loss of one device.
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "core/points/point_evaluator.h"
#include "core/view/device_group.h"
#include "tests/server/devices/device_fixture.h"
#include "tests/server/engine/engine_support.h"
#include "tests/server/support/raw_call.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

constexpr uint64_t kGiB = uint64_t{1} << 30;
constexpr uint64_t kNever = uint64_t{1} << 40;

struct Group {
  std::vector<ScriptedBackend*> devices;
  std::unique_ptr<Backend> backend;
};

// The devices' numbers are 3, 4, …
Group MakeGroup(const std::vector<uint64_t>& bytes, uint64_t span_patches) {
  Group group;
  std::vector<std::unique_ptr<Backend>> devices;
  for (const uint64_t size : bytes) {
    auto device =
        std::make_unique<ScriptedBackend>(size, 3 + static_cast<int>(group.devices.size()));
    group.devices.push_back(device.get());
    devices.push_back(std::move(device));
  }
  group.backend = MakeDeviceGroup(std::move(devices), span_patches);
  return group;
}

std::shared_ptr<const DeformPlan> MakeGridPlan(int cells) {
  const SceneConfig config = MakeSceneConfig("scene", cells);
  auto plan = MakePlan(config.mesh, config.lattices[0].structure);
  EXPECT_OK(plan);
  return *plan;
}

TEST(DeviceGroup, OneDeviceIsReturnedAsItIs) {
  auto device = std::make_unique<ScriptedBackend>(kGiB);
  const Backend* const address = device.get();
  std::vector<std::unique_ptr<Backend>> devices;
  devices.push_back(std::move(device));

  EXPECT_EQ(MakeDeviceGroup(std::move(devices)).get(), address);
}

TEST(DeviceGroup, SmallPlansGoToTheFreest) {
  const Group group = MakeGroup({kGiB, 3 * kGiB, 2 * kGiB}, kNever);
  const auto plan = MakeGridPlan(8);

  const auto first = group.backend->Prepare(plan, Pipeline::kFused);

  ASSERT_OK(first);
  EXPECT_EQ(group.devices[1]->prepared(), 1);
  EXPECT_EQ((*first)->device_use().begin()->first, 4);
  EXPECT_EQ(group.backend->devices().size(), 3u);
  EXPECT_EQ(group.backend->devices()[2].number, 5);
}

TEST(DeviceGroup, PointsGoToTheFreest) {
  const Group group = MakeGroup({kGiB, 3 * kGiB, 2 * kGiB}, kNever);
  CpuArena arena(1);
  const auto sorted = std::make_shared<const SortedPoints>(
      MakeSceneConfig("scene", 2).lattices[0].structure, std::vector<Vec3d>(100),
      std::span<const Vec3d>(), arena);

  ASSERT_OK_AND_ASSIGN(const auto points, group.backend->PreparePoints(sorted));

  EXPECT_EQ(group.devices[1]->used_bytes(), points->device_bytes());
  EXPECT_EQ(points->device_bytes(), 100 * ScriptedBackend::kPointBytes);
}

TEST(DeviceGroup, PlansOfSoManyPatchesTakeAllDevices) {
  const auto plan = MakeGridPlan(16);
  const uint64_t patches = plan->patches.size();
  const Group above = MakeGroup({kGiB, kGiB, kGiB}, patches + 1);
  const Group at = MakeGroup({kGiB, kGiB, kGiB}, patches);

  const auto on_one = above.backend->Prepare(plan, Pipeline::kFused);
  const auto on_all = at.backend->Prepare(plan, Pipeline::kFused);

  ASSERT_OK(on_one);
  ASSERT_OK(on_all);
  EXPECT_EQ((*on_one)->device_use().size(), 1u);
  EXPECT_EQ((*on_all)->device_use().size(), 3u);
  for (ScriptedBackend* device : at.devices) {
    EXPECT_NEAR(static_cast<double>(device->used_bytes()),
                static_cast<double>(patches * ScriptedBackend::kPlanBytes) / 3,
                32.0 * ScriptedBackend::kPlanBytes);
  }
}

// A plan and a view of 10 segments take 592 bytes per patch.
TEST(DeviceGroup, PlansBeyondTheBudgetOfAnyDeviceTakeAllDevices) {
  const auto plan = MakeGridPlan(16);
  const uint64_t need = 592 * plan->patches.size();
  const Group small = MakeGroup({need - 1, need / 2}, kNever);
  const Group large = MakeGroup({need - 1, need}, kNever);

  const auto on_all = small.backend->Prepare(plan, Pipeline::kFused);
  const auto on_one = large.backend->Prepare(plan, Pipeline::kFused);

  ASSERT_OK(on_all);
  ASSERT_OK(on_one);
  EXPECT_EQ((*on_all)->device_use().size(), 2u);
  EXPECT_EQ((*on_one)->device_use().size(), 1u);
  // An equal share of the plan and of a view fits on each device.
  const auto view = (*on_all)->CreateView({.segments = 10});
  EXPECT_OK(view);
}

TEST(DeviceGroup, SharesFollowTheRoomWhereEqualOnesDoNotFit) {
  const auto plan = MakeGridPlan(16);
  const uint64_t patches = plan->patches.size();
  const Group group = MakeGroup({592 * patches, 592 * patches / 4}, 1);

  ASSERT_OK(group.backend->Prepare(plan, Pipeline::kFused));

  // The target is destroyed.
  EXPECT_EQ(group.devices[0]->used_bytes() + group.devices[1]->used_bytes(), 0u);
  const auto target = group.backend->Prepare(plan, Pipeline::kFused);
  ASSERT_OK(target);
  EXPECT_NEAR(static_cast<double>(group.devices[0]->used_bytes()),
              0.8 * static_cast<double>(patches * ScriptedBackend::kPlanBytes),
              32.0 * ScriptedBackend::kPlanBytes);
}

TEST(DeviceGroup, ARefusalNamesTheDeviceAndLeavesNothingOnOthers) {
  const auto plan = MakeGridPlan(16);
  const Group group = MakeGroup({kGiB, 400 * plan->patches.size()}, 1);
  const auto target = group.backend->Prepare(plan, Pipeline::kFused);
  ASSERT_OK(target);
  const uint64_t first = group.devices[0]->used_bytes(), second = group.devices[1]->used_bytes();

  const auto refused = (*target)->CreateView({.segments = 32});

  ASSERT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted));
  const error::Details details = error::DetailsOf(refused.status());
  EXPECT_EQ(details.metadata.at(error::kDeviceKey), "4");
  EXPECT_EQ(details.free_bytes, group.backend->devices()[1].free_bytes);
  EXPECT_GT(details.asked_bytes, details.free_bytes);
  EXPECT_EQ(group.devices[0]->used_bytes(), first);
  EXPECT_EQ(group.devices[1]->used_bytes(), second);
}

TEST(DeviceGroup, AfterOnePartFailedAllChunksMustBeNamed) {
  const auto plan = MakeGridPlan(16);
  const Group group = MakeGroup({kGiB, kGiB}, 1);
  const auto target = group.backend->Prepare(plan, Pipeline::kFused);
  ASSERT_OK(target);
  const auto view = (*target)->CreateView({.segments = 2});
  ASSERT_OK(view);
  const QuantisationBox box{.origin = {-8, -8, -8}, .range = 16};
  std::vector<uint32_t> all(plan->chunk_count());
  std::iota(all.begin(), all.end(), 0u);
  const std::vector<uint32_t> one{0};
  ASSERT_OK((*view)->Evaluate(plan->identity_points, box, all));
  group.devices[1]->script().LoseDevice();

  EXPECT_OK((*view)->Evaluate(plan->identity_points, box, one)) << "the first device has it";
  EXPECT_THAT((*view)->Evaluate(plan->identity_points, box, all),
              StatusIs(absl::StatusCode::kUnavailable));
  EXPECT_THAT((*view)->Evaluate(plan->identity_points, box, one),
              StatusIs(absl::StatusCode::kInvalidArgument));
}

class GroupServerTest : public DeviceFixture {
 protected:
  void StartOnGroup(const std::vector<uint64_t>& bytes, uint64_t span_patches) {
    Group group = MakeGroup(bytes, span_patches);
    devices_ = group.devices;
    ASSERT_NO_FATAL_FAILURE(StartServerOn(std::move(group.backend)));
    mesh_ = Upload(PlaneObj(20));
  }
  // The device bytes of a scene without a view.
  uint64_t MeasurePlan() {
    StartOnGroup({kGiB}, kNever);
    EXPECT_OK(Create(SceneRequest()));
    return devices_[0]->used_bytes();
  }

  std::vector<ScriptedBackend*> devices_;
};

TEST_F(GroupServerTest, ASpannedSceneIsStreamedLikeAnyOther) {
  std::vector<Chunks> streamed;
  for (const std::vector<uint64_t>& bytes : {std::vector{kGiB}, {kGiB, kGiB, kGiB}}) {
    StartOnGroup(bytes, 1);
    ASSERT_OK(Create(SceneRequest()));
    EventLog rest, edited;
    ASSERT_OK(Update(4, kScene, &rest));
    ASSERT_OK(Apply(Move("alice", 1, 21, 0.2)));
    ASSERT_OK(Update(4, kScene, &edited));
    streamed.insert(streamed.end(), {rest.chunks, edited.chunks});
  }

  ASSERT_EQ(Info().backends(0).devices_size(), 3);
  EXPECT_EQ(Info().backends(0).devices(2).number(), 5u);
  EXPECT_GT(streamed[0].size(), 6u);
  EXPECT_EQ(streamed[2], streamed[0]);
  EXPECT_EQ(streamed[3], streamed[1]);
  for (ScriptedBackend* device : devices_) EXPECT_GT(device->used_bytes(), 0u);
}

TEST_F(GroupServerTest, ASpannedSceneHasTheToleranceOfOneDevice) {
  std::vector<Chunks> streamed;
  std::vector<double> certified;
  std::vector<std::string> files;
  for (const std::vector<uint64_t>& bytes : {std::vector{kGiB}, {kGiB, kGiB, kGiB}}) {
    StartOnGroup(bytes, 1);
    ASSERT_OK(Create(SceneRequest()));
    auto update = For<v1::GetUpdateRequest>();
    update.mutable_view()->set_tolerance(1e-3);
    EventLog rest, edited;
    ASSERT_OK(Update(update, rest));
    ASSERT_OK(Apply(Move("alice", 1, 21, 0.2)));
    ASSERT_OK(Update(update, edited));
    streamed.insert(streamed.end(), {rest.chunks, rest.levels, edited.chunks, edited.levels});
    certified.push_back(edited.ends.back().certified_error());
    auto file = For<v1::ExportRequest>();
    file.mutable_view()->set_tolerance(1e-3);
    ASSERT_OK_AND_ASSIGN(files.emplace_back(), Export(file));
  }

  EXPECT_GT(streamed[0].size(), 6u);
  EXPECT_NE(streamed[1], streamed[3]) << "the edit changed no level";
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(streamed[4 + i], streamed[i]) << i;
  EXPECT_GT(certified[0], 0);
  EXPECT_EQ(certified[1], certified[0]);
  EXPECT_EQ(files[1], files[0]);
}

TEST_F(GroupServerTest, TheLossOfOneDeviceTurnsTheServerNotServing) {
  StartOnGroup({kGiB, kGiB}, 1);
  ASSERT_OK(Create(SceneRequest()));
  ASSERT_OK(Update(2));

  devices_[1]->script().LoseDevice();

  ExpectRefused(Update(3), absl::StatusCode::kUnavailable, "DEVICE_LOST");
  for (const char* service : kHealthNames) EXPECT_EQ(Health(server_->channel(), service), "2");
}

// A plan takes 64 bytes per patch, and a view of 10 segments takes 528. Two plans and a view exceed
// either budget. A scene on device 3 is evicted for device 3, although device 4 has an older scene.
TEST_F(GroupServerTest, RoomIsMadeOnTheDeviceThatLacksIt) {
  const uint64_t plan = MeasurePlan(), patches = plan / ScriptedBackend::kPlanBytes;
  StartOnGroup({600 * patches, 600 * patches + 1}, kNever);
  for (const char* id : {"scene-on-4", "scene-on-3", "scene-on-4-too", "scene-on-3-too"}) {
    ASSERT_OK(Create(SceneRequest(id)));
  }
  ASSERT_EQ(devices_[0]->used_bytes(), 2 * plan);
  ASSERT_EQ(devices_[1]->used_bytes(), 2 * plan);

  ASSERT_OK(Update(10, "scene-on-3-too"));

  EXPECT_TRUE(OnDevice("scene-on-4"));
  EXPECT_TRUE(OnDevice("scene-on-4-too"));
  EXPECT_FALSE(OnDevice("scene-on-3"));
  EXPECT_TRUE(OnDevice("scene-on-3-too"));
  EXPECT_EQ(Info().backends(0).give_backs(), 1u);
}

// The first device has 13 of the scene's 25 chunks. A view of 15 segments takes 452,608 bytes there, and
// two plans leave 442,752.
TEST_F(GroupServerTest, ASpannedSceneGivesBackForAnyOfItsDevices) {
  const uint64_t plan = MeasurePlan(), patches = plan / ScriptedBackend::kPlanBytes;
  StartOnGroup({620 * patches, 620 * patches}, patches);
  ASSERT_OK(Create(SceneRequest("scene-one")));
  ASSERT_OK(Create(SceneRequest("scene-two")));
  ASSERT_EQ(devices_[0]->used_bytes() + devices_[1]->used_bytes(), 2 * plan);

  ASSERT_OK(Update(15, "scene-two"));

  EXPECT_FALSE(OnDevice("scene-one"));
  EXPECT_TRUE(OnDevice("scene-two"));
}

TEST_F(GroupServerTest, ARefusalTellsTheClientWhichDeviceLacks) {
  StartOnGroup({16, 32}, kNever);

  const absl::Status refused = Create(SceneRequest());

  ExpectRefused(refused, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
  EXPECT_EQ(error::DetailsOf(refused).metadata.at(error::kDeviceKey), "3");
  EXPECT_EQ(error::DetailsOf(refused).free_bytes, 16u);
  EXPECT_THAT(std::string(refused.message()), HasSubstr("device 3"));
}

}  // namespace
}  // namespace latticed::testing
