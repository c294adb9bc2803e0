// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Events of views without positions: no grid, and the lattice of an update's very revision before its end.
#include "tests/server/engine/watch/next_event_fixture.h"

namespace latticed::testing {
namespace {

using ::testing::ElementsAre;

class NextEventOfPatchesTest : public NextEventTest {
 protected:
  static std::shared_ptr<const Snapshot> OfPatches(uint64_t revision,
                                                   std::vector<uint64_t> revisions,
                                                   uint64_t box = 1) {
    const auto made = MakeSnapshot(revision, std::move(revisions), box);
    auto snapshot = std::make_shared<Snapshot>();
    snapshot->revision = revision;
    snapshot->structure_id = 1;
    snapshot->box.id = box;
    snapshot->view = {{.format = VertexFormat::kEdgeBounds}, Encoding::kPatches};
    snapshot->chunks = made->chunks.Share();
    return snapshot;
  }
  // The scene, and its newest snapshot, whose revision may be lower.
  void Be(uint64_t revision, std::shared_ptr<const Snapshot> snapshot) {
    head_->revision = revision;
    offer_.snapshot = std::move(snapshot);
  }
  // The log no longer has what the client lacks.
  void ForgetDeltas() { offer_.deltas = {.complete = false, .deltas = {}}; }
};

// No event names a grid, and a new box changes nothing.
TEST_F(NextEventOfPatchesTest, HaveNoGrid) {
  Be(0, OfPatches(0, {0, 0}, 1));
  EXPECT_THAT(Drain(),
              ElementsAre("lattice 0", "topology t", "begin 1@0", "batch 0", "batch 1", "end 1@0"));
  Acknowledge(client_, 1);
  Be(1, OfPatches(1, {0, 1}, 2));
  offer_.deltas.deltas.push_back(MakeDelta(1));
  EXPECT_THAT(Drain(), ElementsAre("delta 1", "begin 2@1", "batch 1", "end 2@1"));
}

// An edit came between the opening of the stream and its first event.
TEST_F(NextEventOfPatchesTest, TheFirstUpdateIsNotOlderThanTheFirstLattice) {
  Be(1, OfPatches(0, {0, 0}));
  EXPECT_THAT(Drain(), ElementsAre("lattice 1"));
  EXPECT_TRUE(WantsNewer(client_, offer_.snapshot.get()));

  Be(1, OfPatches(1, {0, 1}));
  EXPECT_THAT(Drain(), ElementsAre("topology t", "begin 1@1", "batch 0", "batch 1", "end 1@1"));
}

TEST_F(NextEventOfPatchesTest, AnUpdateMayBeOlderThanTheLatestDelta) {
  Be(0, OfPatches(0, {0, 0}));
  Drain();
  Be(2, OfPatches(1, {0, 1}));
  offer_.deltas.deltas = {MakeDelta(1), MakeDelta(2)};

  EXPECT_THAT(Drain(), ElementsAre("delta 1", "delta 2", "begin 2@1", "batch 1", "end 2@1"));
}

TEST_F(NextEventOfPatchesTest, AnUpdateWhoseLatticeWasSkippedIsBegunAgain) {
  Be(0, OfPatches(0, {0, 0}));
  Drain();
  Acknowledge(client_, 1);
  Be(1, OfPatches(1, {1, 1}));
  offer_.deltas.deltas = {MakeDelta(1)};
  EXPECT_EQ(Text(Next(client_, offer_)), "delta 1");
  offer_.deltas = {};
  EXPECT_EQ(Text(Next(client_, offer_)), "begin 2@1");
  EXPECT_FALSE(LacksLattice(client_, *offer_.snapshot));
  head_->revision = 9;
  ForgetDeltas();
  EXPECT_EQ(Text(Next(client_, offer_)), "lattice 9");
  offer_.deltas = {};

  EXPECT_TRUE(LacksLattice(client_, *offer_.snapshot));
  DropUpdate(client_);  // as the watcher does then
  EXPECT_THAT(Drain(), ElementsAre());
  Be(9, OfPatches(9, {9, 1}));
  EXPECT_THAT(Drain(), ElementsAre("begin 3@9 restart", "batch 0", "batch 1", "end 3@9"));
}

// The snapshot of several lattices, as one that the tests tell by its number of control points.
class NextEventOfSumsTest : public NextEventOfPatchesTest {
 protected:
  static std::shared_ptr<const Snapshot> OfSum(uint64_t revision, std::vector<uint64_t> revisions,
                                               size_t points, uint64_t structure = 1) {
    auto snapshot = std::make_shared<Snapshot>();
    const auto made = OfPatches(revision, std::move(revisions));
    snapshot->revision = revision;
    snapshot->structure_id = structure;
    snapshot->view = made->view;
    snapshot->chunks = made->chunks.Share();
    snapshot->summed_points = std::make_shared<const std::vector<Vec3d>>(points);
    return snapshot;
  }
};

// Also where no chunk has changed.
TEST_F(NextEventOfSumsTest, EveryUpdateHasTheSum) {
  Be(0, OfSum(0, {0}, 10));
  EXPECT_THAT(Drain(),
              ElementsAre("lattice 0", "topology t", "begin 1@0", "sum 10", "batch 0", "end 1@0"));
  Acknowledge(client_, 1);
  Be(1, OfSum(1, {0}, 11));
  EXPECT_THAT(Drain(), ElementsAre("begin 2@1", "sum 11 since 10", "end 2@1"));
  Acknowledge(client_, 2);
  Be(2, OfSum(2, {2}, 12, /*structure=*/2));
  EXPECT_THAT(Drain(), ElementsAre("begin 3@2", "sum 12", "batch 0", "end 3@2"));
}

// The client has the sum of the update that was dropped.
TEST_F(NextEventOfSumsTest, ADroppedUpdateKeepsItsSum) {
  Be(0, OfSum(0, {0}, 10));
  Drain();
  Acknowledge(client_, 1);
  Be(1, OfSum(1, {1}, 11));
  EXPECT_EQ(Text(Next(client_, offer_)), "begin 2@1");
  EXPECT_EQ(Text(Next(client_, offer_)), "sum 11 since 10");
  DropUpdate(client_);
  Be(2, OfSum(2, {2}, 12));
  EXPECT_THAT(Drain(), ElementsAre("begin 3@2 restart", "sum 12 since 11", "batch 0", "end 3@2"));
}

// The sum is not kept for a client that has points again: patches later begin with a whole one.
TEST_F(NextEventOfSumsTest, PointsLetTheSumGo) {
  Be(0, OfSum(0, {0}, 10));
  Drain();
  Acknowledge(client_, 1);
  EXPECT_NE(client_.sum, nullptr);
  offer_.snapshot = MakeSnapshot(0, {0});
  EXPECT_THAT(Drain(), ElementsAre("quantisation 1", "begin 2@0", "batch 0", "end 2@0"));
  Acknowledge(client_, 2);
  EXPECT_EQ(client_.sum, nullptr);

  Be(1, OfSum(1, {1}, 11));
  EXPECT_THAT(Drain(), ElementsAre("begin 3@1", "sum 11", "batch 0", "end 3@1"));
}

TEST_F(NextEventOfSumsTest, NoUpdateLacksItsLattice) {
  Be(1, OfSum(0, {0}, 10));
  EXPECT_THAT(Drain(),
              ElementsAre("lattice 1", "topology t", "begin 1@0", "sum 10", "batch 0", "end 1@0"));
}

// Points are right at any lattice.
TEST_F(NextEventOfPatchesTest, PointsDoNotWaitForALattice) {
  head_->revision = 1;
  offer_.snapshot = MakeSnapshot(0, {0});
  EXPECT_THAT(Drain(), ElementsAre("lattice 1", "topology t", "quantisation 1", "begin 1@0",
                                   "batch 0", "end 1@0"));
}

}  // namespace
}  // namespace latticed::testing
