// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// SceneService.Deform through a stub.
#include <thread>

#include "absl/time/clock.h"
#include "tests/server/stream_support.h"

namespace latticed::testing {
namespace {

using DeformTest = StreamTest;

TEST_F(DeformTest, OpensWithHelloLatticeTopologyAndAFullUpdate) {
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());

  client.ReadUntilRevision(0);

  ASSERT_GE(client.log.events.size(), 6u);
  EXPECT_TRUE(client.log.events[0].has_hello());
  EXPECT_TRUE(client.log.events[1].has_lattice_state());
  EXPECT_TRUE(client.log.events[2].has_topology());
  EXPECT_TRUE(client.log.events[3].has_quantisation());
  EXPECT_TRUE(client.log.events[4].has_update_begin());
  EXPECT_FALSE(client.log.hello.resumed());
  EXPECT_EQ(client.log.hello.heartbeat().seconds(), absl::ToInt64Seconds(kHeartbeat));
  const v1::Topology& topology = client.log.topologies[0];
  EXPECT_EQ(topology.point_count(), topology.patch_count() * 15);
  EXPECT_EQ(topology.triangle_count(), topology.patch_count() * 16);
  uint64_t patches = 0, chunks = 0;
  for (const v1::ChunkRun& run : topology.chunk_runs()) {
    patches += uint64_t{run.chunk_count()} * run.patches_per_chunk();
    chunks += run.chunk_count();
  }
  EXPECT_EQ(patches, topology.patch_count());
  EXPECT_EQ(client.log.chunks.size(), chunks);
  size_t bytes = 0;
  for (const auto& [index, data] : client.log.chunks) bytes += data.size();
  EXPECT_EQ(bytes, topology.point_count() * (6 + 2)) << "12-bit positions, 8-bit facet normals";
  EXPECT_TRUE(client.log.ends[0].full_detail());
  EXPECT_LE(client.log.ends[0].resume_token().size(), 4096u);
}

TEST_F(DeformTest, AnEditIsAnsweredAndSeen) {
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());
  client.ReadUntilRevision(0);
  const auto before = client.log.chunks;

  v1::EditBatch batch = Move(9, 62, 0.2);
  batch.clear_scene();
  batch.clear_editor_id();  // the stream's own
  ASSERT_TRUE(client.Send(batch));
  client.ReadUntilRevision(1);

  ASSERT_EQ(client.log.results.size(), 1u);
  EXPECT_EQ(client.log.results[0].status().code(), 0);
  EXPECT_EQ(client.log.results[0].sequence(), 9u);
  EXPECT_EQ(client.log.results[0].revision(), 1u);
  EXPECT_NEAR(client.log.results[0].largest_move(), 0.2, 1e-12);
  EXPECT_EQ(client.log.deltas, 1u);
  EXPECT_EQ(client.log.ends.back().applied_sequence(), 9u);
  EXPECT_NE(client.log.chunks, before);
}

TEST_F(DeformTest, TheAnswerComesBeforeTheUpdateThatHoldsTheEdit) {
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());
  client.ReadUntilRevision(0);

  for (uint64_t i = 1; i <= 100; ++i) {
    ASSERT_TRUE(client.Send(Move(i, 62, 0.001)));
    client.ReadUntilRevision(i);
    ASSERT_EQ(client.log.results.size(), i);
  }
}

TEST_F(DeformTest, ARefusedEditDoesNotEndTheStream) {
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());
  client.ReadUntilRevision(0);

  v1::EditBatch stale = Move(1, 62, 0.2);
  stale.set_structure_id(77);
  ASSERT_TRUE(client.Send(stale));
  ASSERT_TRUE(client.Send(Move(2, 999'999, 0.2)));
  v1::EditBatch elsewhere = Move(3, 62, 0.2);
  elsewhere.set_scene("another-scene");
  ASSERT_TRUE(client.Send(elsewhere));
  ASSERT_TRUE(client.Send(Move(4, 62, 0.2)));
  client.ReadUntilRevision(1);

  ASSERT_EQ(client.log.results.size(), 4u);
  EXPECT_EQ(client.log.results[0].status().code(), grpc::StatusCode::ABORTED);
  EXPECT_GT(client.log.results[0].status().details_size(), 0);
  EXPECT_EQ(client.log.results[1].status().code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(client.log.results[2].status().code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(client.log.results[3].status().code(), 0);
  EXPECT_EQ(client.log.ends.back().revision(), 1u) << "refused edits make no revision";
}

TEST_F(DeformTest, HalfCloseEndsOkAfterTheUpdateThatHoldsTheLastEdit) {
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());
  for (uint64_t i = 1; i <= 20; ++i) ASSERT_TRUE(client.Send(Move(i, 62, 0.01)));
  client.HalfClose();

  const grpc::Status status = client.Finish();

  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(client.log.results.size(), 20u);
  ASSERT_FALSE(client.log.ends.empty());
  EXPECT_EQ(client.log.ends.back().revision(), 20u);
  EXPECT_EQ(client.log.ends.back().applied_sequence(), 20u);
}

TEST_F(DeformTest, HalfCloseNeedsNoAcknowledgements) {
  CreateScene();
  DeformClient client(*scenes_);
  v1::WatchRequest watch = Watch();
  watch.set_max_unacked_updates(1);
  client.Open(watch);
  client.ReadUntilRevision(0);
  ASSERT_TRUE(client.Send(Move(1, 62, 0.01)));
  client.HalfClose();

  EXPECT_TRUE(client.Finish().ok());
  EXPECT_EQ(client.log.ends.back().revision(), 1u);
}

TEST_F(DeformTest, NoUpdateIsBegunBeyondTheUnacknowledged) {
  CreateScene();
  DeformClient client(*scenes_);
  v1::WatchRequest watch = Watch();
  watch.set_max_unacked_updates(1);
  client.Open(watch);
  client.ReadUntilRevision(0);
  ASSERT_TRUE(client.Send(Move(1, 62, 0.01)));
  client.ReadUntil([&] { return client.log.results.size() == 1; });
  absl::SleepFor(absl::Milliseconds(100));
  EXPECT_EQ(client.log.begins.size(), 1u);

  ASSERT_TRUE(client.Ack(1));
  client.ReadUntilRevision(1);
  EXPECT_EQ(client.log.begins.size(), 2u);
}

TEST_F(DeformTest, AnAcknowledgementOfTheFutureEndsTheStream) {
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());
  client.ReadUntilRevision(0);

  ASSERT_TRUE(client.Ack(7));

  const grpc::Status status = client.Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_NE(status.error_message().find("acked_update_id"), std::string::npos);
}

TEST_F(DeformTest, ASlowReaderSkipsRevisions) {
  CreateScene(48);
  DeformClient client(*scenes_);
  client.Open(Watch());
  client.ReadUntilRevision(0);

  // Nothing is read while 200 edits come from elsewhere.
  for (uint64_t i = 1; i <= 200; ++i) ASSERT_TRUE(Apply(Move(i, 62, 0.001, "bob")).ok());
  client.ReadUntilRevision(200);

  EXPECT_LT(client.log.ends.size(), 150u) << "the latest wins";
}

TEST_F(DeformTest, TwoWatchersGetTheSameBytes) {
  CreateScene();
  DeformClient first(*scenes_), second(*scenes_);
  first.Open(Watch("alice"));
  second.Open(Watch("bob"));
  ASSERT_TRUE(first.Send(Move(1, 62, 0.1)));

  first.ReadUntilRevision(1);
  second.ReadUntilRevision(1);

  EXPECT_EQ(first.log.chunks, second.log.chunks);
  EXPECT_EQ(second.log.ends.back().applied_sequence(), 0u) << "bob has edited nothing";
}

TEST_F(DeformTest, KnotInsertionResendsLatticeTopologyAndAllChunks) {
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());
  client.ReadUntilRevision(0);
  v1::EditBatch batch = Move(1, 0, 0);
  batch.mutable_edits(0)->mutable_insert_knot()->set_axis(v1::LATTICE_AXIS_U);
  batch.mutable_edits(0)->mutable_insert_knot()->set_value(0.3);

  ASSERT_TRUE(client.Send(batch));
  client.ReadUntilRevision(1);

  ASSERT_EQ(client.log.results.size(), 1u);
  EXPECT_EQ(client.log.results[0].status().message(), "");
  EXPECT_EQ(client.log.results[0].structure_id(), structure_id_ + 1);
  EXPECT_EQ(client.log.lattice.lattice().size().u(), 6);
  EXPECT_EQ(client.log.lattice.lattice().control_points_size(), 6 * 5 * 5 * 3);
  ASSERT_EQ(client.log.topologies.size(), 2u);
  EXPECT_NE(client.log.topologies[0].topology_id(), client.log.topologies[1].topology_id());
}

TEST_F(DeformTest, AViewControlChangesTheView) {
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());
  client.ReadUntilRevision(0);
  v1::DeformRequest request;
  request.mutable_control()->mutable_view()->set_segments(6);
  request.mutable_control()->mutable_view()->set_encoding(v1::ENCODING_RAW);

  ASSERT_TRUE(client.Send(request));
  client.ReadUntil([&] { return client.log.ends.size() == 2; });

  EXPECT_EQ(client.log.begins.back().view().segments(), 6);
  EXPECT_EQ(client.log.topologies.back().segments(), 6);
  EXPECT_EQ(client.log.quantisations.back().bits(), 0);
  EXPECT_EQ(client.log.quantisations.back().step(), 0);
}

TEST_F(DeformTest, APausedWatcherGetsItsEditsAndItsCageButNoUpdate) {
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());
  client.ReadUntilRevision(0);
  v1::DeformRequest pause;
  pause.mutable_control()->set_pause(true);
  ASSERT_TRUE(client.Send(pause));
  ASSERT_TRUE(client.Send(Move(1, 62, 0.01)));
  client.ReadUntil([&] { return client.log.results.size() == 1 && client.log.deltas == 1; });
  absl::SleepFor(absl::Milliseconds(100));
  EXPECT_EQ(client.log.begins.size(), 1u);

  pause.mutable_control()->set_pause(false);
  ASSERT_TRUE(client.Send(pause));
  client.ReadUntilRevision(1);
}

TEST_F(DeformTest, HeartbeatsComeAndASilentWatcherIsPausedNotKilled) {
  StartServer(absl::Milliseconds(100));
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());

  client.ReadUntil([&] { return client.log.heartbeats >= 6; });
  ASSERT_TRUE(Apply(Move(1, 62, 0.01, "bob")).ok());
  const size_t heartbeats = client.log.heartbeats, updates = client.log.begins.size();
  client.ReadUntil([&] { return client.log.heartbeats >= heartbeats + 3; });
  EXPECT_EQ(client.log.begins.size(), updates) << "silent, so paused";

  // Heard at every heartbeat: the update may take longer than silence may.
  v1::DeformRequest alive;
  alive.mutable_heartbeat();
  const auto caught_up = [&] {
    return !client.log.ends.empty() && client.log.ends.back().revision() == 1;
  };
  while (!caught_up()) {
    ASSERT_TRUE(client.Send(alive));
    const size_t before = client.log.heartbeats;
    ASSERT_NO_FATAL_FAILURE(
        client.ReadUntil([&] { return caught_up() || client.log.heartbeats > before; }));
  }
}

TEST_F(DeformTest, AResumedStreamGetsWhatChangedSince) {
  CreateScene(32);
  v1::WatchRequest watch = Watch();
  {
    DeformClient client(*scenes_);
    client.Open(watch);
    client.ReadUntilRevision(0);
    watch.set_resume_token(client.log.ends.back().resume_token());
  }
  ASSERT_TRUE(Apply(Move(1, 0, -0.01, "bob")).ok());

  DeformClient client(*scenes_);
  client.Open(watch);
  client.ReadUntilRevision(1);
  EXPECT_TRUE(client.log.hello.resumed());
  const auto chunks = static_cast<uint32_t>(client.log.topologies[0].patch_count() / 32);
  EXPECT_LT(client.log.begins[0].chunk_count(), chunks);

  watch.set_resume_token("no token of ours");
  DeformClient stranger(*scenes_);
  stranger.Open(watch);
  stranger.ReadUntilRevision(1);
  EXPECT_FALSE(stranger.log.hello.resumed());
  EXPECT_GE(stranger.log.begins[0].chunk_count(), chunks);
}

TEST_F(DeformTest, ACancelledStreamLeavesTheServerInOrder) {
  CreateScene();
  for (int i = 0; i < 20; ++i) {
    DeformClient client(*scenes_);
    client.Open(Watch());
    if (i % 2 == 0) {
      ASSERT_TRUE(client.Read());
    }
    client.Cancel();
    EXPECT_EQ(client.Finish().error_code(), grpc::StatusCode::CANCELLED);
  }

  DeformClient client(*scenes_);
  client.Open(Watch());
  client.ReadUntilRevision(0);
}

TEST_F(DeformTest, TheFirstMessageMustOpenTheStream) {
  CreateScene();
  DeformClient early(*scenes_);
  ASSERT_TRUE(early.Send(Move(1, 62, 0.1)));
  EXPECT_EQ(early.Finish().error_code(), grpc::StatusCode::FAILED_PRECONDITION);

  DeformClient silent(*scenes_);
  silent.HalfClose();
  EXPECT_EQ(silent.Finish().error_code(), grpc::StatusCode::FAILED_PRECONDITION);

  DeformClient twice(*scenes_);
  twice.Open(Watch());
  twice.Open(Watch());
  EXPECT_EQ(twice.Finish().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(DeformTest, BadOpeningsNameTheField) {
  CreateScene();
  const auto status_of = [this](const v1::WatchRequest& watch) {
    DeformClient client(*scenes_);
    client.Open(watch);
    return client.Finish();
  };
  v1::WatchRequest watch = Watch();
  watch.set_scene("no-such-scene");
  EXPECT_EQ(status_of(watch).error_code(), grpc::StatusCode::NOT_FOUND);

  watch = Watch();
  watch.mutable_view()->set_segments(33);
  EXPECT_EQ(status_of(watch).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_NE(status_of(watch).error_message().find("view.segments"), std::string::npos);

  watch = Watch();
  watch.set_max_unacked_updates(101);
  EXPECT_EQ(status_of(watch).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(DeformTest, ADeletedSceneEndsItsStreams) {
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());
  client.ReadUntilRevision(0);
  grpc::ClientContext context;
  v1::DeleteSceneRequest request;
  request.set_scene(kScene);
  v1::DeleteSceneResponse response;
  ASSERT_TRUE(scenes_->DeleteScene(&context, request, &response).ok());

  EXPECT_EQ(client.Finish().error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(DeformTest, DrainSaysGoawayAndEndsOk) {
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());
  client.ReadUntilRevision(0);

  std::thread drain([this] { server_->Drain(); });
  const grpc::Status status = client.Finish();
  drain.join();

  EXPECT_TRUE(status.ok()) << status.error_message();
  ASSERT_EQ(client.log.goaways.size(), 1u);
  EXPECT_EQ(client.log.goaways[0].reason(), v1::GOAWAY_REASON_DRAINING);
}

}  // namespace
}  // namespace latticed::testing
