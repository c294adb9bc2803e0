// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The limits that GetServerInfo publishes are those that are enforced.
#include <gtest/gtest.h>

#include "core/base/limits.h"
#include "latticed/v1/server.grpc.pb.h"
#include "tests/server/scene_fixture.h"
#include "tests/server/unfinished_calls.h"

namespace latticed::testing {
namespace {

class ServerLimitsTest : public SceneFixture {
 protected:
  v1::ServerLimits Limits() {
    grpc::ClientContext context;
    v1::ServerInfo info;
    EXPECT_OK(client::FromGrpc(
        v1::ServerService::NewStub(server_->channel())->GetServerInfo(&context, {}, &info)));
    return info.limits();
  }
};

TEST_F(ServerLimitsTest, NoLimitIsZero) {
  const v1::ServerLimits limits = Limits();
  EXPECT_EQ(limits.max_scenes(), 10'000);
  EXPECT_EQ(limits.max_watchers_per_scene(), 1'000);
  EXPECT_EQ(limits.max_evaluate_points(), 4'096);
}

TEST_F(ServerLimitsTest, OneSceneTooMany) {
  Options options;
  options.max_scenes = 2;
  StartServer(options);
  EXPECT_EQ(Limits().max_scenes(), 2);
  ASSERT_OK(Create(SceneRequest("scene-one")));
  ASSERT_OK(Create(SceneRequest("scene-two")));

  ExpectRefused(Create(SceneRequest("scene-three")), absl::StatusCode::kResourceExhausted,
                "LIMIT_EXCEEDED");

  EXPECT_OK(Create(SceneRequest("scene-two"))) << "the same again is no other scene";
  v1::DeleteSceneRequest request;
  request.set_scene("scene-one");
  v1::DeleteSceneResponse response;
  ASSERT_OK(Call(&v1::SceneService::Stub::DeleteScene, request, &response));
  EXPECT_OK(Create(SceneRequest("scene-three")));
}

TEST_F(ServerLimitsTest, OneWatcherTooMany) {
  Options options;
  options.max_watchers = 1;
  StartServer(options);
  EXPECT_EQ(Limits().max_watchers_per_scene(), 1);
  ASSERT_OK(Create(SceneRequest()));
  v1::WatchRequest request;
  request.set_scene("scene-one");
  grpc::ClientContext first_context, second_context;
  const auto first = stub_->Watch(&first_context, request);
  v1::SceneEvent event;
  ASSERT_TRUE(first->Read(&event));

  std::vector<v1::SceneEvent> events;
  ExpectRefused(ReadAll(*stub_->Watch(&second_context, request), events),
                absl::StatusCode::kResourceExhausted, "LIMIT_EXCEEDED");
  EXPECT_TRUE(events.empty());
  EXPECT_TRUE(first->Read(&event)) << "the first goes on";
  first_context.TryCancel();
}

TEST_F(ServerLimitsTest, PointsOfOneEvaluation) {
  ASSERT_OK(Create(SceneRequest()));
  v1::EvaluatePointsRequest request;
  request.set_scene("scene-one");
  for (int i = 0; i <= limits::kMaxEvaluatePoints; ++i)
    request.mutable_surface_points()->add_points();
  v1::EvaluatePointsResponse response;

  const absl::Status status = Call(&v1::SceneService::Stub::EvaluatePoints, request, &response);

  ExpectRefused(status, absl::StatusCode::kInvalidArgument, "OUT_OF_RANGE",
                "surface_points.points");
}

TEST_F(ServerLimitsTest, ARequestThatIsLargerInMemoryThanAllThatMayWait) {
  StartServer({.memory_bytes = uint64_t{64} << 20});
  ASSERT_OK(Create(SceneRequest()));
  v1::EditBatch batch = Move("alice", 1, 0, 0.5);
  for (int i = 0; i < 250'000; ++i) batch.add_edits();  // two bytes each on the wire

  const absl::Status status = Apply(batch);

  ExpectRefused(status, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
  EXPECT_EQ(error::DetailsOf(status).free_bytes, uint64_t{8} << 20) << "an eighth of --memory";
  EXPECT_OK(Apply(Move("alice", 1, 0, 0.5)));
}

class TransportMemoryTest : public ServerLimitsTest {
 protected:
  static constexpr int kCalls = 64;
  static constexpr size_t kBytes = 1'000'000;

  std::unique_ptr<UnfinishedCalls> Calls(uint64_t transport_memory_bytes) {
    StartServer({.transport_memory_bytes = transport_memory_bytes});
    return std::make_unique<UnfinishedCalls>(
        server_->address(), "/latticed.v1.SceneService/ApplyEdits", kCalls, kBytes);
  }
};

TEST_F(TransportMemoryTest, HoldsMessagesThatHaveNotEndedWhereThereIsRoom) {
  const auto calls = Calls(uint64_t{256} << 20);

  EXPECT_TRUE(calls->Run([&] { return calls->sent() == kCalls; })) << calls->sent();

  EXPECT_EQ(calls->held_bytes(), kCalls * (kBytes - 1));
  EXPECT_EQ(calls->ended(), 0u);
}

TEST_F(TransportMemoryTest, EndsCallsWhoseMessagesTakeMore) {
  const auto calls = Calls(limits::kMinTransportBytes);

  EXPECT_TRUE(calls->Run([&] {
    return calls->sent() + calls->ended() == kCalls &&
           calls->held_bytes() <= limits::kMinTransportBytes;
  })) << calls->held_bytes()
      << " bytes are held, " << calls->ended() << " calls ended";

  EXPECT_GT(calls->ended(), 0u);
  EXPECT_GT(calls->sent(), 0u) << "the others go on";
  EXPECT_EQ(Limits().max_scenes(), 10'000) << "and new ones are answered";
}

TEST_F(ServerLimitsTest, ASceneSaysWhatItsHistoryHolds) {
  v1::Scene before, after;
  ASSERT_OK(Create(SceneRequest(), &before));
  ASSERT_OK(Apply(Move("alice", 1, 0, 0.5)));
  ASSERT_OK(Create(SceneRequest(), &after));

  ASSERT_TRUE(before.bytes().contains("history"));
  EXPECT_GT(after.bytes().at("history"), before.bytes().at("history"));
}

}  // namespace
}  // namespace latticed::testing
