// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// No lock is held while a device works for a scene. Meanwhile calls that need no device are answered, the
// same scene is edited, and another scene is evaluated, encoded and sent. An update is sent while the next
// one of the same view is evaluated or encoded, on a device or on the host.
#include <memory>
#include <string>
#include <tuple>
#include <utility>

#include "tests/server/support/scripted_backend.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

constexpr uint64_t kDeviceBytes = uint64_t{1} << 30;

class DeviceWorkTest : public SceneFixture, public ::testing::WithParamInterface<Step> {
 protected:
  void SetUp() override {
    auto backend = std::make_unique<ScriptedBackend>(kDeviceBytes);
    script_ = &backend->script();
    ASSERT_NO_FATAL_FAILURE(StartServerOn(std::move(backend)));
    mesh_ = Upload(kGridObj);
  }

  void TearDown() override { script_->Release(); }

  std::unique_ptr<DeformClient> Open(const std::string& scene) {
    EXPECT_OK(Create(SceneRequest(scene)));
    auto watch = For<v1::WatchRequest>(scene);
    watch.set_editor_id("bob");
    watch.set_max_unacked_updates(0);
    auto client = std::make_unique<DeformClient>(*scenes_, watch);
    client->ReadUntilRevision(0);
    return client;
  }

  Script* script_ = nullptr;  // of the server's backend
};
INSTANTIATE_TEST_SUITE_P(Stages, DeviceWorkTest,
                         ::testing::Values(Step::kCreateView, Step::kEvaluate, Step::kEncode),
                         [](const auto& step) -> std::string {
                           if (step.param == Step::kCreateView) return "CreateView";
                           return step.param == Step::kEvaluate ? "Evaluate" : "Encode";
                         });

TEST_P(DeviceWorkTest, OthersGoOnMeanwhile) {
  const auto held = Open("scene-one"), other = Open("scene-two");
  script_->HoldNext(GetParam());
  v1::DeformRequest view;  // a new view: new memory, all vertices, all chunks
  view.mutable_control()->mutable_view()->set_segments(3);
  ASSERT_TRUE(held->Send(view));
  ASSERT_TRUE(script_->WaitForHeld());

  // The same scene is edited.
  EXPECT_EQ(Get().revision(), 0u);
  ASSERT_OK(Apply(Move("carol", 1, 21, 0.1)));
  ASSERT_TRUE(held->Send(Move("bob", 1, 21, 0.1)));
  held->ReadUntil([&] { return held->log.deltas == 2 && held->log.results.size() == 1; });
  EXPECT_EQ(Lattice().revision(), 2u);
  // Calls about all scenes and about the server.
  EXPECT_EQ(SceneCount(), 2);
  EXPECT_EQ(Info().retired_snapshots(), 0u);
  EXPECT_EQ(Metric("latticed_scenes"), 2);
  // Another scene is evaluated by the other worker.
  v1::EditBatch elsewhere = Move("carol", 1, 21, 0.1);
  elsewhere.set_scene("scene-two");
  ASSERT_OK(Apply(elsewhere));
  other->ReadUntilRevision(1);
  EXPECT_GT(other->log.begins.back().chunk_count(), 0u);

  script_->Release();
  held->ReadUntilRevision(2);
  EXPECT_EQ(held->log.begins.back().view().segments(), 3);
}

class SendingTest : public SceneFixture,
                    public ::testing::WithParamInterface<std::tuple<bool, Step>> {
 protected:
  void SetUp() override {
    auto backend = std::get<0>(GetParam()) ? std::make_unique<ScriptedBackend>(kDeviceBytes)
                                           : std::make_unique<ScriptedBackend>();
    script_ = &backend->script();
    ASSERT_NO_FATAL_FAILURE(StartServerOn(std::move(backend)));
    mesh_ = Upload(PlaneObj(40));
    ASSERT_OK(Create(SceneRequest()));
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);  // else the windows grow on a fast link
    Reach(grpc::CreateCustomChannel(server_->address(), grpc::InsecureChannelCredentials(),
                                    arguments));
  }
  void TearDown() override { script_->Release(); }

  // Moves all 64 control points, which changes every chunk.
  void MoveAll(uint64_t sequence) {
    v1::EditBatch batch = Move("carol", sequence, 0, 0.1);
    for (uint32_t i = 1; i < 64; ++i) {
      batch.mutable_edits(0)->mutable_move_control_points()->add_indices(i);
    }
    ASSERT_OK(Apply(batch));
  }

  Script* script_ = nullptr;  // of the server's backend
};
std::string NameOf(const ::testing::TestParamInfo<SendingTest::ParamType>& test) {
  const auto [on_device, step] = test.param;
  return std::string(on_device ? "Device" : "Host") +
         (step == Step::kEvaluate ? "Evaluates" : "Encodes");
}
INSTANTIATE_TEST_SUITE_P(Stages, SendingTest,
                         ::testing::Combine(::testing::Bool(),
                                            ::testing::Values(Step::kEvaluate, Step::kEncode)),
                         NameOf);

TEST_P(SendingTest, GoesOnWhileTheNextUpdateIsAtWork) {
  auto watch = For<v1::WatchRequest>();
  watch.set_max_unacked_updates(0);
  DeformClient client(*scenes_, watch);
  client.ReadUntilRevision(0);
  MoveAll(1);
  client.ReadUntil([&] { return client.log.begins.size() == 2; });

  script_->HoldNext(std::get<1>(GetParam()));
  MoveAll(2);
  ASSERT_TRUE(script_->WaitForHeld());
  EXPECT_EQ(Metric("latticed_updates_begun_total"), 2);
  EXPECT_EQ(Metric("latticed_updates_finished_total"), 1) << "more is to be sent than windows hold";
  client.ReadUntilRevision(1);

  EXPECT_EQ(Metric("latticed_updates_begun_total"), 2) << "revision 2 is at work";
  script_->Release();
  client.ReadUntilRevision(2);
}

}  // namespace
}  // namespace latticed::testing
