// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The scene engine against a model: several editors and several watchers at once, with random delays,
// views, pauses, reconnects, undo and knot insertion. The model is a record of every revision's state. An
// update is right when its chunks equal, byte for byte, a full new evaluation of that state. Runs under
// ThreadSanitizer. LATTICED_SEED sets the seed of the random numbers.
#include <algorithm>
#include <atomic>
#include <map>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "absl/time/clock.h"
#include "core/cpu/cpu_backend.h"
#include "tests/server/engine/engine_support.h"
#include "tests/support/seed.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

constexpr int kEditors = 3;
constexpr int kWatchers = 4;
constexpr int kEditsPerEditor = 60;
constexpr int kMaxKnots = 3;

// The state of every revision of a scene. Edits go through it one at a time, so it misses none.
class Record {
 public:
  explicit Record(std::shared_ptr<Scene> scene) : scene_(std::move(scene)) {
    states_[0] = scene_->State();
  }

  absl::StatusOr<EditSummary> Apply(const EditBatch& batch) {
    const MutexLock lock(&mutex_);
    auto summary = scene_->ApplyEdits(batch);
    const auto state = scene_->State();
    states_[state->revision] = state;
    return summary;
  }

  // The chunks of a revision in a view, all evaluated anew.
  const std::vector<std::vector<uint8_t>>& Expected(uint64_t revision, const ViewKey& key) {
    const MutexLock lock(&mutex_);
    auto& chunks = expected_[{revision, key}];
    if (chunks.empty()) chunks = EvaluateAfresh(*states_.at(revision), key);
    return chunks;
  }
  std::vector<Vec3d> Cage(uint64_t revision) {
    const MutexLock lock(&mutex_);
    return *states_.at(revision)->control_points;
  }

 private:
  const std::shared_ptr<Scene> scene_;
  Mutex mutex_;
  std::map<uint64_t, std::shared_ptr<const SceneState>> states_;
  std::map<std::pair<uint64_t, ViewKey>, std::vector<std::vector<uint8_t>>> expected_;
};

class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}
  int Below(int end) { return std::uniform_int_distribution<int>(0, end - 1)(engine_); }
  double Number(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  void Nap(int most_microseconds) { absl::SleepFor(absl::Microseconds(Below(most_microseconds))); }

 private:
  std::mt19937_64 engine_;
};

EditBatch RandomBatch(const Scene& scene, const std::string& editor, uint64_t sequence,
                      Random& random) {
  const auto state = scene.State();
  const int kind = random.Below(20);
  const bool room = state->structure_id <= kMaxKnots;
  if (kind == 0 && room) {
    const int axis = random.Below(3);
    const LatticeStructure& s = state->lattices[0].structure();
    const double t = random.Number(0.05, 0.95);
    return KnotBatch(scene, editor, sequence, axis,
                     (1 - t) * s.domain_begin(axis) + t * s.domain_end(axis));
  }
  EditBatch batch = MoveBatch(scene, editor, sequence, {}, {});
  if (kind < 4) {
    batch.edits = {Undo{kind == 1 ? UndoScope::kScene : UndoScope::kMine}};
    return batch;
  }
  if (kind == 4) {
    batch.edits = {Redo{}};
    return batch;
  }
  MoveControlPoints move;
  const int count = state->lattices[0].structure().control_point_count();
  // Moves neighbouring points, each once. Kind 5 may move them out of the quantisation box.
  const int first = random.Below(count);
  for (int i = first; i < std::min(count, first + 1 + random.Below(4)); ++i) {
    move.indices.push_back(static_cast<uint32_t>(i));
  }
  const double reach = kind == 5 ? 3.0 : 0.05;
  move.offset = {random.Number(-reach, reach), random.Number(-reach, reach),
                 random.Number(-reach, reach)};
  batch.edits = {move};
  if (kind > 12) {
    batch.gesture_id = "drag";
    batch.gesture_phase = random.Below(4) == 0 ? GesturePhase::kCommit : GesturePhase::kUpdate;
  }
  return batch;
}

std::vector<ViewKey> AllKeys() {
  std::vector<ViewKey> keys = {{{.format = VertexFormat::kEdgeBounds}, Encoding::kPatches}};
  for (const Encoding encoding : {Encoding::kQuantised, Encoding::kRaw, Encoding::kDracoPoints}) {
    for (const double tolerance : {0.0, 0.001}) {
      ViewKey key = MakeSceneConfig("x").default_view.key;
      key.encoding = encoding;
      key.spec.format = FormatOf(encoding);
      key.spec.segments = tolerance > 0 ? 4 : 2;
      key.spec.tolerance = tolerance;
      keys.push_back(key);
    }
  }
  return keys;
}

WatchView RandomView(Random& random) {
  const std::vector<ViewKey> keys = AllKeys();
  WatchView view = MakeSceneConfig("x").default_view;
  view.key = keys[static_cast<size_t>(random.Below(static_cast<int>(keys.size())))];
  return view;
}

WatcherOptions RandomOptions(Random& random) {
  return {.editor_id = "editor-0",
          .view = RandomView(random),
          .max_unacked_updates = static_cast<size_t>(random.Below(3))};
}

void ExpectLastUpdateIsRight(const WatcherClient& client, Record& record, const char* when) {
  const auto& update = client.updates().back();
  const auto& expected = record.Expected(update.end.revision, *client.view());
  ASSERT_GE(client.chunks().size(), expected.size());
  for (size_t c = 0; c < expected.size(); ++c) {
    ASSERT_TRUE(std::ranges::equal(client.chunks()[c].span(), expected[c]))
        << when << ": chunk " << c << " at revision " << update.end.revision;
  }
}

void RunEditor(const Scene& scene, Record& record, int number, uint64_t seed,
               std::atomic<int>& accepted) {
  Random random(seed);
  const std::string editor = "editor-" + std::to_string(number);
  for (int i = 0; i < kEditsPerEditor; ++i) {
    const auto summary =
        record.Apply(RandomBatch(scene, editor, static_cast<uint64_t>(i + 1), random));
    if (summary.ok()) ++accepted;
    // Refusals that may happen: nothing to undo, points that another editor has changed since, a
    // structure that has changed since.
    if (!summary.ok() && !absl::IsAborted(summary.status()) &&
        !absl::IsFailedPrecondition(summary.status())) {
      EXPECT_OK(summary.status());
    }
    random.Nap(4000);
  }
}

void RunWatcher(const std::shared_ptr<Scene>& scene, Record& record, uint64_t seed,
                const std::atomic<bool>& editing) {
  Random random(seed);
  WatcherClient client(scene, RandomOptions(random));
  size_t seen = 0;
  while (editing) {
    if (!client.Step()) client.bell().Wait(absl::Milliseconds(5));
    ASSERT_OK(client.status());
    if (client.updates().size() > seen) {
      seen = client.updates().size();
      ExpectLastUpdateIsRight(client, record, "in between");
      if (::testing::Test::HasFatalFailure()) return;
      if (random.Below(3) > 0) (void)client.watcher().Ack(client.updates().back().end.update_id);
    }
    if (random.Below(40) == 0) random.Nap(15000);  // a slow reader
    if (random.Below(200) == 0) {
      ASSERT_OK(client.watcher().SetView(RandomView(random)));
    }
    if (random.Below(100) == 0) client.watcher().SetPaused(random.Below(2) == 0);
    if (random.Below(150) == 0) client.watcher().SetSilent(random.Below(2) == 0);
    if (random.Below(300) == 0) {
      WatcherOptions options = RandomOptions(random);
      if (random.Below(2) == 0) options.view = client.watcher().view();
      client.Reconnect(options);
    }
  }
  client.watcher().SetPaused(false);
  client.watcher().SetSilent(false);
  client.watcher().StopAcks();
  client.RunToHead();
  if (::testing::Test::HasFatalFailure()) return;
  ExpectLastUpdateIsRight(client, record, "at the end");
  EXPECT_TRUE(client.updates().back().end.full_detail);
  EXPECT_EQ(client.updates().back().end.revision, scene->State()->revision);
  EXPECT_EQ(client.cage(), record.Cage(scene->State()->revision));
}

TEST(ModelBasedTest, EveryUpdateIsConsistentAndEveryWatcherEndsAtTheHead) {
  const uint32_t seed = SeedOr(20240511);
  SCOPED_TRACE("LATTICED_SEED=" + std::to_string(seed));
  const auto backend = MakeCpuBackend({.threads = 1});
  SceneRegistry registry(backend.get(), 3);
  const auto scene = registry.Create(MakeSceneConfig("scene-model", 5, 4));
  ASSERT_OK(scene);
  Record record(*scene);
  std::atomic<bool> editing = true;
  std::atomic<int> accepted = 0;

  std::vector<std::thread> watchers, editors;
  for (uint64_t w = 0; w < kWatchers; ++w) {
    watchers.emplace_back([&, w] { RunWatcher(*scene, record, seed + 100 + w, editing); });
  }
  for (int e = 0; e < kEditors; ++e) {
    editors.emplace_back(
        [&, e] { RunEditor(**scene, record, e, seed + static_cast<uint64_t>(e), accepted); });
  }
  for (std::thread& editor : editors) editor.join();
  editing = false;
  for (std::thread& watcher : watchers) watcher.join();

  EXPECT_GT(accepted, kEditors * kEditsPerEditor / 2) << "the run exercised something";
  EXPECT_EQ((*scene)->State()->revision, static_cast<uint64_t>(accepted));
}

}  // namespace
}  // namespace latticed::testing
