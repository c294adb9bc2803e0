// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Two daemons over one PostgreSQL: the second goes on with a scene when the first is killed, drains or stands still.
#include <thread>

#include "server/base/version.h"
#include "tests/server/durability/shared_scene_test.h"

namespace latticed::testing {
namespace {

// Of the scenes of a server that is gone: at most two leases, and as much as a machine may stall.
const absl::Duration kMostTakeover = 2 * kLease + absl::Seconds(15);

class TakeoverTest : public SharedSceneTest {
 protected:
  // "b" has all edits that were acknowledged, and goes on.
  void CheckThatAllGoesOn() {
    Reach(b_->channel());
    EXPECT_EQ(Lattice().SerializeAsString(), states_[kEditsBefore].SerializeAsString());
    v1::EditResult result;
    ASSERT_OK(Apply(Edit(kEditsBefore), &result));
    EXPECT_EQ(result.revision(), kEditsBefore) << "it counts once";
    v1::EditBatch undo = Edit(kEditsBefore + 1);
    undo.mutable_edits(0)->mutable_undo();
    ASSERT_OK(Apply(undo, &result));
    EXPECT_EQ(result.revision(), kEditsBefore + 1);
    EXPECT_EQ(Lattice().lattice().SerializeAsString(),
              states_[kEditsBefore - 1].lattice().SerializeAsString());
  }
};

TEST_F(TakeoverTest, ASceneHasOneServer) {
  v1::Scene scene;
  auto [owner, status] = SceneOwner(b_->scenes(), &scene);
  ExpectRefusal(status,
                {absl::StatusCode::kUnavailable, "SCENE_MOVED", "", "on another server, a"});
  EXPECT_EQ(owner, "a");
  std::tie(owner, status) = SceneOwner(a_->scenes(), &scene);
  EXPECT_OK(status);
  EXPECT_EQ(owner, "a");
  EXPECT_EQ(scene.revision(), kEditsBefore);

  Reach(b_->channel());
  ExpectRefused(Apply(Edit(kEditsBefore + 1)), absl::StatusCode::kUnavailable, "SCENE_MOVED");
  EXPECT_EQ(SceneCount(), 1) << "lists are of all servers";
  EXPECT_EQ(MeshCount(), 1);
}

TEST_F(TakeoverTest, AKilledServersSceneIsTakenOver) {
  a_->End(SIGKILL);

  AwaitMove();

  EXPECT_LT(pause_, kMostTakeover);
  CheckThatAllGoesOn();
}

TEST_F(TakeoverTest, AWatcherOfAKilledServerIsSentWhatItMisses) {
  if (Commit() == "unknown") GTEST_SKIP() << "no build is known to be the same";
  v1::WatchRequest watch = Watch();
  watch.mutable_view()->set_tolerance(2e-3);
  watch.mutable_view()->set_encoding(v1::ENCODING_QUANTISED);
  WatchClient watcher(*scenes_, watch);
  watcher.ReadUpdates(1);
  auto chunks = watcher.log.chunks, levels = watcher.log.levels;
  ASSERT_OK(Apply(Edit(124)));
  a_->End(SIGKILL);
  AwaitMove();
  Reach(b_->channel());

  WatchClient fresh(*scenes_, watch);
  fresh.ReadUpdates(1);
  watch.set_resume_token(watcher.log.ends.at(0).resume_token());
  WatchClient resumed(*scenes_, watch);
  resumed.ReadUpdates(1);

  EXPECT_TRUE(resumed.log.hello.resumed());
  EXPECT_LT(resumed.log.begins[0].chunk_count(), fresh.log.begins[0].chunk_count());
  for (const auto& [index, data] : resumed.log.chunks) chunks[index] = data;
  for (const auto& [index, codes] : resumed.log.levels) levels[index] = codes;
  EXPECT_TRUE(chunks == fresh.log.chunks);
  EXPECT_TRUE(levels == fresh.log.levels);
}

// Its lease is longer than a machine may stall.
class HandoverTest : public TakeoverTest {
 protected:
  absl::Duration Lease() const override { return absl::Seconds(40); }
};

TEST_F(HandoverTest, ADrainingServerGivesItsSceneAway) {
  a_->Signal(SIGTERM);

  AwaitMove();

  EXPECT_LT(pause_, Lease() / 2) << "it does not wait for a lease";
  EXPECT_EQ(a_->Wait(), 0);
  CheckThatAllGoesOn();
}

TEST_F(TakeoverTest, AServerThatStoodStillAcknowledgesNothingMore) {
  DeformClient editor(*scenes_, Watch());
  editor.ReadUpdates(1);
  std::jthread writer([&](const std::stop_token& stop) {
    for (uint64_t n = kEditsBefore + 1; !stop.stop_requested() && editor.Send(Edit(n)); ++n) {
      absl::SleepFor(absl::Milliseconds(5));
    }
  });
  editor.ReadUntil([&] { return editor.log.results.size() == 5; });

  a_->Signal(SIGSTOP);
  absl::SleepFor(kLease * 1.5);
  const uint64_t stored = AwaitMove().revision();
  Reach(b_->channel());
  v1::EditResult result;
  ASSERT_OK(Apply(Edit(1, "bob"), &result));
  EXPECT_EQ(result.revision(), stored + 1);
  a_->Signal(SIGCONT);
  while (editor.Read()) continue;
  writer.request_stop();
  writer.join();

  ExpectRefused(editor.Finish(), absl::StatusCode::kUnavailable, "SCENE_MOVED");
  // What waited while the server stood still is refused.
  std::erase_if(editor.log.results, [](const auto& r) { return r.status().code() != 0; });
  EXPECT_GE(stored, kEditsBefore + editor.log.results.size()) << "acknowledged edits are lost";
  EXPECT_LE(editor.log.results.back().revision(), stored) << "acknowledged after the takeover";
  EXPECT_EQ(Get().revision(), stored + 1) << "written after the takeover";
  ASSERT_OK(Apply(Edit(stored), &result));
  EXPECT_EQ(result.revision(), stored) << "it counts once";
  ASSERT_OK(Apply(Edit(stored + 1), &result));
  EXPECT_EQ(result.revision(), stored + 2);
  v1::Scene scene;
  EXPECT_EQ(SceneOwner(a_->scenes(), &scene).first, "b");
}

}  // namespace
}  // namespace latticed::testing
