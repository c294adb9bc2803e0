// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// SceneService.GetUpdate through a stub.
#include <thread>

#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

class GetUpdateTest : public SceneStreamTest {
 protected:
  // Starts a GetUpdate that waits for revision 2.
  void Wait(grpc::ClientContext& context) {
    auto request = For<v1::GetUpdateRequest>();
    request.set_min_revision(2);
    reader_ = scenes_->GetUpdate(&context, request);
  }
  bool Read() {
    v1::SceneEvent event;
    if (!reader_->Read(&event)) return false;
    log_.Take(event);
    return true;
  }
  absl::Status Finish() {
    while (Read()) continue;
    return client::FromGrpc(reader_->Finish());
  }

  std::unique_ptr<grpc::ClientReader<v1::SceneEvent>> reader_;
  EventLog log_;
};
using LargeUpdateTest = StreamTest;

TEST_F(GetUpdateTest, SendsLatticeTopologyQuantisationAndOneUpdateThenEnds) {
  EventLog log;

  ASSERT_OK(Update(For<v1::GetUpdateRequest>(), log));

  EXPECT_TRUE(log.events[0].has_lattice_state()) << "no hello";
  EXPECT_TRUE(log.events[1].has_topology());
  EXPECT_TRUE(log.events[2].has_quantisation());
  EXPECT_TRUE(log.events.back().has_update_end());
  EXPECT_EQ(log.ends.size(), 1u);
  EXPECT_EQ(log.begins[0].chunk_count(), log.chunks.size());
}

TEST_F(GetUpdateTest, HoldsEveryEditThatWasAnswered) {
  for (uint64_t i = 1; i <= 5; ++i) {
    ASSERT_OK(Apply(Move(i, 62, 0.01)));
    EventLog log;
    ASSERT_OK(Update(For<v1::GetUpdateRequest>(), log));
    EXPECT_EQ(log.ends[0].revision(), i);
  }
}

TEST_F(GetUpdateTest, WaitsForTheRevision) {
  grpc::ClientContext context;
  Wait(context);
  ASSERT_TRUE(Read()) << "the lattice comes at once";
  EXPECT_OK(Apply(Move(1, 62, 0.01)));
  EXPECT_OK(Apply(Move(2, 62, 0.01)));

  EXPECT_OK(Finish());
  EXPECT_GE(log_.ends.at(0).revision(), 2u);
}

TEST_F(GetUpdateTest, ADeadlineEndsTheWait) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(100));
  Wait(context);
  EXPECT_THAT(Finish(), StatusIs(absl::StatusCode::kDeadlineExceeded));
}

TEST_F(GetUpdateTest, DrainSaysGoawayToWhoWaitsForARevision) {
  grpc::ClientContext context;
  Wait(context);
  ASSERT_TRUE(Read());

  std::thread drain([this] { server_->Drain(); });
  EXPECT_OK(Finish());
  drain.join();

  ASSERT_EQ(log_.goaways.size(), 1u);
  EXPECT_EQ(log_.goaways[0].reason(), v1::GOAWAY_REASON_DRAINING);
  EXPECT_EQ(log_.goaways[0].retry_after().seconds(), 1);
}

TEST_F(LargeUpdateTest, BigUpdatesComeInMessagesBelowTheLimit) {
  CreateScene(32);
  auto request = For<v1::GetUpdateRequest>();
  request.mutable_view()->set_segments(16);
  request.mutable_view()->set_encoding(v1::ENCODING_RAW);
  EventLog log;

  ASSERT_OK(Update(request, log));

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

}  // namespace
}  // namespace latticed::testing
