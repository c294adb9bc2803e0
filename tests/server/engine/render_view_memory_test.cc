// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views that have too little memory, or lose their device, on one thread.
#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/ffd/plan/dirty_set.h"
#include "server/engine/render/render_view.h"
#include "tests/server/engine/render_view_fixture.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

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
