// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A long update lets shorter ones of other scenes ahead, in the order of one worker.
#include <algorithm>
#include <memory>
#include <numeric>
#include <string>
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

class FairTurnsTest : public ::testing::Test {
 protected:
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
  // Edits the first, and the others once that is held at the gate of `stage`; then lets all go.
  void EditWhileOneIsHeld(Stage stage, const std::vector<const Watched*>& scenes) {
    before_ = gates().order(stage).size();
    const int begun = gates().begun(stage);
    gates().Close(stage);
    Edit(*scenes.front());
    ASSERT_TRUE(gates().WaitForBegun(stage, begun + 1));
    for (size_t i = 1; i < scenes.size(); ++i) Edit(*scenes[i]);
    gates().Open(stage);
    for (const Watched* scene : scenes) scene->client->RunToHead();
  }
  // Of the calls that ended since.
  std::vector<size_t> Order(Stage stage) {
    const std::vector<size_t> all = gates().order(stage);
    return {all.begin() + static_cast<std::ptrdiff_t>(before_), all.end()};
  }
  static void ExpectRight(const Watched& watched) {
    const auto fresh = EvaluateAfresh(*watched.scene->State(), *watched.client->view());
    ASSERT_EQ(watched.client->chunks().size(), fresh.size());
    for (size_t c = 0; c < fresh.size(); ++c) {
      EXPECT_TRUE(std::ranges::equal(watched.client->chunks()[c].span(), fresh[c])) << c;
    }
  }

  StagedBackend backend_{/*on_device=*/false};
  SceneRegistry registry_{&backend_, /*workers=*/1};
  size_t before_ = 0;
};

TEST_F(FairTurnsTest, AShortUpdateWaitsForOneBatchOfALongEncoding) {
  const Watched large = Watch(90, 1), small = Watch(8, 1);
  ASSERT_GT(large.chunks(), 2 * 256u);
  ASSERT_LE(large.chunks(), 3 * 256u);

  EditWhileOneIsHeld(Stage::kEncode, {&large, &small});

  EXPECT_THAT(Order(Stage::kEncode),
              ElementsAre(large.chunks(), small.chunks(), large.chunks(), large.chunks()));
  ExpectRight(large);
  ExpectRight(small);
}

TEST_F(FairTurnsTest, AShortUpdateWaitsForOnePartOfALongEvaluation) {
  const Watched large = Watch(48, 32), small = Watch(8, 1);

  EditWhileOneIsHeld(Stage::kEvaluate, {&large, &small});

  EXPECT_THAT(Order(Stage::kEvaluate), ElementsAre(small.chunks(), large.chunks()));
  ExpectRight(large);
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

  EditWhileOneIsHeld(Stage::kEncode, {&large, &medium});

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

  EditWhileOneIsHeld(Stage::kEncode, {&first, &second});

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

  EditWhileOneIsHeld(Stage::kEncode, {&large});
  other.RunToHead();

  EXPECT_EQ(Order(Stage::kEncode).size(), 6u) << "three batches of each";
  ExpectRight(large);
}

}  // namespace
}  // namespace latticed::testing
