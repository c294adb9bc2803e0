// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which event a watcher is sent next: without scene, backend, threads or clocks.
#include "server/engine/watch/next_event.h"

#include "core/base/limits.h"
#include "tests/server/engine/watch/next_event_fixture.h"

namespace latticed::testing {
namespace {

using ::testing::ElementsAre;

TEST_F(NextEventTest, TheFirstUpdateHoldsEverythingInOrder) {
  EXPECT_THAT(Drain(), ElementsAre("lattice 0")) << "before there is a snapshot";
  offer_.snapshot = MakeSnapshot(0, {0, 0, 0});

  EXPECT_THAT(Drain(), ElementsAre("topology t", "quantisation 1", "begin 1@0", "batch 0",
                                   "batch 1 2", "end 1@0"));
}

TEST_F(NextEventTest, AnUpdateHoldsTheChunksThatChangedSinceTheLast) {
  HaveFirstUpdate();
  Edit(2, MakeSnapshot(2, {0, 1}));
  EXPECT_THAT(Drain(), ElementsAre("begin 2@2", "batch 1", "end 2@2"));

  Edit(3, MakeSnapshot(3, {0, 1}));
  EXPECT_THAT(Drain(), ElementsAre("begin 3@3", "end 3@3")) << "covered, without a chunk";
}

// Chunks of a view with a tolerance.
std::shared_ptr<const Snapshot> MakeAdaptive(uint64_t revision, std::vector<uint64_t> revisions,
                                             std::vector<std::vector<uint16_t>> patterns) {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->revision = revision;
  snapshot->structure_id = 1;
  snapshot->view.spec.tolerance = 1;
  snapshot->certified_error = 0.75;
  snapshot->box.id = 1;
  snapshot->chunks = ChunkTable(revisions.size());
  const auto codes = std::make_shared<std::vector<uint16_t>>();
  for (size_t c = 0; c < revisions.size(); ++c) {
    snapshot->chunks.Set(
        c, {revisions[c], MakeSharedBytes(std::vector<uint8_t>(kChunkBytes)), VertexDigest()});
    patterns[c].resize(limits::kPatchesPerChunk, patterns[c].back());
    codes->insert(codes->end(), patterns[c].begin(), patterns[c].end());
  }
  snapshot->patterns = {codes, *codes};
  return snapshot;
}

TEST_F(NextEventTest, PatternsComeOnceBeforeTheChunksThatUseThem) {
  offer_.snapshot = MakeAdaptive(0, {0, 0, 0}, {{9, 0, 9}, {73, 0}, {512, 9}});
  EXPECT_THAT(Drain(),
              ElementsAre("lattice 0", "topology t", "quantisation 1", "begin 1@0", "patterns 0 9",
                          "batch 0", "patterns 73 512", "batch 1 2", "end 1@0"));

  Acknowledge(client_, client_.last_update_id);
  Edit(1, MakeAdaptive(1, {1, 1, 0}, {{9, 0, 9}, {73, 1}, {512, 9}}));
  EXPECT_THAT(Drain(), ElementsAre("begin 2@1", "batch 0", "patterns 1", "batch 1", "end 2@1"));
}

// Until its first snapshot, a view knows of edits alone, and not where another tolerance changed patterns.
TEST_F(NextEventTest, ASurfaceFromBeforeTheViewCountsIfItsPatternsHadTheSameTolerance) {
  struct Case {
    uint64_t had_revision;
    double had_tolerance;
    std::vector<std::string> sent;
  };
  const Case cases[] = {{3, 0.5, {"begin 1@7", "patterns 9", "batch 1", "end 1@7"}},
                        {3, 0.25, {"begin 1@7", "patterns 9", "batch 0", "batch 1", "end 1@7"}},
                        {5, 0.25, {"begin 1@7", "end 1@7"}},
                        {6, 0.25, {"begin 1@7", "end 1@7"}}};
  for (const Case& c : cases) {
    const auto snapshot = MakeAdaptive(7, {2, 4}, {{9}, {9}});
    auto now = std::const_pointer_cast<Snapshot>(snapshot);
    now->first = {.revision = 5, .curvature_tolerance = 0.5};
    now->curvature_tolerance = 0.25;
    client_ = ClientState();
    client_.lattice_revision = 7;
    client_.topology_id = "t";
    client_.quantisation = {1, snapshot->view};
    client_.had = ClientSurface{.view = snapshot->view,
                                .structure_id = 1,
                                .quantisation_id = 1,
                                .revision = c.had_revision,
                                .curvature_tolerance = c.had_tolerance};
    Edit(7, snapshot);
    EXPECT_EQ(Drain(), c.sent) << c.had_revision << ", " << c.had_tolerance;
    EXPECT_EQ(client_.had->curvature_tolerance, 0.25);
  }
}

TEST_F(NextEventTest, ManyPatternsComeInSeveralEvents) {
  offer_.snapshot = MakeAdaptive(0, {0}, {{0, 1, 2, 3, 4, 5, 8, 9, 10, 11}});

  EXPECT_THAT(Drain(),
              ElementsAre("lattice 0", "topology t", "quantisation 1", "begin 1@0",
                          "patterns 0 1 2 3 4 5 8 9", "patterns 10 11", "batch 0", "end 1@0"));
}

TEST_F(NextEventTest, ADroppedUpdateLeavesThePatternsThatCame) {
  offer_.snapshot = MakeAdaptive(0, {0, 0}, {{1}, {2}});
  while (Text(Next(client_, offer_)) != "patterns 1") continue;
  DropUpdate(client_);

  EXPECT_THAT(Drain(),
              ElementsAre("begin 2@0 restart", "batch 0", "patterns 2", "batch 1", "end 2@0"));
}

TEST_F(NextEventTest, AnUpdateEndsWithTheErrorOfItsSnapshot) {
  offer_.snapshot = MakeAdaptive(0, {0}, {{1}});
  NextEvent next;
  do {
    next = Next(client_, offer_);
  } while (!std::holds_alternative<UpdateEnds>(*next.event));

  EXPECT_EQ(std::get<UpdateEnds>(*next.event).certified_error, 0.75);
}

TEST_F(NextEventTest, ALatticeComesAsDeltasOrWhole) {
  struct Case {
    const char* what;
    EditLog::Deltas deltas;
    std::vector<std::string> events;
  };
  const Case cases[] = {
      {"two edits", {true, {MakeDelta(1), MakeDelta(2)}}, {"delta 1", "delta 2"}},
      {"the log does not reach back", {false, {}}, {"lattice 2"}},
      {"another structure", {true, {MakeDelta(2, 9)}}, {"lattice 2"}},
      {"nothing new", {true, {}}, {}},
  };
  head_->structure_id = 1;
  for (const Case& c : cases) {
    client_ = {};
    head_->revision = 0;
    offer_.deltas = {};
    EXPECT_EQ(Text(Next(client_, offer_)), "lattice 0");
    head_->revision = 2;
    offer_.deltas = c.deltas;
    EXPECT_EQ(Drain(), c.events) << c.what;
  }
}

TEST_F(NextEventTest, ANewBoxOrStructureSendsEverything) {
  HaveFirstUpdate();
  Edit(1, MakeSnapshot(1, {0, 1}, /*box=*/2));
  EXPECT_THAT(Drain(), ElementsAre("quantisation 2", "begin 2@1", "batch 0", "batch 1", "end 2@1"));

  Edit(2, MakeSnapshot(2, {0, 1}, 3, /*structure=*/2));
  offer_.topology_id = "u";
  EXPECT_THAT(Drain(), ElementsAre("topology u", "quantisation 3", "begin 3@2", "batch 0",
                                   "batch 1", "end 3@2"));
}

// Their headers alone would make a message too large.
TEST_F(NextEventTest, ABatchOfTinyChunksIsLimitedByTheirNumber) {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->structure_id = 1;
  snapshot->box.id = 1;
  snapshot->chunks = ChunkTable(20'000);
  for (size_t c = 0; c < 20'000; ++c) {
    snapshot->chunks.Set(c, {0, MakeSharedBytes(std::vector<uint8_t>(1)), {}});
  }
  offer_.snapshot = std::move(snapshot);
  std::vector<size_t> sizes;
  while (true) {
    const NextEvent next = Next(client_, offer_);
    if (!next.event.has_value()) break;
    if (std::holds_alternative<LatticeWhole>(*next.event)) offer_.deltas = {};
    if (const auto* batch = std::get_if<ChunkBatch>(&*next.event)) {
      sizes.push_back(batch->chunks.size());
    }
  }
  EXPECT_THAT(sizes, ElementsAre(8'192, 8'192, 3'616));
}

TEST_F(NextEventTest, WhatIsNotBegun) {
  HaveFirstUpdate();
  const auto newer = MakeSnapshot(5, {5, 5});
  struct Case {
    const char* what;
    void (*change)(ClientState&);
    bool wants_newer;
  };
  const Case cases[] = {
      {"paused", [](ClientState& c) { c.takes_updates = false; }, false},
      {"two are not acknowledged",
       [](ClientState& c) {
         c.unacked = {1, 2};
       },
       false},
      {"an edit waits for its answer", [](ClientState& c) { c.ceiling = 4; }, false},
      {"it is older than what is wanted", [](ClientState& c) { c.min_revision = 6; }, true},
      {"it is older than another watch had", [](ClientState& c) { c.had->revision = 6; }, true},
      {"the client has it", [](ClientState& c) { c.covered = c.had->revision = 5; }, true},
  };
  const ClientState before = client_;
  for (const Case& c : cases) {
    client_ = before;
    Edit(5, newer);
    c.change(client_);
    EXPECT_EQ(Text(Next(client_, offer_)), "-") << c.what;
    EXPECT_EQ(WantsNewer(client_, newer.get()), c.wants_newer) << c.what;
  }
  client_ = before;
  Edit(5, newer);
  client_.ceiling = 5;
  EXPECT_EQ(Text(Next(client_, offer_)), "begin 2@5");
}

TEST_F(NextEventTest, AcknowledgementsLetUpdatesBeginAndViewsRunAhead) {
  client_.max_unacked_updates = 1;
  offer_.snapshot = MakeSnapshot(0, {0, 0});
  Drain();
  EXPECT_FALSE(AcksAllow(client_, 1));
  EXPECT_FALSE(WantsNewer(client_, offer_.snapshot.get())) << "it would be old by then";
  Edit(1, MakeSnapshot(1, {1, 1}));
  EXPECT_EQ(Text(Next(client_, offer_)), "-");

  Acknowledge(client_, 1);
  EXPECT_EQ(Text(Next(client_, offer_)), "begin 2@1");
  EXPECT_FALSE(WantsNewer(client_, offer_.snapshot.get()));

  Acknowledge(client_, 2);
  EXPECT_TRUE(WantsNewer(client_, offer_.snapshot.get())) << "the one after it may begin";
}

TEST_F(NextEventTest, WithoutAcknowledgementsTheNextSnapshotIsWantedOnceOneIsSent) {
  client_.max_unacked_updates = 0;
  HaveFirstUpdate();
  Edit(1, MakeSnapshot(1, {1, 1}));

  EXPECT_EQ(Text(Next(client_, offer_)), "begin 2@1");

  EXPECT_TRUE(WantsNewer(client_, offer_.snapshot.get()));
}

TEST_F(NextEventTest, ARetiredUpdateIsBegunAgainFromWhatTheClientHadBefore) {
  HaveFirstUpdate();
  Edit(1, MakeSnapshot(1, {0, 1}));
  EXPECT_EQ(Text(Next(client_, offer_)), "begin 2@1");
  DropUpdate(client_);
  EXPECT_THAT(client_.unacked, ElementsAre()) << "nobody acknowledges what did not end";

  Edit(2, MakeSnapshot(2, {2, 1}));

  EXPECT_THAT(Drain(), ElementsAre("begin 3@2 restart", "batch 0", "batch 1", "end 3@2"));
}

TEST_F(NextEventTest, AnUpdateThatTheClientDoesNotKnowOfIsDroppedWithoutRestart) {
  offer_.snapshot = MakeSnapshot(0, {0});
  EXPECT_EQ(Text(Next(client_, offer_)), "lattice 0");
  EXPECT_EQ(Text(Next(client_, offer_)), "topology t");
  DropUpdate(client_);

  EXPECT_THAT(Drain(), ElementsAre("quantisation 1", "begin 1@0", "batch 0", "end 1@0"));
}

TEST_F(NextEventTest, AnotherDetailOfTheSameRevisionWaitsWhereThereIsANewerOne) {
  HaveFirstUpdate();
  auto coarse = std::make_shared<Snapshot>();
  coarse->view.spec.segments = 2;
  coarse->box.id = coarse->structure_id = 1;
  coarse->chunks = ChunkTable(1);
  Edit(3, coarse);
  EXPECT_EQ(Text(Next(client_, offer_)), "-") << "revision 0 in other detail, 3 is to come";

  head_->revision = 0;
  EXPECT_EQ(Text(Next(client_, offer_)), "quantisation 1") << "nothing newer is to come";
}

TEST_F(NextEventTest, MaxBytesPerSecondSpacesBatches) {
  const std::vector<uint64_t> many(60, 0);  // 2.4 MB
  offer_.snapshot = MakeSnapshot(0, many);
  offer_.asked.max_bytes_per_second = 1'000'000;
  EXPECT_EQ(Text(Next(client_, offer_)), "lattice 0");

  size_t bytes = 0;
  absl::Time now = kStart;
  for (int turn = 0; turn < 100'000 && !client_.covered.has_value(); ++turn) {
    offer_.now = now;
    const NextEvent next = Next(client_, offer_);
    if (!next.event.has_value()) {
      ASSERT_GT(next.wake_at, now);
      now = next.wake_at;
    } else if (const auto* batch = std::get_if<ChunkBatch>(&*next.event)) {
      bytes += batch->bytes;
      EXPECT_LE(batch->bytes, limits::kMaxChunkBatchBytes);
    }
  }

  ASSERT_EQ(bytes, 60 * kChunkBytes);
  // The first 0.25 seconds are free, and nothing waits for the last batch (at most 0.4 seconds).
  const double seconds = static_cast<double>(bytes) / 1e6;
  EXPECT_GT(now - kStart, absl::Seconds(seconds - 0.25 - 0.4));
  EXPECT_LT(now - kStart, absl::Seconds(seconds));
}

}  // namespace
}  // namespace latticed::testing
