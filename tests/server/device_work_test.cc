// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// While a device is at work for a scene no lock is held across it: what needs no device is answered,
// the same scene is edited, and another one is evaluated, encoded and sent. And an update is sent while
// the next one of the same view is at work, on the host's own cores as well.
#include <memory>
#include <string>
#include <tuple>
#include <utility>

#include "tests/server/engine/staged_backend.h"
#include "tests/server/scene_fixture.h"
#include "tests/server/stream_support.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

class DeviceWorkTest : public SceneFixture, public ::testing::WithParamInterface<Stage> {
 protected:
  void SetUp() override {
    auto backend = std::make_unique<StagedBackend>(/*on_device=*/true);
    gates_ = &backend->gates();
    ASSERT_NO_FATAL_FAILURE(StartServerOn(std::move(backend)));
    mesh_ = Upload(kGridObj);
  }
  void TearDown() override { gates_->OpenAll(); }

  void OpenWatch(DeformClient& client, const std::string& scene) {
    ASSERT_OK(Create(SceneRequest(scene)));
    v1::WatchRequest watch;
    watch.set_scene(scene);
    watch.set_editor_id("bob");
    watch.set_max_unacked_updates(0);
    client.Open(watch);
    client.ReadUntilRevision(0);
  }

  StageGates* gates_ = nullptr;  // of the server's backend
};
INSTANTIATE_TEST_SUITE_P(Stages, DeviceWorkTest,
                         ::testing::Values(Stage::kCreateView, Stage::kEvaluate, Stage::kEncode),
                         [](const auto& stage) -> std::string {
                           if (stage.param == Stage::kCreateView) return "CreateView";
                           return stage.param == Stage::kEvaluate ? "Evaluate" : "Encode";
                         });

TEST_P(DeviceWorkTest, OthersGoOnMeanwhile) {
  DeformClient held(*stub_), other(*stub_);
  OpenWatch(held, "scene-one");
  OpenWatch(other, "scene-two");
  const int begun = gates_->begun(GetParam());
  gates_->HoldNext(GetParam());
  v1::DeformRequest view;  // another one: memory, all vertices and all streams anew
  view.mutable_control()->mutable_view()->set_segments(3);
  ASSERT_TRUE(held.Send(view));
  ASSERT_TRUE(gates_->WaitForBegun(GetParam(), begun + 1));

  // The same scene.
  EXPECT_EQ(Get().revision(), 0u);
  ASSERT_OK(Apply(Move("carol", 1, 21, 0.1)));
  ASSERT_TRUE(held.Send(Move("bob", 1, 21, 0.1)));
  held.ReadUntil([&] { return held.log.deltas == 2 && held.log.results.size() == 1; });
  EXPECT_EQ(Lattice().revision(), 2u);
  // All scenes, and the server.
  v1::ListScenesResponse list;
  ASSERT_OK(Call(&v1::SceneService::Stub::ListScenes, v1::ListScenesRequest(), &list));
  EXPECT_EQ(list.scenes_size(), 2);
  EXPECT_EQ(Info().retired_snapshots(), 0u);
  EXPECT_THAT(server_->metrics(), HasSubstr("latticed_scenes 2\n"));
  // Another scene, by the other worker.
  v1::EditBatch elsewhere = Move("carol", 1, 21, 0.1);
  elsewhere.set_scene("scene-two");
  ASSERT_OK(Apply(elsewhere));
  other.ReadUntilRevision(1);
  EXPECT_GT(other.log.begins.back().chunk_count(), 0u);

  EXPECT_EQ(gates_->begun(GetParam()) - gates_->ended(GetParam()), 1) << "the one that is held";
  gates_->Open(GetParam());
  held.ReadUntilRevision(2);
  EXPECT_EQ(held.log.begins.back().view().segments(), 3);
}

class SendingTest : public SceneFixture,
                    public ::testing::WithParamInterface<std::tuple<bool, Stage>> {
 protected:
  void SetUp() override {
    auto backend = std::make_unique<StagedBackend>(/*on_device=*/std::get<0>(GetParam()));
    gates_ = &backend->gates();
    ASSERT_NO_FATAL_FAILURE(StartServerOn(std::move(backend)));
    mesh_ = Upload(PlaneObj(40));
    ASSERT_OK(Create(SceneRequest()));
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);  // or windows grow on a fast link
    stub_ = v1::SceneService::NewStub(grpc::CreateCustomChannel(
        server_->address(), grpc::InsecureChannelCredentials(), arguments));
  }
  void TearDown() override { gates_->OpenAll(); }

  // Moves all 64 control points, and every chunk with them.
  void MoveAll(uint64_t sequence) {
    v1::EditBatch batch = Move("carol", sequence, 0, 0.1);
    for (uint32_t i = 1; i < 64; ++i) {
      batch.mutable_edits(0)->mutable_move_control_points()->add_indices(i);
    }
    ASSERT_OK(Apply(batch));
  }

  StageGates* gates_ = nullptr;  // of the server's backend
};
std::string NameOf(const ::testing::TestParamInfo<SendingTest::ParamType>& test) {
  const auto [on_device, stage] = test.param;
  return std::string(on_device ? "Device" : "Host") +
         (stage == Stage::kEvaluate ? "Evaluates" : "Encodes");
}
INSTANTIATE_TEST_SUITE_P(Stages, SendingTest,
                         ::testing::Combine(::testing::Bool(),
                                            ::testing::Values(Stage::kEvaluate, Stage::kEncode)),
                         NameOf);

TEST_P(SendingTest, GoesOnWhileTheNextUpdateIsAtWork) {
  const Stage stage = std::get<1>(GetParam());
  DeformClient client(*stub_);
  v1::WatchRequest watch;
  watch.set_scene("scene-one");
  watch.set_max_unacked_updates(0);
  client.Open(watch);
  client.ReadUntilRevision(0);
  MoveAll(1);
  client.ReadUntil([&] { return client.log.begins.size() == 2; });

  const int begun = gates_->begun(stage);
  gates_->HoldNext(stage);
  MoveAll(2);
  ASSERT_TRUE(gates_->WaitForBegun(stage, begun + 1));
  EXPECT_THAT(server_->metrics(), HasSubstr("\nlatticed_updates_begun_total 2\n"));
  EXPECT_THAT(server_->metrics(), HasSubstr("\nlatticed_updates_finished_total 1\n"))
      << "more is to be sent than windows hold";
  client.ReadUntilRevision(1);

  EXPECT_EQ(gates_->ended(stage), begun) << "revision 2 is at work";
  gates_->Open(stage);
  client.ReadUntilRevision(2);
}

}  // namespace
}  // namespace latticed::testing
