// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// SceneService.Watch and ControlWatch through a stub.
#include "tests/server/support/server_test.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

class WatchTest : public SceneStreamTest {
 protected:
  absl::Status Control(const v1::ControlWatchRequest& request) {
    return Call(&Scenes::ControlWatch, request);
  }
};

TEST_F(WatchTest, EditsByApplyEditsAreSeen) {
  WatchClient watcher(*scenes_, Watch());
  watcher.ReadUpdates(1);

  ASSERT_OK(Apply(Move(4, 62, 0.1)));
  watcher.ReadUntilRevision(1);

  EXPECT_EQ(watcher.log.ends.back().applied_sequence(), 4u);
  EXPECT_TRUE(watcher.log.results.empty()) << "the answer went to ApplyEdits";
}

TEST_F(WatchTest, AnEditThatChangesNoIntegerIsAnUpdateWithoutChunks) {
  WatchClient watcher(*scenes_, Watch());
  watcher.ReadUpdates(1);

  v1::EditResult result;
  ASSERT_OK(Apply(Move(1, 62, 1e-15), &result));
  watcher.ReadUpdates(2);

  EXPECT_GT(result.patches_touched(), 0u);
  EXPECT_EQ(watcher.log.begins.back().chunk_count(), 0u);
  EXPECT_EQ(watcher.log.ends.back().revision(), 1u);
  EXPECT_TRUE(watcher.log.ends.back().full_detail());
}

TEST_F(WatchTest, ControlWatchAcknowledgesPausesAndChangesTheView) {
  v1::WatchRequest request = Watch();
  request.set_max_unacked_updates(1);
  WatchClient watcher(*scenes_, request);
  watcher.ReadUpdates(1);
  for (uint64_t i = 1; i <= 3; ++i) {
    ASSERT_OK(Apply(Move(i, 62, 0.1)));
    watcher.ReadUntil([&] { return watcher.log.deltas == i; });
  }
  EXPECT_EQ(watcher.log.begins.size(), 1u);

  v1::ControlWatchRequest control;
  control.set_acked_update_id(1);
  control.mutable_view()->set_segments(2);
  v1::ControlWatchResponse response;
  ASSERT_OK(StreamTest::Control(watcher, control, &response));
  EXPECT_EQ(response.head_revision(), 3u);
  watcher.ReadUpdates(2);

  EXPECT_EQ(watcher.log.begins.back().view().segments(), 2);
}

TEST_F(WatchTest, ControlWatchRefusesWhatItCannotDo) {
  v1::ControlWatchRequest control;
  ExpectRefusal(Control(control),
                {.reason = "INVALID_FIELD", .field = "watch_id", .message = "is required"});
  control.set_watch_id("nobody");
  EXPECT_THAT(Control(control), StatusIs(absl::StatusCode::kNotFound));

  WatchClient watcher(*scenes_, Watch());
  watcher.ReadUpdates(1);
  control.set_watch_id(watcher.log.hello.watch_id());
  EXPECT_OK(Control(control)) << "a heartbeat";
  control.set_scene("another-scene");
  EXPECT_THAT(Control(control), StatusIs(absl::StatusCode::kInvalidArgument));
  control.clear_scene();
  control.set_acked_update_id(99);
  EXPECT_THAT(Control(control), StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST_F(WatchTest, AWatchThatEndedIsNotFound) {
  v1::ControlWatchRequest control;
  {
    WatchClient watcher(*scenes_, Watch());
    watcher.ReadUpdates(1);
    control.set_watch_id(watcher.log.hello.watch_id());
  }

  EXPECT_TRUE(Becomes(2000, [&] { return !Control(control).ok(); }));
  EXPECT_THAT(Control(control), StatusIs(absl::StatusCode::kNotFound));
}

TEST_F(WatchTest, ATokenOfADeletedSceneDoesNotResumeItsSuccessor) {
  v1::WatchRequest watch = Watch();
  {
    DeformClient client(*scenes_, watch);
    client.ReadUntilRevision(0);
    watch.set_resume_token(client.log.ends.back().resume_token());
  }
  ASSERT_OK(DeleteScene());
  CreateScene();

  DeformClient client(*scenes_, watch);
  client.ReadUntilRevision(0);

  EXPECT_FALSE(client.log.hello.resumed());
  EXPECT_GT(client.log.begins.at(0).chunk_count(), 0u);
}

}  // namespace
}  // namespace latticed::testing
