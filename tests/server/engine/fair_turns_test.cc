// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A long update lets shorter ones of other scenes ahead, in the order of each worker.
#include <algorithm>
#include <iterator>
#include <memory>
#include <numeric>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/engine/engine_support.h"
#include "tests/server/engine/staged_backend.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::Gt;
using ::testing::Pair;

class FairTurnsTest : public ::testing::Test {
 protected:
  explicit FairTurnsTest(int workers = 1) : registry_(&backend_, workers) {}

  void TearDown() override {
    for (const Stage stage : {Stage::kEvaluate, Stage::kEncode}) gates().Open(stage);
  }
  StageGates& gates() { return backend_.gates(); }

  struct Watched {
    std::shared_ptr<Scene> scene;
    std::unique_ptr<WatcherClient> client;
    size_t chunks() const { return scene->State()->plan->chunk_count(); }
  };
  Watched Watch(int cells, int segments) {
    SceneConfig config = MakeSceneConfig("scene-" + std::to_string(cells), cells, 8);
    WatcherOptions options;
    options.max_unacked_updates = 0;
    options.view = config.default_view;
    options.view.key.spec.segments = segments;
    auto scene = registry_.Create(std::move(config));
    EXPECT_OK(scene);
    Watched watched{*scene, std::make_unique<WatcherClient>(*scene, options)};
    watched.client->RunToHead();
    return watched;
  }
  // Moves all control points: all chunks are evaluated and encoded.
  static void Edit(const Watched& watched) {
    std::vector<uint32_t> all(watched.scene->State()->control_points->size());
    std::iota(all.begin(), all.end(), 0u);
    ASSERT_OK(watched.scene->ApplyEdits(
        MoveBatch(*watched.scene, "alice", 1, std::move(all), {0, 0, 0.01})));
  }
  // Edits the first scenes, one for each worker, and the others once these are held at the gate of
  // `stage`; then lets all go.
  void EditWhileHeld(Stage stage, const std::vector<const Watched*>& scenes, int held = 1) {
    const int begun = gates().begun(stage);
    gates().Close(stage);
    for (int i = 0; i < held; ++i) {
      Edit(*scenes[static_cast<size_t>(i)]);
      ASSERT_TRUE(gates().WaitForBegun(stage, begun + i + 1));
    }
    before_ = gates().history().size();
    for (size_t i = static_cast<size_t>(held); i < scenes.size(); ++i) Edit(*scenes[i]);
    gates().Open(stage);
    for (const Watched* scene : scenes) scene->client->RunToHead();
  }
  // The evaluating and encoding that ended since.
  std::vector<StagedCall> Calls() {
    const std::vector<StagedCall> all = gates().history();
    std::vector<StagedCall> some;
    std::copy_if(all.begin() + static_cast<std::ptrdiff_t>(before_), all.end(),
                 std::back_inserter(some), [](const StagedCall& call) {
                   return call.stage == Stage::kEvaluatePart || call.stage == Stage::kEvaluate ||
                          call.stage == Stage::kEncode;
                 });
    return some;
  }
  std::vector<size_t> Order(Stage stage) {
    std::vector<size_t> order;
    for (const StagedCall& call : Calls()) {
      if (call.stage == stage) order.push_back(call.chunks);
    }
    return order;
  }
  // The first `count` steps, of those on `thread` where one is given.
  std::vector<std::pair<Stage, size_t>> FirstSteps(size_t count, std::thread::id thread = {}) {
    std::vector<std::pair<Stage, size_t>> steps;
    for (const StagedCall& call : Calls()) {
      if (thread != std::thread::id() && call.thread != thread) continue;
      if (steps.size() < count) steps.emplace_back(call.stage, call.chunks);
    }
    return steps;
  }
  static void ExpectRight(const Watched& watched) {
    const auto fresh = EvaluateAfresh(*watched.scene->State(), *watched.client->view());
    ASSERT_EQ(watched.client->chunks().size(), fresh.size());
    for (size_t c = 0; c < fresh.size(); ++c) {
      EXPECT_TRUE(std::ranges::equal(watched.client->chunks()[c].span(), fresh[c])) << c;
    }
  }

  StagedBackend backend_{/*on_device=*/false};
  SceneRegistry registry_;
  size_t before_ = 0;
};

TEST_F(FairTurnsTest, AShortUpdateWaitsForOneBatchOfALongEncoding) {
  const Watched large = Watch(90, 1), small = Watch(8, 1);
  ASSERT_GT(large.chunks(), 2 * 256u);
  ASSERT_LE(large.chunks(), 3 * 256u);

  EditWhileHeld(Stage::kEncode, {&large, &small});

  EXPECT_THAT(Order(Stage::kEncode),
              ElementsAre(large.chunks(), small.chunks(), large.chunks(), large.chunks()));
  ExpectRight(large);
  ExpectRight(small);
}

TEST_F(FairTurnsTest, AShortUpdateWaitsForOnePartOfALongEvaluation) {
  const Watched large = Watch(48, 32), small = Watch(8, 1);

  EditWhileHeld(Stage::kEvaluate, {&large, &small});

  EXPECT_THAT(FirstSteps(4), ElementsAre(Pair(Stage::kEvaluatePart, large.chunks()),
                                         Pair(Stage::kEvaluate, small.chunks()),
                                         Pair(Stage::kEncode, small.chunks()),
                                         Pair(Stage::kEvaluatePart, large.chunks())));
  ExpectRight(large);
  ExpectRight(small);
}

// Where the last batch of one ends, the next of the long ones is first in the queue.
TEST_F(FairTurnsTest, BesideTwoLongOnesItWaitsForOneBatchAndOnePart) {
  const Watched ending = Watch(40, 1), large = Watch(48, 32), small = Watch(8, 1);
  ASSERT_LE(ending.chunks(), 256u) << "more than a batch";
  ASSERT_GT(ending.chunks(), 2 * small.chunks());

  EditWhileHeld(Stage::kEncode, {&ending, &large, &small});

  EXPECT_THAT(
      FirstSteps(4),
      ElementsAre(Pair(Stage::kEncode, ending.chunks()), Pair(Stage::kEvaluatePart, large.chunks()),
                  Pair(Stage::kEvaluate, small.chunks()), Pair(Stage::kEncode, small.chunks())));
  ExpectRight(ending);
  ExpectRight(large);
  ExpectRight(small);
}

class FairTurnsOfTwoWorkersTest : public FairTurnsTest {
 protected:
  FairTurnsOfTwoWorkersTest() : FairTurnsTest(2) {}
  // On the worker that took it up.
  void ExpectAfterOne(Stage stage, const Watched& small) {
    const std::vector<StagedCall> calls = Calls();
    const auto its = std::ranges::find(calls, small.chunks(), &StagedCall::chunks);
    ASSERT_NE(its, calls.end());
    EXPECT_THAT(FirstSteps(3, its->thread),
                ElementsAre(Pair(stage, Gt(small.chunks())), Pair(Stage::kEvaluate, small.chunks()),
                            Pair(Stage::kEncode, small.chunks())));
  }
};

TEST_F(FairTurnsOfTwoWorkersTest, BesideTwoLongEncodingsItWaitsForOneBatch) {
  const Watched one = Watch(90, 1), other = Watch(91, 1), small = Watch(8, 1);
  ASSERT_GT(one.chunks(), 2 * 256u);

  EditWhileHeld(Stage::kEncode, {&one, &other, &small}, /*held=*/2);

  ExpectAfterOne(Stage::kEncode, small);
  ExpectRight(one);
  ExpectRight(other);
  ExpectRight(small);
}

TEST_F(FairTurnsOfTwoWorkersTest, BesideTwoLongEvaluationsItWaitsForOnePart) {
  const Watched one = Watch(48, 32), other = Watch(49, 32), small = Watch(8, 1);

  EditWhileHeld(Stage::kEvaluate, {&one, &other, &small}, /*held=*/2);

  ExpectAfterOne(Stage::kEvaluatePart, small);
  ExpectRight(one);
  ExpectRight(other);
  ExpectRight(small);
}

TEST_F(FairTurnsTest, APartOfAnEvaluationIsNoMoreThanABatchOfChunks) {
  constexpr uint64_t kPointsOfABatch = uint64_t{256} * 32 * 66;
  const Watched large = Watch(48, 32);
  const auto state = large.scene->State();
  const ViewSpec spec = large.client->watcher().view().key.spec;
  auto view = state->target->CreateView(spec);
  ASSERT_OK(view);
  std::vector<uint32_t> all(large.chunks());
  std::iota(all.begin(), all.end(), 0u);
  std::vector<uint64_t> parts;

  ASSERT_OK((*view)->EvaluateInParts(*state->control_points, state->box, all,
                                     [&parts](uint64_t points) { parts.push_back(points); }));

  ASSERT_GE(parts.size(), 2u);
  EXPECT_LE(std::ranges::max(parts), kPointsOfABatch);
}

TEST_F(FairTurnsTest, ALongerOneWaitsForAsMuchAsItTakesItself) {
  const Watched large = Watch(130, 1), medium = Watch(60, 1);
  const size_t l = large.chunks(), m = medium.chunks();
  // Evaluated and encoded, it is between two batches and three, and less than half of the large one.
  ASSERT_GT(2 * m, 2 * 256u);
  ASSERT_LE(2 * m, 3 * 256u);
  ASSERT_GT(m, 256u);
  ASSERT_GT(l, 5 * 256u);

  EditWhileHeld(Stage::kEncode, {&large, &medium});

  std::vector<size_t> order = Order(Stage::kEncode);
  order.resize(6);
  EXPECT_THAT(order, ElementsAre(l, l, l, m, m, l));
  ExpectRight(large);
  ExpectRight(medium);
}

TEST_F(FairTurnsTest, OnesOfTheSameSizeGoByTurnsOfAnUpdate) {
  const Watched first = Watch(90, 1), second = Watch(91, 1);
  const size_t a = first.chunks(), b = second.chunks();
  ASSERT_NE(a, b);

  EditWhileHeld(Stage::kEncode, {&first, &second});

  EXPECT_THAT(Order(Stage::kEncode), ElementsAre(a, a, a, b, b, b));
}

TEST_F(FairTurnsTest, AScenesOwnViewsAreNotLetAhead) {
  Watched large = Watch(90, 1);
  WatcherOptions options;
  options.max_unacked_updates = 0;
  options.view = large.client->watcher().view();
  options.view.key.spec.segments = 2;
  WatcherClient other(large.scene, options);
  other.RunToHead();

  EditWhileHeld(Stage::kEncode, {&large});
  other.RunToHead();

  EXPECT_EQ(Order(Stage::kEncode).size(), 6u) << "three batches of each";
  ExpectRight(large);
}

}  // namespace
}  // namespace latticed::testing
