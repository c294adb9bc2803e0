// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The stages of a view, on one thread: the test acts as the worker and controls the backend.
#include "server/engine/render/render_view.h"

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "absl/time/clock.h"
#include "core/base/error.h"
#include "core/ffd/plan/dirty_set.h"
#include "tests/server/engine/engine_support.h"
#include "tests/server/support/scripted_backend.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

using Stage = RenderView::Stage;

// Two control points in a lattice of 8^3, far apart and near the surface. An edit of one changes chunks
// that an edit of the other leaves alone.
constexpr uint32_t kCorner = 5 * 64 + 1 * 8 + 1;
constexpr uint32_t kOtherCorner = 2 * 64 + 6 * 8 + 6;

class RenderViewTest : public ::testing::Test {
 protected:
  RenderViewTest() = default;
  // On a fake device.
  explicit RenderViewTest(uint64_t device_bytes) : backend_(device_bytes) {}
  void SetUp() override { MakeScene(32, 4); }

  void MakeScene(int cells, int segments) {
    MakeScene(MakeSceneConfig("scene-" + std::to_string(cells), cells, 8), segments);
  }
  void MakeScene(SceneConfig config, int segments) {
    options_ = {.editor_id = "alice", .view = config.default_view, .max_unacked_updates = 0};
    options_.view.key.spec.segments = segments;
    auto scene = registry_.Create(std::move(config));
    ASSERT_OK(scene);
    scene_ = *scene;
    states_[0] = scene_->State();
  }
  std::unique_ptr<WatcherClient> Connect() {
    return std::make_unique<WatcherClient>(scene_, options_, &registry_.queue());
  }
  std::unique_ptr<WatcherClient> Watch() {
    auto client = Connect();
    client->RunToHead();
    return client;
  }
  Script& script() { return backend_.script(); }
  bool RunTurn() { return registry_.queue().RunNext(RenderQueue::Role::kAny); }

  void Move(uint32_t point, Vec3d offset = {0, 0, 0.05}) {
    ASSERT_OK(scene_->ApplyEdits(MoveBatch(*scene_, "alice", ++sequence_, {point}, offset)));
    states_[scene_->State()->revision] = scene_->State();
  }
  // Runs to the head. The chunks then equal, byte for byte, a new evaluation of that revision.
  void ExpectRightAtHead(WatcherClient& client) {
    client.RunToHead();
    const uint64_t revision = client.updates().back().end.revision;
    EXPECT_EQ(revision, scene_->State()->revision);
    const auto fresh = EvaluateAfresh(*states_.at(revision), *client.view());
    ASSERT_EQ(client.chunks().size(), fresh.size());
    for (size_t c = 0; c < fresh.size(); ++c) {
      EXPECT_TRUE(std::ranges::equal(client.chunks()[c].span(), fresh[c]))
          << "chunk " << c << " at revision " << revision;
    }
  }
  // Runs turns until the client's watch ends.
  void RunToEnd(WatcherClient& client) {
    while (client.status().ok()) {
      if (!client.Step()) RunTurn();
    }
  }

  ScriptedBackend backend_;
  const std::shared_ptr<MemoryBudget> budget_ = std::make_shared<MemoryBudget>(uint64_t{1} << 30);
  SceneRegistry registry_{&backend_, 0, {.memory = budget_}};
  std::shared_ptr<Scene> scene_;
  WatcherOptions options_;
  std::map<uint64_t, std::shared_ptr<const SceneState>> states_;
  uint64_t sequence_ = 0;
};

TEST_F(RenderViewTest, NothingIsEvaluatedForNobody) {
  const auto view = scene_->AcquireView(options_.view.key);
  ASSERT_OK(view);
  Move(kCorner);
  EXPECT_FALSE(RunTurn()) << "not watched";

  const auto client = Watch();
  client->watcher().SetPaused(true);
  Move(kCorner);
  EXPECT_FALSE(RunTurn()) << "paused";
  client->watcher().SetSilent(true);
  client->watcher().SetPaused(false);
  Move(kCorner);
  EXPECT_FALSE(RunTurn()) << "silent";
  while (client->Step()) continue;
  EXPECT_EQ(client->lattice_revision(), 3u) << "the cage goes on";

  client->watcher().SetSilent(false);
  ExpectRightAtHead(*client);
}

TEST_F(RenderViewTest, ASnapshotAheadOfTheReaderIsTheLastUntilItIsTaken) {
  const auto client = Watch();
  Move(kCorner);
  client->RunIntoUpdate();
  Move(kCorner);
  EXPECT_TRUE(RunTurn()) << "while the update before it is sent";
  Move(kOtherCorner);
  EXPECT_FALSE(RunTurn()) << "it would be old when the reader comes";

  ExpectRightAtHead(*client);
  EXPECT_EQ(client->updates().size(), 4u);
}

TEST_F(RenderViewTest, EditsDuringEachStageAreInTheNextUpdate) {
  const auto client = Watch();
  for (const Step step : {Step::kEvaluate, Step::kEncode}) {
    Move(kCorner);
    script().DuringNext(step, [&] {
      EXPECT_FALSE(RunTurn()) << "one turn at a time";
      Move(kOtherCorner);
    });
    client->RunToUpdate();
    EXPECT_EQ(client->updates().back().end.revision + 1, scene_->State()->revision);
    ExpectRightAtHead(*client);
  }
}

TEST_F(RenderViewTest, ATurnThatNobodyWaitsForAnyMoreLeavesItsChunksToTheNext) {
  MakeScene(96, 1);
  ASSERT_GT(scene_->State()->plan->chunk_count(), 2 * 256u) << "encoded in several batches";
  const auto client = Watch();
  const auto view = *scene_->AcquireView(options_.view.key);
  for (const Step step : {Step::kEvaluate, Step::kEncode}) {
    const uint64_t revision = scene_->State()->revision;
    script().DuringNext(step, [&] { client->watcher().SetPaused(true); });
    Move(kCorner, {step == Step::kEvaluate ? 40.0 : -40.0, 0, 0});  // a new box: all chunks
    EXPECT_TRUE(RunTurn());
    EXPECT_EQ(view->newest()->revision, revision) << "stopped";

    Move(kOtherCorner);
    client->watcher().SetPaused(false);
    ExpectRightAtHead(*client);
  }
}

TEST_F(RenderViewTest, AFailureEndsTheWatchersAndANewOneIsANewTry) {
  for (const Step step : {Step::kCreateView, Step::kEvaluate, Step::kEncode}) {
    MakeScene(33 + static_cast<int>(step), 2);
    script().FailNext(step, absl::InternalError("no such luck"));
    const auto client = Connect();

    RunToEnd(*client);

    EXPECT_THAT(client->status(), StatusIs(absl::StatusCode::kInternal));
    EXPECT_FALSE(RunTurn()) << "it is not tried again by itself";
    const auto another = Watch();
    Move(kCorner);
    ExpectRightAtHead(*another);
    ASSERT_OK(registry_.Delete(scene_->id()));
    states_.clear();
  }
}

TEST_F(RenderViewTest, WhatADeviceHasNoMemoryForIsTriedAgainOnceAnotherSceneWasEvicted) {
  const auto idle = scene_;
  Watch();
  ASSERT_GT(idle->EvictableBytes(), 0u);
  MakeScene(16, 4);
  script().FailNext(Step::kEvaluate, error::OutOfMemory("the stage", 2, 1));

  const auto client = Watch();

  ExpectRightAtHead(*client);
  EXPECT_EQ(idle->EvictableBytes(), 0u);
  EXPECT_EQ(registry_.evictions(), 1u);
}

// Edges of chunks that the edit does not reach get other levels with those beside them. A retry names all chunks, and must
// not forget these.
TEST_F(RenderViewTest, AnEvaluationThatIsTriedAgainTellsWhatElseChanged) {
  for (const int cells : {24, 16}) {
    Watch();  // of a scene that can be evicted then
    MakeScene(cells, 10);
    options_.view.key.spec.tolerance = 0.0005;
  }
  const auto client = Watch();
  const auto view = *scene_->AcquireView(options_.view.key);
  constexpr uint32_t kPoint = 77;  // changes a level beside what it reaches, after these
  for (uint32_t point = 0; point < kPoint; point += 7) {
    Move(point, {0, 0, 0.2});
    client->RunToHead();
  }
  const PatternCodes before = view->newest()->patterns;
  const std::vector<uint16_t> copy(before.codes.begin(), before.codes.end());
  script().FailNext(Step::kEvaluate, error::OutOfMemory("the stage", 2, 1));
  Move(kPoint, {0, 0, 0.2});
  ExpectRightAtHead(*client);

  EXPECT_EQ(registry_.evictions(), 1u);
  const auto snapshot = view->newest();
  EXPECT_FALSE(std::ranges::equal(snapshot->patterns.codes, copy)) << "other levels";
  EXPECT_TRUE(std::ranges::equal(before.codes, copy)) << "as they were";
  const auto reached = DirtyByControlPoints(*snapshot->plan, {{kPoint}}).chunks;
  size_t beside = 0;
  for (uint32_t c = 0; c < snapshot->chunks.size(); ++c) {
    if (std::ranges::equal(before.OfChunk(c), snapshot->patterns.OfChunk(c))) continue;
    EXPECT_EQ(snapshot->chunks[c].revision, snapshot->revision) << "chunk " << c;
    beside += std::ranges::binary_search(reached, c) ? 0u : 1u;
  }
  EXPECT_GT(beside, 0u);
}

// The attempt that failed had replaced the digests of what the client has.
TEST_F(RenderViewTest, AnEncodingThatIsTriedAgainEncodesWhatChanged) {
  for (const int cells : {24, 16}) {
    Watch();  // of a scene that can be evicted then
    MakeScene(cells, 4);
  }
  script().FailNext(Step::kEncoded, error::OutOfMemory("the encoding", 2, 1));
  const auto client = Watch();
  ExpectRightAtHead(*client);
  EXPECT_EQ(registry_.evictions(), 1u);

  script().FailNext(Step::kEncoded, error::OutOfMemory("the encoding", 2, 1));
  Move(kCorner);
  ExpectRightAtHead(*client);
  EXPECT_EQ(registry_.evictions(), 2u);
}

TEST_F(RenderViewTest, AViewReservesOnceForTheMostThatItCanTake) {
  for (const auto& [encoding, tolerance] : {std::pair{Encoding::kQuantised, 0.0},
                                            {Encoding::kDracoPoints, 0.0},
                                            {Encoding::kQuantised, 1e-4},
                                            {Encoding::kDracoPoints, 1e-4}}) {
    options_.view.key.encoding = encoding;
    options_.view.key.spec.tolerance = tolerance;
    const uint64_t before = budget_->used_bytes() - budget_->kept_bytes();
    auto client = Watch();
    const uint64_t reserved = budget_->used_bytes() - budget_->kept_bytes() - before;
    EXPECT_GE(reserved, 2 * VertexBytes(*scene_->State()->plan, options_.view.key));

    for (int edit = 0; edit < 4; ++edit) {
      Move(edit % 2 == 0 ? kCorner : kOtherCorner);
      client->RunToHead();
      EXPECT_EQ(budget_->used_bytes() - budget_->kept_bytes(), before + reserved);
      EXPECT_LE(HostBytes(scene_->memory()) - HostBytes(scene_->Head().target->memory()),
                reserved + scene_->memory().at("mesh") + scene_->memory().at("patch_tree") +
                    scene_->memory().at("lattice") + scene_->memory().at("history"));
    }
    client = nullptr;
    EXPECT_TRUE(scene_->Evict());
    EXPECT_EQ(budget_->used_bytes() - budget_->kept_bytes(), before) << "and gives all of it back";
  }
}

// The stream of unconnected triangles needs far more bytes per point than a surface's.
TEST_F(RenderViewTest, AViewOfUnconnectedTrianglesTakesNoMoreThanItReserves) {
  SceneConfig config = MakeSceneConfig("scene-soup");
  config.mesh = std::make_shared<const PolygonMesh>(TriangleSoup(300, 20261122));
  config.lattices = {*FitLattice(config.mesh->ComputeBounds(), {4, 4, 4}, {2, 2, 2}, 0.05)};
  config.default_view.key.encoding = Encoding::kDracoPoints;
  config.default_view.key.spec.position_bits = 16;
  config.default_view.key.spec.normal_bits = 12;
  MakeScene(config, 1);
  const uint64_t before = budget_->used_bytes() - budget_->kept_bytes();

  const auto client = Watch();

  const MemoryUse use = scene_->memory();
  ASSERT_GT(use.at("chunks"), use.at("vertices") * 3 / 4) << "long streams";
  EXPECT_LE(use.at("chunks") + use.at("vertices"),
            budget_->used_bytes() - budget_->kept_bytes() - before);
}

TEST_F(RenderViewTest, AnIdleViewOfAnotherSceneMakesRoom) {
  const auto idle = scene_;
  Watch();
  MakeScene(16, 4);
  const auto others =
      budget_->Reserve("others", budget_->total_bytes() - budget_->used_bytes() - 1'000);
  ASSERT_OK(others);
  const auto client = Watch();
  ExpectRightAtHead(*client);
  EXPECT_EQ(idle->EvictableBytes(), 0u);
}

TEST_F(RenderViewTest, WithoutMemoryTheWatchersEndAndTheRefusalSaysWhatIsFree) {
  const auto others =
      budget_->Reserve("others", budget_->total_bytes() - budget_->used_bytes() - 1'000);
  ASSERT_OK(others);
  const auto client = Connect();

  RunToEnd(*client);

  EXPECT_THAT(client->status(), StatusIs(absl::StatusCode::kResourceExhausted));
  const error::Details details = error::DetailsOf(client->status());
  EXPECT_EQ(details.reason, "OUT_OF_MEMORY");
  EXPECT_EQ(details.free_bytes, 1'000u);
  EXPECT_GT(details.asked_bytes, VertexBytes(*scene_->State()->plan, options_.view.key));
}

TEST_F(RenderViewTest, SnapshotsAreRetiredWhereTheyWouldTakeMoreThanIsReserved) {
  options_.view.key.encoding = Encoding::kDracoPoints;
  script().UseRoomyBlocks();
  const auto slow = Connect(), fast = Connect();
  slow->RunIntoUpdate();
  for (int edit = 0; edit < 6; ++edit) {
    Move(kCorner, {edit % 2 == 0 ? 40.0 : -40.0, 0, 0});  // a new box: all chunks change
    fast->RunToHead();
    const auto view = *scene_->AcquireView(options_.view.key);
    EXPECT_LE(view->held_bytes(), SnapshotBytes(*scene_->State()->plan, options_.view.key, 1));
  }

  ExpectRightAtHead(*fast);
  ExpectRightAtHead(*slow);
}

TEST_F(RenderViewTest, WhatRoundsToTheSameIntegersIsNotEncoded) {
  const auto client = Watch();
  const int all = static_cast<int>(scene_->State()->plan->chunk_count());
  ASSERT_EQ(script().encoded_chunks(), all);
  const double step = scene_->State()->box.step(options_.view.key.spec.position_bits);

  Move(kCorner, {1e-12 * step, 0, 0});
  ExpectRightAtHead(*client);

  EXPECT_EQ(script().encoded_chunks(), all);
  EXPECT_EQ(client->updates().back().begin.chunk_count, 0u);
  EXPECT_EQ(client->updates().back().end.revision, 1u) << "which is covered all the same";
}

TEST_F(RenderViewTest, WhatAnotherWriterHasEncodedIsEncodedOnceMoreAndNotSent) {
  const auto client = Watch();
  const double step = scene_->State()->box.step(options_.view.key.spec.position_bits);
  const int at_first = script().encoded_chunks();

  script().ChangeDigests();
  Move(kCorner, {1e-12 * step, 0, 0});
  client->RunToHead();
  const int once_more = script().encoded_chunks();
  Move(kCorner, {1e-12 * step, 0, 0});
  ExpectRightAtHead(*client);

  EXPECT_GT(once_more, at_first);
  EXPECT_EQ(script().encoded_chunks(), once_more);
  EXPECT_EQ(client->updates()[1].begin.chunk_count, 0u);
  EXPECT_EQ(client->updates()[2].begin.chunk_count, 0u);
}

TEST_F(RenderViewTest, AnotherStructureNeedsNoMemoryForBoth) {
  const auto client = Watch();
  const uint64_t before = budget_->used_bytes();
  const auto others =
      budget_->Reserve("others", budget_->total_bytes() - before - (uint64_t{6} << 20));
  ASSERT_OK(others);

  ASSERT_OK(scene_->ApplyEdits(KnotBatch(*scene_, "alice", ++sequence_, 0, 0.37)));
  states_[scene_->State()->revision] = scene_->State();

  ExpectRightAtHead(*client);
  EXPECT_EQ(client->topologies(), 2u);
}

class DeviceViewTest : public RenderViewTest {
 protected:
  DeviceViewTest() : RenderViewTest(uint64_t{1} << 30) {}
};

TEST_F(DeviceViewTest, AnEvictedSceneHasNoTargetAndGetsOneWhenItIsEvaluatedNext) {
  Watch();
  const int prepared = script().calls(Step::kPrepare);
  EXPECT_TRUE(scene_->Evict());
  EXPECT_FALSE(scene_->Evict()) << "there is nothing left";
  Move(kCorner);
  EXPECT_EQ(script().calls(Step::kPrepare), prepared)
      << "an edit that nobody watches needs no device";

  const auto client = Watch();

  EXPECT_EQ(script().calls(Step::kPrepare), prepared + 1);
  EXPECT_FALSE(scene_->Evict()) << "it is watched";
  ExpectRightAtHead(*client);
}

TEST_F(DeviceViewTest, ATargetStaysWhileAViewOfItLives) {
  const RenderInput head = scene_->Head();
  {
    const auto target = head.target->Get();
    ASSERT_OK(target);
    EXPECT_FALSE(head.target->Evict());
  }
  EXPECT_TRUE(head.target->Evict());
}

TEST_F(DeviceViewTest, ALostDeviceIsAskedNothingAnyMore) {
  const auto client = Watch();
  script().FailNext(Step::kEncode, absl::UnavailableError("the device fell off the bus"));
  Move(kCorner);
  RunToEnd(*client);
  const int calls = script().calls(Step::kCreateView);

  const auto another = Connect();
  RunToEnd(*another);

  for (const absl::Status& status : {client->status(), another->status()}) {
    EXPECT_THAT(status, StatusIs(absl::StatusCode::kUnavailable));
    EXPECT_EQ(error::DetailsOf(status).reason, "DEVICE_LOST");
  }
  EXPECT_EQ(script().calls(Step::kCreateView), calls);
}

}  // namespace
}  // namespace latticed::testing
