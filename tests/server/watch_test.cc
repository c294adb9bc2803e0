// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// SceneService.Watch and ControlWatch through a stub.
#include "absl/time/clock.h"
#include "tests/server/refusal.h"
#include "tests/server/watch_client.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

class WatchTest : public StreamTest {
 protected:
  grpc::Status Control(const v1::ControlWatchRequest& request,
                       v1::ControlWatchResponse* response = nullptr) {
    grpc::ClientContext context;
    v1::ControlWatchResponse ignored;
    return scenes_->ControlWatch(&context, request, response != nullptr ? response : &ignored);
  }
};

TEST_F(WatchTest, EditsByApplyEditsAreSeen) {
  CreateScene();
  WatchClient watcher(*scenes_, Watch());
  watcher.ReadUntil([&] { return watcher.log.ends.size() == 1; });

  ASSERT_TRUE(Apply(Move(4, 62, 0.1)).ok());
  watcher.ReadUntil([&] { return watcher.log.ends.back().revision() == 1; });

  EXPECT_EQ(watcher.log.ends.back().applied_sequence(), 4u);
  EXPECT_TRUE(watcher.log.results.empty()) << "the answer went to ApplyEdits";
}

TEST_F(WatchTest, AnEditThatChangesNoIntegerIsAnUpdateWithoutChunks) {
  CreateScene();
  WatchClient watcher(*scenes_, Watch());
  watcher.ReadUpdates(1);

  v1::EditResult result;
  ASSERT_TRUE(Apply(Move(1, 62, 1e-15), &result).ok());
  watcher.ReadUpdates(2);

  EXPECT_GT(result.patches_touched(), 0u);
  EXPECT_EQ(watcher.log.begins.back().chunk_count(), 0u);
  EXPECT_EQ(watcher.log.ends.back().revision(), 1u);
  EXPECT_TRUE(watcher.log.ends.back().full_detail());
}

TEST_F(WatchTest, ControlWatchAcknowledgesPausesAndChangesTheView) {
  CreateScene();
  v1::WatchRequest request = Watch();
  request.set_max_unacked_updates(1);
  WatchClient watcher(*scenes_, request);
  watcher.ReadUntil([&] { return watcher.log.ends.size() == 1; });
  ASSERT_TRUE(Apply(Move(1, 62, 0.1)).ok());
  watcher.ReadUntil([&] { return watcher.log.deltas == 1; });
  absl::SleepFor(absl::Milliseconds(50));
  EXPECT_EQ(watcher.log.begins.size(), 1u);

  v1::ControlWatchRequest control;
  control.set_watch_id(watcher.log.hello.watch_id());
  control.set_acked_update_id(1);
  control.mutable_view()->set_segments(2);
  v1::ControlWatchResponse response;
  ASSERT_TRUE(Control(control, &response).ok());
  EXPECT_EQ(response.head_revision(), 1u);
  watcher.ReadUntil([&] { return watcher.log.ends.size() == 2; });

  EXPECT_EQ(watcher.log.begins.back().view().segments(), 2);
}

TEST_F(WatchTest, ControlWatchRefusesWhatItCannotDo) {
  CreateScene();
  v1::ControlWatchRequest control;
  ExpectRefusal(Control(control),
                {.reason = "INVALID_FIELD", .field = "watch_id", .message = "is required"});
  control.set_watch_id("nobody");
  EXPECT_EQ(Control(control).error_code(), grpc::StatusCode::NOT_FOUND);

  WatchClient watcher(*scenes_, Watch());
  watcher.ReadUntil([&] { return watcher.log.ends.size() == 1; });
  control.set_watch_id(watcher.log.hello.watch_id());
  EXPECT_TRUE(Control(control).ok()) << "a heartbeat";
  control.set_scene("another-scene");
  EXPECT_EQ(Control(control).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  control.clear_scene();
  control.set_acked_update_id(99);
  EXPECT_EQ(Control(control).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  control.clear_acked_update_id();
  control.mutable_view()->set_position_bits(17);
  EXPECT_EQ(Control(control).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(WatchTest, AWatchThatEndedIsNotFound) {
  CreateScene();
  v1::ControlWatchRequest control;
  {
    WatchClient watcher(*scenes_, Watch());
    watcher.ReadUntil([&] { return watcher.log.ends.size() == 1; });
    control.set_watch_id(watcher.log.hello.watch_id());
  }

  EXPECT_TRUE(Becomes(2000, [&] { return !Control(control).ok(); }));
  EXPECT_EQ(Control(control).error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(WatchTest, ATokenOfADeletedSceneDoesNotResumeItsSuccessor) {
  CreateScene();
  v1::WatchRequest watch = Watch();
  {
    DeformClient client(*scenes_);
    client.Open(watch);
    client.ReadUntilRevision(0);
    watch.set_resume_token(client.log.ends.back().resume_token());
  }
  grpc::ClientContext context;
  v1::DeleteSceneRequest request;
  request.set_scene(kScene);
  v1::DeleteSceneResponse response;
  ASSERT_TRUE(scenes_->DeleteScene(&context, request, &response).ok());
  CreateScene();

  DeformClient client(*scenes_);
  client.Open(watch);
  client.ReadUntilRevision(0);

  EXPECT_FALSE(client.log.hello.resumed());
  EXPECT_GT(client.log.begins.at(0).chunk_count(), 0u);
}

}  // namespace
}  // namespace latticed::testing
