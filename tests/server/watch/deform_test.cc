// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// SceneService.Deform through a stub.
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

using DeformTest = SceneStreamTest;
using LargeDeformTest = StreamTest;

TEST_F(DeformTest, OpensWithHelloLatticeTopologyAndAFullUpdate) {
  DeformClient client(*scenes_, Watch());

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
  DeformClient client(*scenes_, Watch());
  client.ReadUntilRevision(0);
  const auto before = client.log.chunks;

  v1::EditBatch batch = Move(9, 62, 0.2);
  batch.clear_scene();
  batch.clear_editor_id();  // the stream's are used
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
  DeformClient client(*scenes_, Watch());
  client.ReadUntilRevision(0);

  for (uint64_t i = 1; i <= 100; ++i) {
    ASSERT_TRUE(client.Send(Move(i, 62, 0.001)));
    client.ReadUntilRevision(i);
    ASSERT_EQ(client.log.results.size(), i);
  }
}

TEST_F(DeformTest, HalfCloseEndsOkAfterTheUpdateThatHoldsTheLastEdit) {
  DeformClient client(*scenes_, Watch());
  for (uint64_t i = 1; i <= 20; ++i) ASSERT_TRUE(client.Send(Move(i, 62, 0.01)));
  client.HalfClose();

  EXPECT_OK(client.Finish());
  EXPECT_EQ(client.log.results.size(), 20u);
  ASSERT_FALSE(client.log.ends.empty());
  EXPECT_EQ(client.log.ends.back().revision(), 20u);
  EXPECT_EQ(client.log.ends.back().applied_sequence(), 20u);
}

TEST_F(DeformTest, HalfCloseNeedsNoAcknowledgements) {
  v1::WatchRequest watch = Watch();
  watch.set_max_unacked_updates(1);
  DeformClient client(*scenes_, watch);
  client.ReadUntilRevision(0);
  ASSERT_TRUE(client.Send(Move(1, 62, 0.01)));
  client.HalfClose();

  EXPECT_TRUE(client.Finish().ok());
  EXPECT_EQ(client.log.ends.back().revision(), 1u);
}

TEST_F(DeformTest, NoUpdateIsBegunBeyondTheUnacknowledged) {
  v1::WatchRequest watch = Watch();
  watch.set_max_unacked_updates(1);
  DeformClient client(*scenes_, watch);
  client.ReadUntilRevision(0);
  for (uint64_t i = 1; i <= 3; ++i) {
    ASSERT_TRUE(client.Send(Move(i, 62, 0.01)));
    client.ReadUntil([&] { return client.log.results.size() == i && client.log.deltas == i; });
  }
  EXPECT_EQ(client.log.begins.size(), 1u) << "of the first edits";

  ASSERT_TRUE(client.Ack(1));
  client.ReadUntil([&] { return client.log.ends.size() == 2; });
}

TEST_F(DeformTest, AnAcknowledgementOfTheFutureEndsTheStream) {
  DeformClient client(*scenes_, Watch());
  client.ReadUntilRevision(0);

  ASSERT_TRUE(client.Ack(7));

  EXPECT_THAT(client.Finish(), StatusIs(absl::StatusCode::kInvalidArgument,
                                        ::testing::HasSubstr("acked_update_id")));
}

TEST_F(LargeDeformTest, ASlowReaderSkipsRevisions) {
  CreateScene(48);
  DeformClient client(*scenes_, Watch());
  client.ReadUntilRevision(0);

  // Nothing is read while 200 edits come from another client.
  for (uint64_t i = 1; i <= 200; ++i) ASSERT_OK(Apply(Move(i, 62, 0.001, "bob")));
  client.ReadUntilRevision(200);

  EXPECT_LT(client.log.ends.size(), 150u) << "the latest wins";
}

TEST_F(DeformTest, TwoWatchersGetTheSameBytes) {
  DeformClient first(*scenes_, Watch("alice")), second(*scenes_, Watch("bob"));
  ASSERT_TRUE(first.Send(Move(1, 62, 0.1)));

  first.ReadUntilRevision(1);
  second.ReadUntilRevision(1);

  EXPECT_EQ(first.log.chunks, second.log.chunks);
  EXPECT_EQ(second.log.ends.back().applied_sequence(), 0u) << "bob has edited nothing";
}

TEST_F(DeformTest, KnotInsertionResendsLatticeTopologyAndAllChunks) {
  DeformClient client(*scenes_, Watch());
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
  DeformClient client(*scenes_, Watch());
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
  DeformClient client(*scenes_, Watch());
  client.ReadUntilRevision(0);
  ASSERT_TRUE(client.SetPaused(true));
  for (uint64_t i = 1; i <= 3; ++i) {
    ASSERT_TRUE(client.Send(Move(i, 62, 0.01)));
    client.ReadUntil([&] { return client.log.results.size() == i && client.log.deltas == i; });
  }
  EXPECT_EQ(client.log.begins.size(), 1u);

  ASSERT_TRUE(client.SetPaused(false));
  client.ReadUntilRevision(3);
  EXPECT_EQ(client.log.begins.size(), 2u) << "the newest alone";
}

TEST_F(DeformTest, ACancelledStreamLeavesTheServerInOrder) {
  for (int i = 0; i < 20; ++i) {
    DeformClient client(*scenes_, Watch());
    if (i % 2 == 0) {
      ASSERT_TRUE(client.Read());
    }
    client.Cancel();
    EXPECT_THAT(client.Finish(), StatusIs(absl::StatusCode::kCancelled));
  }

  DeformClient client(*scenes_, Watch());
  client.ReadUntilRevision(0);
}

TEST_F(DeformTest, TheFirstMessageMustOpenTheStream) {
  DeformClient early(*scenes_);
  ASSERT_TRUE(early.Send(Move(1, 62, 0.1)));
  EXPECT_THAT(early.Finish(), StatusIs(absl::StatusCode::kFailedPrecondition));

  DeformClient silent(*scenes_);
  silent.HalfClose();
  EXPECT_THAT(silent.Finish(), StatusIs(absl::StatusCode::kFailedPrecondition));

  DeformClient twice(*scenes_, Watch());
  twice.Open(Watch());
  EXPECT_THAT(twice.Finish(), StatusIs(absl::StatusCode::kInvalidArgument));

  v1::WatchRequest watch = Watch();
  watch.set_max_unacked_updates(101);
  DeformClient unlimited(*scenes_, watch);
  EXPECT_THAT(unlimited.Finish(), StatusIs(absl::StatusCode::kInvalidArgument));
}

}  // namespace
}  // namespace latticed::testing
