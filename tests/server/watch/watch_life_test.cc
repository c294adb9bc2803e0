// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The life of a Watch stream, for clients without bidirectional streams: heartbeats, resumption, and
// its end. Also unary calls whose deadline has passed.
#include <thread>

#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

class WatchLifeTest : public StreamTest {
 protected:
  absl::Status Heartbeat(const WatchClient& watcher) { return Control(watcher, {}); }
};

TEST_F(WatchLifeTest, HeartbeatsComeAndASilentWatcherIsPausedUntilItIsHeard) {
  StartServer(absl::Milliseconds(100));
  CreateScene();
  WatchClient watcher(*scenes_, Watch());

  watcher.ReadUntil([&] { return watcher.log.heartbeats >= 6; });
  EXPECT_EQ(watcher.log.hello.heartbeat().nanos(), 100'000'000);
  ASSERT_OK(Apply(Move(1, 62, 0.01, "bob")));
  const size_t heartbeats = watcher.log.heartbeats, updates = watcher.log.begins.size();
  watcher.ReadUntil([&] { return watcher.log.heartbeats >= heartbeats + 3; });
  EXPECT_EQ(watcher.log.begins.size(), updates) << "silent, so paused";

  // Answers every heartbeat, because the update may take longer than a watcher may be silent.
  const auto caught_up = [&] {
    return !watcher.log.ends.empty() && watcher.log.ends.back().revision() == 1;
  };
  while (!caught_up()) {
    ASSERT_OK(Heartbeat(watcher));
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
  ASSERT_OK(Apply(Move(1, 0, -0.01, "bob")));

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
  ASSERT_OK(DeleteScene());

  ExpectRefusal(watcher.Finish(), {.code = absl::StatusCode::kNotFound,
                                   .reason = "NOT_FOUND",
                                   .message = "no scene with id 'scene-one'"});
  EXPECT_THAT(Heartbeat(watcher), StatusIs(absl::StatusCode::kNotFound));
}

TEST_F(WatchLifeTest, DrainSaysGoawayAndEndsTheWatchOk) {
  CreateScene();
  WatchClient watcher(*scenes_, Watch());
  watcher.ReadUpdates(1);

  std::thread drain([this] { server_->Drain(); });
  const absl::Status status = watcher.Finish();
  drain.join();

  EXPECT_OK(status);
  ASSERT_EQ(watcher.log.goaways.size(), 1u);
  EXPECT_EQ(watcher.log.goaways[0].reason(), v1::GOAWAY_REASON_DRAINING);
  EXPECT_EQ(watcher.log.goaways[0].retry_after().seconds(), 1);
}

// Of each edit that a client sent, an answer says whether it was applied.
TEST_F(WatchLifeTest, EditsThatComeWhileTheServerDrainsAreAnswered) {
  CreateScene();
  DeformClient client(*scenes_, Watch());
  client.ReadUpdates(1);
  std::thread drain([this] { server_->Drain(); });
  client.ReadUntil([&] { return !client.log.goaways.empty(); });

  ASSERT_TRUE(client.Send(Move(1, 62, 0.1)));
  ASSERT_TRUE(client.Send(Move(2, 62, 0.1)));
  const absl::Status status = client.Finish();
  drain.join();

  EXPECT_OK(status);
  ASSERT_EQ(client.log.results.size(), 2u);
  for (const v1::EditResult& result : client.log.results) {
    EXPECT_EQ(result.status().code(), int{grpc::StatusCode::UNAVAILABLE});
    EXPECT_THAT(result.status().message(), ::testing::HasSubstr("shutting down"));
  }
}

TEST_F(WatchLifeTest, AUnaryCallPastItsDeadlineChangesNothing) {
  CreateScene();
  grpc::ClientContext late;
  late.set_deadline(std::chrono::system_clock::now() - std::chrono::seconds(1));
  v1::EditResult result;
  ExpectRefused(client::FromGrpc(scenes_->ApplyEdits(&late, Move(1, 62, 0.1), &result)),
                absl::StatusCode::kDeadlineExceeded, "DEADLINE_EXCEEDED");
  EXPECT_EQ(Get().revision(), 0u);
}

}  // namespace
}  // namespace latticed::testing
