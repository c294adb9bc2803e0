// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Less detail while edits come: which detail is chosen, and which updates a watcher is sent.
// level_of_detail_stream_test.cc tests it through a stub.
#include "server/engine/watch/level_of_detail.h"

#include <algorithm>
#include <string>

#include "absl/time/clock.h"
#include "core/base/limits.h"
#include "core/cpu/cpu_backend.h"
#include "core/ffd/tessellation_pattern.h"
#include "tests/server/engine/engine_support.h"
#include "tests/support/becomes.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

class LevelOfDetailTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto scene = registry_.Create(MakeSceneConfig("scene-one"));
    ASSERT_OK(scene);
    scene_ = *scene;
    asked_ = scene_->config().default_view;  // 4 segments, 8 bytes per point
    patches_ = scene_->State()->plan->patches.size();
  }
  // A state whose edit touched `patches` patches. More edits come at kDrag; they pause at kPause.
  SceneState Edited(uint64_t patches) const {
    SceneState state = *scene_->State();
    state.patches_touched = patches;
    state.busy_until = kDrag + absl::Milliseconds(50);
    return state;
  }
  int Chosen(LevelOfDetail& detail, uint64_t patches, absl::Time now = kDrag, bool whole = false) {
    return detail.Choose(Edited(patches), whole ? nullptr : &asked_.key, now).spec.segments;
  }
  // A snapshot of all chunks, of `bytes_per_point` bytes per point.
  Snapshot Sent(int segments, uint64_t bytes_per_point) const {
    Snapshot snapshot;
    snapshot.view = asked_.key;
    snapshot.view.spec.segments = segments;
    snapshot.plan = scene_->State()->plan;
    SharedBytes data;
    data.size = patches_ * static_cast<uint64_t>(PointsPerPatch(segments)) * bytes_per_point;
    snapshot.chunks = ChunkTable(1);
    snapshot.chunks.Set(0, {1, std::move(data), {}});
    return snapshot;
  }

  static inline const absl::Time kDrag = absl::UnixEpoch() + absl::Hours(1);
  static inline const absl::Time kPause = kDrag + absl::Milliseconds(50);

  const std::unique_ptr<Backend> backend_ = MakeCpuBackend({.threads = 1});
  SceneRegistry registry_{backend_.get(), 1};
  std::shared_ptr<Scene> scene_;
  WatchView asked_;
  uint64_t patches_ = 0;
};

TEST_F(LevelOfDetailTest, TakesTheMostSegmentsWhosePointsFit) {
  struct Row {
    uint64_t points_per_patch;
    int segments;
  };
  for (const Row& row : {Row{3, 1}, Row{5, 1}, Row{6, 2}, Row{14, 3}, Row{15, 4}, Row{999, 4}}) {
    SCOPED_TRACE(row.points_per_patch);
    asked_.max_points = patches_ * row.points_per_patch;
    LevelOfDetail detail(asked_);
    EXPECT_EQ(Chosen(detail, patches_), row.segments);
    EXPECT_EQ(Chosen(detail, patches_, kPause), 4);
  }
}

TEST_F(LevelOfDetailTest, TakesTheMostSegmentsWhoseBytesFitATwentyFifthOfASecond) {
  asked_.max_bytes_per_second = 25 * patches_ * 8 * 10;
  LevelOfDetail exactly(asked_);
  EXPECT_EQ(Chosen(exactly, patches_), 3) << "10 points a patch";
  asked_.max_bytes_per_second -= 25;
  LevelOfDetail less(asked_);
  EXPECT_EQ(Chosen(less, patches_), 2);
  asked_.max_bytes_per_second = 1;
  LevelOfDetail hardly_any(asked_);
  EXPECT_EQ(Chosen(hardly_any, patches_), 1);
}

TEST_F(LevelOfDetailTest, KeepsFullDetailWhereTheUpdateFitsWhole) {
  asked_.max_points = 15 * patches_ / 2;
  LevelOfDetail detail(asked_);
  EXPECT_EQ(Chosen(detail, patches_ / 2), 4);
  EXPECT_EQ(Chosen(detail, patches_ / 2 + 1), 2) << "all patches must fit then";
  EXPECT_EQ(Chosen(detail, 1), 2) << "until edits pause";
  EXPECT_EQ(Chosen(detail, 1, kPause), 4);
  EXPECT_EQ(Chosen(detail, 1, kDrag, /*whole=*/true), 2) << "every chunk would be sent";
}

// With a tolerance, a snapshot shows how many points a patch has: here 6, as of the pattern of 2 segments.
TEST_F(LevelOfDetailTest, ExpectsThePointsThatASnapshotHas) {
  asked_.key.spec.tolerance = 0.01;
  asked_.max_points = 6 * patches_;
  LevelOfDetail unknown(asked_);
  EXPECT_EQ(Chosen(unknown, patches_), 2) << "as many as the segments allow";

  Snapshot snapshot = Sent(4, 8);
  const std::vector<uint16_t> codes(snapshot.plan->patches.size(), 1 | 1 << 3 | 1 << 6);
  snapshot.patterns.codes = codes;
  snapshot.chunks = ChunkTable(snapshot.plan->chunk_count());
  for (uint32_t chunk = 0; chunk < snapshot.chunks.size(); ++chunk) {
    const auto [first, last] = snapshot.plan->ChunkPatches(chunk);
    SharedBytes data;
    data.size = 6 * (last - first) * 8;
    snapshot.chunks.Set(chunk, {1, data, VertexDigest()});
  }
  LevelOfDetail detail(asked_);
  detail.Learn(snapshot);
  EXPECT_EQ(Chosen(detail, patches_), 4) << "full detail fits";

  asked_.max_points = 6 * patches_ - 1;
  LevelOfDetail less(asked_);
  less.Learn(snapshot);
  EXPECT_EQ(Chosen(less, patches_), 1) << "segments that allow less than 6 points";
}

TEST_F(LevelOfDetailTest, BitsFallWhileAGestureIsOpen) {
  asked_.drag_position_bits = 11;
  LevelOfDetail detail(asked_);
  SceneState state = Edited(patches_);
  EXPECT_EQ(detail.Choose(state, &asked_.key, kDrag), asked_.key);
  state.gesture_open = true;
  for (const absl::Time now : {kDrag, kPause}) {
    const ViewKey key = detail.Choose(state, &asked_.key, now);
    EXPECT_EQ(key.spec.position_bits, 11);
    EXPECT_EQ(key.spec.normal_bits, asked_.key.spec.normal_bits);
    EXPECT_EQ(key.spec.segments, 4);
  }
}

TEST_F(LevelOfDetailTest, WithoutLimitsNothingIsLowered) {
  LevelOfDetail detail(asked_);
  EXPECT_EQ(Chosen(detail, patches_), 4);
  EXPECT_FALSE(detail.GivesWay(Edited(patches_), uint64_t{1} << 40, kDrag));
}

TEST_F(LevelOfDetailTest, LearnsWhatStreamsTakeAndOnlyFallsDuringADrag) {
  asked_.key.encoding = Encoding::kDracoPoints;
  asked_.max_bytes_per_second = 25 * patches_ * 30;
  LevelOfDetail detail(asked_);
  detail.Learn(Sent(4, 2));
  EXPECT_EQ(Chosen(detail, patches_), 4) << "15 points of 2 bytes";
  detail.Learn(Sent(4, 3));
  EXPECT_EQ(Chosen(detail, patches_), 2) << "10 points of more than 3 bytes do not fit";
  detail.Learn(Sent(2, 6));
  EXPECT_EQ(Chosen(detail, patches_), 1);
  detail.Learn(Sent(2, 1));
  EXPECT_EQ(Chosen(detail, patches_), 1) << "in the same drag";
  EXPECT_EQ(Chosen(detail, patches_, kPause), 4);
  EXPECT_EQ(Chosen(detail, patches_), 2) << "the next drag knows";
}

TEST_F(LevelOfDetailTest, ALargeUpdateGivesWayWhenEditsComeAgain) {
  asked_.max_bytes_per_second = 25 * 1'000;
  LevelOfDetail detail(asked_);
  EXPECT_FALSE(detail.GivesWay(Edited(1), 1'000, kDrag));
  EXPECT_FALSE(detail.GivesWay(Edited(1), 1'001, kPause));
  EXPECT_EQ(Chosen(detail, 1), 4);
  EXPECT_TRUE(detail.GivesWay(Edited(1), 1'001, kDrag));
  EXPECT_LT(Chosen(detail, 1), 4);
}

TEST_F(LevelOfDetailTest, EditsPauseByTimeOrWithTheirGesture) {
  EditBatch batch = MoveBatch(*scene_, "alice", 1, {62}, {0, 0, 0.1});
  batch.gesture_id = "drag";
  ASSERT_OK(scene_->ApplyEdits(batch));
  const auto open = scene_->State();
  EXPECT_EQ(open->patches_touched, patches_);
  EXPECT_GE(open->busy_until - open->commit_time, absl::Milliseconds(40));
  EXPECT_LE(open->busy_until - open->commit_time, absl::Milliseconds(80));

  EditBatch other = MoveBatch(*scene_, "bob", 1, {61}, {0, 0, 0.1});
  other.gesture_id = "other";
  other.gesture_phase = GesturePhase::kCommit;
  ASSERT_OK(scene_->ApplyEdits(other));
  EXPECT_GT(scene_->State()->busy_until, scene_->State()->commit_time) << "alice still drags";

  batch.sequence = 2;
  batch.gesture_phase = GesturePhase::kCommit;
  ASSERT_OK(scene_->ApplyEdits(batch));
  EXPECT_EQ(scene_->State()->busy_until, scene_->State()->commit_time);
}

TEST_F(LevelOfDetailTest, AWatcherIsSentLessUntilThePauseAndThenEverything) {
  asked_.max_points = 6 * patches_;
  WatcherClient client(scene_, {.view = asked_, .max_unacked_updates = 0});
  WatcherClient other(scene_, {.view = asked_, .max_unacked_updates = 0});
  client.RunToUpdate();
  other.RunToUpdate();
  EXPECT_EQ(client.updates()[0].begin.view.key.spec.segments, 4);
  EXPECT_TRUE(client.updates()[0].end.full_detail);

  ASSERT_OK(scene_->ApplyEdits(MoveBatch(*scene_, "alice", 1, {62}, {0, 0, 0.1})));
  const absl::Time pause = scene_->State()->busy_until;
  for (WatcherClient* each : {&client, &other}) {
    each->RunToUpdate([pause] { return pause - absl::Milliseconds(1); });
    EXPECT_EQ(each->updates()[1].begin.view.key.spec.segments, 2);
    EXPECT_EQ(each->updates()[1].begin.chunk_count, scene_->State()->plan->chunk_count());
    EXPECT_EQ(each->updates()[1].end.revision, 1u);
    EXPECT_FALSE(each->updates()[1].end.full_detail);
    EXPECT_EQ(each->topologies(), 2u);
    EXPECT_FALSE(each->Step(pause - absl::Milliseconds(1)));
    EXPECT_EQ(each->watcher().wake_at(), pause) << "nothing else would tell";
  }
  EXPECT_EQ(client.chunks()[0].data, other.chunks()[0].data);

  client.RunToUpdate([pause] { return pause; });
  EXPECT_EQ(client.updates()[2].end.revision, client.updates()[2].end.head_revision);
  EXPECT_TRUE(client.updates()[2].end.full_detail);
  EXPECT_EQ(client.topologies(), 3u);
  const auto fresh = EvaluateAfresh(*scene_->State(), asked_.key);
  for (size_t c = 0; c < fresh.size(); ++c) {
    EXPECT_TRUE(std::ranges::equal(client.chunks()[c].span(), fresh[c])) << "chunk " << c;
  }
}

TEST_F(LevelOfDetailTest, AGestureThatFallsSilentGivesTheBitsBackWithoutAnEdit) {
  asked_.drag_position_bits = 9;
  WatcherClient client(scene_, {.view = asked_, .max_unacked_updates = 0});
  EditBatch batch = MoveBatch(*scene_, "alice", 1, {62}, {0, 0, 0.1});
  batch.gesture_id = "drag";
  ASSERT_OK(scene_->ApplyEdits(batch));
  client.RunToHead();
  EXPECT_FALSE(client.updates().back().end.full_detail);

  scene_->Tick(absl::Now() + absl::Seconds(55));
  EXPECT_FALSE(client.Step());
  // Tick ends no gesture while the registry's own Tick is at work on the scene.
  EXPECT_TRUE(Becomes(2000, [this] {
    scene_->Tick(absl::Now() + absl::Seconds(61));
    return !scene_->State()->gesture_open;
  }));
  client.RunToUpdate();

  EXPECT_EQ(client.updates().back().begin.view.key, asked_.key);
  EXPECT_EQ(client.updates().back().end.revision, 1u);
  EXPECT_TRUE(client.updates().back().end.full_detail);
}

TEST_F(LevelOfDetailTest, FullDetailIsDroppedHalfWayWhenEditsComeAgain) {
  asked_.max_bytes_per_second = 25 * patches_ * 8 * 6;
  WatcherClient client(scene_, {.view = asked_, .max_unacked_updates = 0});
  const absl::Time start = scene_->State()->commit_time;
  while (!client.watcher().update_in_progress() || client.quantisations() == 0) {
    if (!client.Step(start)) client.bell().Wait(absl::Milliseconds(10));
  }
  ASSERT_TRUE(client.Step(start)) << "update_begin";

  ASSERT_OK(scene_->ApplyEdits(MoveBatch(*scene_, "alice", 1, {62}, {0, 0, 0.1})));
  client.RunToUpdate([this] { return scene_->State()->busy_until - absl::Milliseconds(1); });

  EXPECT_TRUE(client.updates()[0].begin.restart);
  EXPECT_EQ(client.updates()[0].begin.view.key.spec.segments, 2);
  EXPECT_EQ(client.updates()[0].end.revision, 1u);
  EXPECT_EQ(scene_->counts().updates_superseded, 1u);
  EXPECT_EQ(scene_->counts().updates_restarted, 1u);
  EXPECT_EQ(scene_->counts().updates_begun, 2u);
  EXPECT_EQ(scene_->counts().updates_finished, 1u);
}

TEST_F(LevelOfDetailTest, WhereNoOtherViewCanBeHadDetailStays) {
  asked_.max_points = 6 * patches_;
  WatcherClient client(scene_, {.view = asked_, .max_unacked_updates = 0});
  client.RunToUpdate();
  std::vector<std::shared_ptr<SnapshotBoard>> held;
  ViewKey key = asked_.key;
  for (key.spec.segments = 5; key.spec.segments < 12; ++key.spec.segments) {
    held.push_back(*scene_->AcquireView(key));
  }

  ASSERT_OK(scene_->ApplyEdits(MoveBatch(*scene_, "alice", 1, {62}, {0, 0, 0.1})));
  client.RunToUpdate([this] { return scene_->State()->busy_until - absl::Milliseconds(1); });

  EXPECT_EQ(client.updates()[1].begin.view.key.spec.segments, 4);
  EXPECT_TRUE(client.updates()[1].end.full_detail);
}

}  // namespace
}  // namespace latticed::testing
