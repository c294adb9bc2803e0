// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The life of a Watch stream, for clients without bidirectional ones: heartbeats, resumption, and
// its ends; and unary calls whose deadline has passed.
#include <thread>

#include "tests/server/refusal.h"
#include "tests/server/watch_client.h"

namespace latticed::testing {
namespace {

class WatchLifeTest : public StreamTest {
 protected:
  grpc::Status Heartbeat(const WatchClient& watcher) {
    grpc::ClientContext context;
    v1::ControlWatchRequest request;
    request.set_watch_id(watcher.log.hello.watch_id());
    v1::ControlWatchResponse response;
    return scenes_->ControlWatch(&context, request, &response);
  }
};

TEST_F(WatchLifeTest, HeartbeatsComeAndASilentWatcherIsPausedUntilItIsHeard) {
  StartServer(absl::Milliseconds(100));
  CreateScene();
  WatchClient watcher(*scenes_, Watch());

  watcher.ReadUntil([&] { return watcher.log.heartbeats >= 6; });
  EXPECT_EQ(watcher.log.hello.heartbeat().nanos(), 100'000'000);
  ASSERT_TRUE(Apply(Move(1, 62, 0.01, "bob")).ok());
  const size_t heartbeats = watcher.log.heartbeats, updates = watcher.log.begins.size();
  watcher.ReadUntil([&] { return watcher.log.heartbeats >= heartbeats + 3; });
  EXPECT_EQ(watcher.log.begins.size(), updates) << "silent, so paused";

  // Heard at every heartbeat: the update may take longer than silence may.
  const auto caught_up = [&] {
    return !watcher.log.ends.empty() && watcher.log.ends.back().revision() == 1;
  };
  while (!caught_up()) {
    ASSERT_TRUE(Heartbeat(watcher).ok());
    const size_t before = watcher.log.heartbeats;
    ASSERT_NO_FATAL_FAILURE(
        watcher.ReadUntil([&] { return caught_up() || watcher.log.heartbeats > before; }));
  }
}

TEST_F(WatchLifeTest, AResumedWatchGetsWhatChangedSince) {
  CreateScene(32);
  v1::WatchRequest request = Watch();
  EventLog before;
  {
    WatchClient watcher(*scenes_, request);
    watcher.ReadUpdates(1);
    before = watcher.log;
    request.set_resume_token(watcher.log.ends.back().resume_token());
  }
  ASSERT_TRUE(Apply(Move(1, 0, -0.01, "bob")).ok());

  WatchClient resumed(*scenes_, request);
  resumed.ReadUpdates(1);
  EXPECT_TRUE(resumed.log.hello.resumed());
  EXPECT_EQ(resumed.log.hello.head_revision(), 1u);
  EXPECT_LT(resumed.log.begins[0].chunk_count(), before.chunks.size());
  for (const auto& [index, data] : resumed.log.chunks) before.chunks[index] = data;

  request.set_resume_token("no token of ours");
  WatchClient stranger(*scenes_, request);
  stranger.ReadUpdates(1);
  EXPECT_FALSE(stranger.log.hello.resumed());
  EXPECT_TRUE(stranger.log.chunks == before.chunks) << "what was kept and what came make it whole";
}

TEST_F(WatchLifeTest, ADeletedSceneEndsTheWatchNotFound) {
  CreateScene();
  WatchClient watcher(*scenes_, Watch());
  watcher.ReadUpdates(1);
  grpc::ClientContext context;
  v1::DeleteSceneRequest request;
  request.set_scene(kScene);
  v1::DeleteSceneResponse response;
  ASSERT_TRUE(scenes_->DeleteScene(&context, request, &response).ok());

  ExpectRefusal(watcher.Finish(), {.code = absl::StatusCode::kNotFound,
                                   .reason = "NOT_FOUND",
                                   .message = "no scene with id 'scene-under-test'"});
  EXPECT_EQ(Heartbeat(watcher).error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(WatchLifeTest, DrainSaysGoawayAndEndsTheWatchOk) {
  CreateScene();
  WatchClient watcher(*scenes_, Watch());
  watcher.ReadUpdates(1);

  std::thread drain([this] { server_->Drain(); });
  const grpc::Status status = watcher.Finish();
  drain.join();

  EXPECT_TRUE(status.ok()) << status.error_message();
  ASSERT_EQ(watcher.log.goaways.size(), 1u);
  EXPECT_EQ(watcher.log.goaways[0].reason(), v1::GOAWAY_REASON_DRAINING);
  EXPECT_EQ(watcher.log.goaways[0].retry_after().seconds(), 1);
}

TEST_F(WatchLifeTest, AUnaryCallPastItsDeadlineChangesNothing) {
  CreateScene();
  grpc::ClientContext late, get;
  late.set_deadline(std::chrono::system_clock::now() - std::chrono::seconds(1));
  v1::EditResult result;
  const grpc::Status status = scenes_->ApplyEdits(&late, Move(1, 62, 0.1), &result);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_EQ(error::DetailsOf(client::FromGrpc(status)).reason, "DEADLINE_EXCEEDED");

  v1::GetSceneRequest request;
  request.set_scene(kScene);
  v1::Scene scene;
  ASSERT_TRUE(scenes_->GetScene(&get, request, &scene).ok());
  EXPECT_EQ(scene.revision(), 0u);
}

}  // namespace
}  // namespace latticed::testing
