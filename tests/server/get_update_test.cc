// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// SceneService.GetUpdate through a stub.
#include <thread>

#include "absl/time/clock.h"
#include "tests/server/stream_support.h"

namespace latticed::testing {
namespace {

class GetUpdateTest : public StreamTest {
 protected:
  static v1::GetUpdateRequest Request() {
    v1::GetUpdateRequest request;
    request.set_scene(kScene);
    return request;
  }
};

TEST_F(GetUpdateTest, SendsLatticeTopologyQuantisationAndOneUpdateThenEnds) {
  CreateScene();
  EventLog log;

  ASSERT_TRUE(Update(Request(), log).ok());

  EXPECT_TRUE(log.events[0].has_lattice_state()) << "no hello";
  EXPECT_TRUE(log.events[1].has_topology());
  EXPECT_TRUE(log.events[2].has_quantisation());
  EXPECT_TRUE(log.events.back().has_update_end());
  EXPECT_EQ(log.ends.size(), 1u);
  EXPECT_EQ(log.begins[0].chunk_count(), log.chunks.size());
}

TEST_F(GetUpdateTest, HoldsEveryEditThatWasAnswered) {
  CreateScene();
  for (uint64_t i = 1; i <= 5; ++i) {
    ASSERT_TRUE(Apply(Move(i, 62, 0.01)).ok());
    EventLog log;
    ASSERT_TRUE(Update(Request(), log).ok());
    EXPECT_EQ(log.ends[0].revision(), i);
  }
}

TEST_F(GetUpdateTest, WaitsForTheRevision) {
  CreateScene();
  v1::GetUpdateRequest request = Request();
  request.set_min_revision(2);
  std::thread editor([this] {
    absl::SleepFor(absl::Milliseconds(50));
    EXPECT_TRUE(Apply(Move(1, 62, 0.01)).ok());
    EXPECT_TRUE(Apply(Move(2, 62, 0.01)).ok());
  });
  EventLog log;

  EXPECT_TRUE(Update(request, log).ok());
  editor.join();

  EXPECT_GE(log.ends.at(0).revision(), 2u);
}

TEST_F(GetUpdateTest, ADeadlineEndsTheWait) {
  CreateScene();
  v1::GetUpdateRequest request = Request();
  request.set_min_revision(1'000);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(100));
  const auto reader = scenes_->GetUpdate(&context, request);
  v1::SceneEvent event;
  while (reader->Read(&event)) continue;

  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
}

TEST_F(GetUpdateTest, BigUpdatesComeInMessagesBelowTheLimit) {
  CreateScene(32);
  v1::GetUpdateRequest request = Request();
  request.mutable_view()->set_segments(16);
  request.mutable_view()->set_encoding(v1::ENCODING_RAW);
  EventLog log;

  ASSERT_TRUE(Update(request, log).ok());

  std::vector<size_t> sizes;
  size_t bytes = 0;
  for (const v1::SceneEvent& event : log.events) {
    if (!event.has_chunks()) continue;
    sizes.push_back(event.ByteSizeLong());
    for (const v1::Chunk& chunk : event.chunks().chunks()) bytes += chunk.data().size();
  }
  ASSERT_GT(sizes.size(), 4u);
  EXPECT_LT(sizes[0], size_t{256} << 10) << "the first is flushed early";
  for (size_t i = 1; i + 1 < sizes.size(); ++i) {
    EXPECT_GE(sizes[i], size_t{256} << 10);
    EXPECT_LT(sizes[i], size_t{1} << 20);
  }
  EXPECT_EQ(bytes, log.topologies[0].point_count() * 24);
}

TEST_F(GetUpdateTest, RefusesWhatDoesNotExist) {
  CreateScene();
  EventLog log;
  v1::GetUpdateRequest request = Request();
  request.set_scene("no-such-scene");
  EXPECT_EQ(Update(request, log).error_code(), grpc::StatusCode::NOT_FOUND);
  request = Request();
  request.mutable_view()->set_encoding(v1::ENCODING_CONTROL_NETS);
  EXPECT_EQ(Update(request, log).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  request = Request();
  request.mutable_view()->set_max_points(3);
  EXPECT_EQ(Update(request, log).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(GetUpdateTest, DrainSaysGoawayToWhoWaitsForARevision) {
  CreateScene();
  v1::GetUpdateRequest request = Request();
  request.set_min_revision(1'000);
  grpc::ClientContext context;
  const auto reader = scenes_->GetUpdate(&context, request);
  v1::SceneEvent event;
  ASSERT_TRUE(reader->Read(&event)) << "the lattice comes at once";

  std::thread drain([this] { server_->Drain(); });
  std::vector<v1::Goaway> goaways;
  while (reader->Read(&event)) {
    if (event.has_goaway()) goaways.push_back(event.goaway());
  }
  const grpc::Status status = reader->Finish();
  drain.join();

  EXPECT_TRUE(status.ok()) << status.error_message();
  ASSERT_EQ(goaways.size(), 1u);
  EXPECT_EQ(goaways[0].reason(), v1::GOAWAY_REASON_DRAINING);
  EXPECT_EQ(goaways[0].retry_after().seconds(), 1);
}

}  // namespace
}  // namespace latticed::testing
