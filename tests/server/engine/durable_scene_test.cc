// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes with a store: nobody sees a revision before it is stored, a registry over the same store has the same scene with
// its history, and what the store refuses has not happened.
#include <atomic>
#include <memory>
#include <new>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/cpu/cpu_backend.h"
#include "server/store/memory_store.h"
#include "server/store/records/header_codec.h"
#include "server/store/records/scene_codec.h"
#include "tests/server/engine/engine_support.h"
#include "tests/server/support/scripted_backend.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

constexpr char kId[] = "scene-one";

SceneConfig StoredConfig() {
  SceneConfig config = MakeSceneConfig(kId);
  config.stored_header =
      EncodeHeader({.lattices = config.lattices, .create_time = config.create_time});
  return config;
}

// Stores records, and may say that it did not: as a database whose connection breaks before the answer comes.
class ForgetfulStore : public MemoryStore {
 public:
  void Append(std::string_view scene, uint64_t lsn, std::string record, Done done) override {
    MemoryStore::Append(scene, lsn, std::move(record),
                        [answer = answer_, done = std::move(done)](const absl::Status& status) {
                          done(answer.ok() ? status : answer);
                        });
  }
  void SetAnswer(absl::Status answer) { answer_ = std::move(answer); }

 private:
  absl::Status answer_;
};

class DurableSceneTest : public ::testing::Test {
 protected:
  void SetUp() override {
    Start();
    ASSERT_OK_AND_ASSIGN(scene_, registry_->Create(StoredConfig()));
  }

  void Start() {
    registry_ = std::make_unique<SceneRegistry>(
        &backend_, 1, SceneRegistry::Options{.store = &store_, .config_of = [](std::string_view) {
                                               return MakeSceneConfig(kId);
                                             }});
  }
  // As a server that is killed and started again.
  void Restart() {
    store_.Flush();
    scene_ = nullptr;
    registry_ = nullptr;
    Start();
    registry_->AddAsleep(kId, "mesh", absl::InfiniteFuture());
    ASSERT_OK_AND_ASSIGN(scene_, registry_->Find(kId));
  }
  absl::StatusOr<EditSummary> Move(const std::string& editor, uint64_t sequence, double x) {
    return scene_->ApplyEdits(MoveBatch(*scene_, editor, sequence, {62}, {x, 0, 0}));
  }
  EditBatch UndoBatch(const std::string& editor, uint64_t sequence) {
    return {.editor_id = editor,
            .sequence = sequence,
            .structure_id = scene_->State()->structure_id,
            .edits = {Undo{}}};
  }

  ForgetfulStore store_;
  ScriptedBackend backend_;
  std::unique_ptr<SceneRegistry> registry_;
  std::shared_ptr<Scene> scene_;
};

// A log may grow while its store takes no snapshots.
TEST_F(DurableSceneTest, CommitTimesOfALongLogAreBoundedAndAccounted) {
  constexpr uint64_t kRecords = kMostCommitTimes + 10;
  const auto time_of = [](uint64_t n) { return absl::UnixEpoch() + absl::Milliseconds(n); };
  EditHistory history(StoredConfig().lattices[0]);
  for (uint64_t n = 1; n <= kRecords; ++n) {
    const EditBatch batch = MoveBatch(*scene_, "ann", n, {62}, {1e-6, 0, 0});
    ASSERT_OK(history.Apply(batch, {}, [](const auto&) { return absl::OkStatus(); }));
    store_.Append(kId, n,
                  EncodeRecord({.edit = history.LastRecord(batch, {}), .commit_time = time_of(n)}),
                  [](const absl::Status& status) { EXPECT_OK(status); });
  }
  Restart();
  ASSERT_EQ(scene_->State()->revision, kRecords);
  EXPECT_EQ(scene_->CommitTime(kRecords), time_of(kRecords));
  EXPECT_EQ(scene_->CommitTime(kRecords + 1 - kMostCommitTimes),
            time_of(kRecords + 1 - kMostCommitTimes));
  EXPECT_EQ(scene_->CommitTime(kRecords - kMostCommitTimes), std::nullopt);
  const uint64_t with_times = scene_->memory().at("history");

  store_.PutSnapshot(
      kId, kRecords,
      EncodeImage({.histories = {history.image()}, .commit_time = time_of(kRecords)}));
  Restart();
  EXPECT_EQ(scene_->CommitTime(kRecords), time_of(kRecords));
  EXPECT_EQ(scene_->CommitTime(kRecords - 1), std::nullopt);
  EXPECT_EQ(with_times - scene_->memory().at("history"),
            (kMostCommitTimes - 1) * sizeof(CommitTimes::value_type));
}

TEST_F(DurableSceneTest, ASceneComesBackWithItsHistory) {
  ASSERT_OK(Move("ann", 1, 0.1));
  ASSERT_OK(Move("bob", 1, 0.2));
  ASSERT_OK(scene_->ApplyEdits(KnotBatch(*scene_, "ann", 2, 0, 0.3)));
  ASSERT_OK(Move("ann", 3, 0.3));
  EXPECT_FALSE(scene_->ApplyEdits(MoveBatch(*scene_, "bob", 2, {9999}, {})).ok());
  const auto before = scene_->State();

  Restart();
  const auto after = scene_->State();
  EXPECT_EQ(after->revision, 4u);
  EXPECT_EQ(after->structure_id, before->structure_id);
  EXPECT_EQ(after->lattices[0].structure(), before->lattices[0].structure());
  EXPECT_TRUE(std::ranges::equal(*after->control_points, *before->control_points, SameBits));
  EXPECT_EQ(after->box.id, before->box.id);
  EXPECT_TRUE(SameBits(after->box.origin, before->box.origin));
  EXPECT_EQ(after->box.range, before->box.range);

  // An edit that is sent again counts once, a refusal stays one, and what was done can be undone.
  ASSERT_OK_AND_ASSIGN(const auto again, Move("ann", 3, 0.3));
  EXPECT_EQ(again.revision, 4u);
  EXPECT_FALSE(scene_->ApplyEdits(MoveBatch(*scene_, "bob", 2, {3}, {})).ok());
  ASSERT_OK(scene_->ApplyEdits(UndoBatch("ann", 4)));
  ASSERT_OK(scene_->ApplyEdits(UndoBatch("ann", 5)));
  EXPECT_EQ(scene_->State()->control_points->size(), 125u);
  ASSERT_OK(scene_->ApplyEdits(UndoBatch("bob", 3)));
  ASSERT_OK(scene_->ApplyEdits(UndoBatch("ann", 6)));
  EXPECT_EQ(*scene_->State()->control_points, scene_->State()->plan->identity_points);
}

TEST_F(DurableSceneTest, NobodySeesWhatACrashCouldTakeBack) {
  store_.Pause();
  std::atomic<int> answers = 0;
  std::vector<uint64_t> revisions;
  for (uint64_t n = 1; n <= 3; ++n) {
    scene_->SubmitEdits(MoveBatch(*scene_, "ann", n, {62}, {0.1, 0, 0}), NeverStop,
                        [&](const absl::StatusOr<EditSummary>& summary) {
                          ASSERT_OK(summary);
                          revisions.push_back(summary->revision);
                          ++answers;
                        });
  }
  EXPECT_EQ(answers, 0);
  EXPECT_EQ(scene_->State()->revision, 0u);
  EXPECT_EQ(scene_->LatticeAfter(0).deltas.deltas.size(), 0u);

  store_.Resume();
  store_.Flush();
  EXPECT_EQ(answers, 3);
  EXPECT_EQ(revisions, (std::vector<uint64_t>{1, 2, 3}));
  EXPECT_EQ(scene_->State()->revision, 3u);
  EXPECT_EQ(scene_->LatticeAfter(0).deltas.deltas.size(), 3u);
}

TEST_F(DurableSceneTest, ARepeatedEditWaitsForTheFirstAnswer) {
  store_.Pause();
  std::vector<bool> answers;
  const EditBatch batch = MoveBatch(*scene_, "ann", 1, {62}, {0.1, 0, 0});
  for (int n = 0; n < 2; ++n) {
    scene_->SubmitEdits(batch, NeverStop,
                        [&](const auto& summary) { answers.push_back(summary.ok()); });
  }
  EXPECT_TRUE(answers.empty());
  store_.Resume();
  store_.Flush();
  EXPECT_EQ(answers, (std::vector<bool>{true, true}));
  EXPECT_EQ(scene_->State()->revision, 1u);
}

TEST_F(DurableSceneTest, WhatTheStoreRefusesHasNotHappened) {
  ASSERT_OK(Move("ann", 1, 0.1));
  store_.SetFailure(error::OutOfMemory("the disk", 3, 2));
  const auto refused = Move("ann", 2, 0.5);
  EXPECT_FALSE(refused.ok());
  EXPECT_FALSE(Move("ann", 2, 0.5).ok());
  EXPECT_EQ(scene_->State()->revision, 1u);

  store_.SetFailure(absl::OkStatus());
  ASSERT_OK_AND_ASSIGN(const auto second, Move("ann", 2, 0.2));
  EXPECT_EQ(second.revision, 2u);
  const auto before = scene_->State();
  Restart();
  EXPECT_EQ(scene_->State()->revision, 2u);
  EXPECT_EQ(*scene_->State()->control_points, *before->control_points);
}

TEST_F(DurableSceneTest, EditsInFlightWhenTheStoreFailsAreAllRefused) {
  ASSERT_OK(Move("ann", 1, 0.1));
  store_.Pause();
  std::vector<bool> answers;
  for (uint64_t n = 2; n <= 4; ++n) {
    scene_->SubmitEdits(MoveBatch(*scene_, "ann", n, {62}, {0.1, 0, 0}), NeverStop,
                        [&](const auto& summary) { answers.push_back(summary.ok()); });
  }
  store_.SetFailure(absl::UnavailableError("a cable was pulled"));
  store_.Resume();
  store_.Flush();
  EXPECT_EQ(answers, (std::vector<bool>{false, false, false}));
  EXPECT_EQ(scene_->State()->revision, 1u);

  store_.SetFailure(absl::OkStatus());
  ASSERT_OK_AND_ASSIGN(const auto next, Move("ann", 2, 0.2));
  EXPECT_EQ(next.revision, 2u);
}

// The store's answer says how sure it is: with kAborted it does not know, with another error the scene sees it later.
TEST_F(DurableSceneTest, WhatWasStoredWithoutAnAnswerIsFoundWhenTheSceneIsMadeAgain) {
  uint64_t sequence = 0;
  for (const absl::StatusCode code : {absl::StatusCode::kUnavailable, absl::StatusCode::kAborted}) {
    ASSERT_OK(Move("ann", ++sequence, 0.1));
    store_.SetAnswer(absl::Status(code, "the connection broke"));
    EXPECT_FALSE(Move("ann", ++sequence, 0.5).ok());
    store_.Flush();  // the answer counts as given a moment after it came
    EXPECT_EQ(scene_->is_lost(), code == absl::StatusCode::kAborted);
    EXPECT_EQ(scene_->State()->revision, sequence - 1);
    store_.SetAnswer(absl::OkStatus());
    const absl::Status lost = Move("ann", sequence, 0.5).status();
    EXPECT_EQ(error::DetailsOf(lost).reason, "SCENE_MOVED") << "the client is to ask again";
    EXPECT_TRUE(scene_->is_lost());
    EXPECT_TRUE(registry_->IsAsleep(kId));

    ASSERT_OK_AND_ASSIGN(scene_, registry_->Find(kId));
    EXPECT_EQ(scene_->State()->revision, sequence);
    ASSERT_OK_AND_ASSIGN(const auto again, Move("ann", sequence, 0.5));
    EXPECT_EQ(again.revision, sequence) << "it counts once";
  }
}

TEST_F(DurableSceneTest, AnAnswerThatFindsNoMemoryEndsTheSceneAndLosesNothing) {
  std::vector<absl::Status> answers;
  scene_->SubmitEdits(MoveBatch(*scene_, "ann", 1, {62}, {0.1, 0, 0}), NeverStop,
                      [&](const absl::StatusOr<EditSummary>& summary) {
                        answers.push_back(summary.status());
                        if (answers.size() == 1) throw std::bad_alloc();
                      });
  store_.Flush();
  ASSERT_EQ(answers.size(), 2u);
  EXPECT_OK(answers[0]);
  EXPECT_EQ(error::DetailsOf(answers[1]).reason, "SCENE_MOVED") << "the client is to ask again";

  ASSERT_OK_AND_ASSIGN(scene_, registry_->Find(kId));
  ASSERT_OK_AND_ASSIGN(const auto again, Move("ann", 1, 0.1));
  EXPECT_EQ(again.revision, 1u) << "it counts once";
}

TEST_F(DurableSceneTest, ALostSceneWaitsForAllAnswersBeforeItIsMadeAgain) {
  store_.Pause();
  std::atomic<int> answers = 0;
  for (uint64_t n = 1; n <= 3; ++n) {
    scene_->SubmitEdits(MoveBatch(*scene_, "ann", n, {62}, {0.1, 0, 0}), NeverStop,
                        [&](const auto&) { ++answers; });
  }
  scene_->Leave();
  std::thread answering([this] {
    absl::SleepFor(absl::Milliseconds(50));
    store_.Resume();
  });
  ASSERT_OK_AND_ASSIGN(const auto again, registry_->Find(kId));
  answering.join();
  EXPECT_EQ(answers, 3);
  EXPECT_EQ(again->State()->revision, 3u);
}

TEST_F(DurableSceneTest, AGestureThatTheStoreRefusedIsNotEnded) {
  ASSERT_OK(Move("ann", 1, 0.1));
  store_.SetFailure(absl::UnavailableError("a cable was pulled"));
  EditBatch drag = MoveBatch(*scene_, "ann", 2, {62}, {0.5, 0, 0});
  drag.gesture_id = "drag";
  EXPECT_FALSE(scene_->ApplyEdits(drag).ok());
  scene_->Tick(absl::Now() + absl::Seconds(61));
  EXPECT_EQ(scene_->State()->revision, 1u);

  store_.SetFailure(absl::OkStatus());
  ASSERT_OK_AND_ASSIGN(const auto next, Move("ann", 3, 0.1));
  EXPECT_EQ(next.revision, 2u);
}

TEST_F(DurableSceneTest, ANewLifeKnowsWhichEditsItHas) {
  ASSERT_OK(Move("ann", 7, 0.1));
  ASSERT_OK(Move("bob", 3, 0.1));
  Restart();
  EXPECT_EQ(scene_->AppliedSequence("ann", 2), 7u);
  EXPECT_EQ(scene_->AppliedSequence("ann", 1), 7u);
  EXPECT_EQ(scene_->AppliedSequence("bob", 2), 3u);
}

TEST_F(DurableSceneTest, ASnapshotBoundsWhatIsReplayed) {
  for (uint64_t n = 1; n <= 4'100; ++n) ASSERT_OK(Move(n % 2 == 0 ? "ann" : "bob", n, 0.001));
  store_.Flush();
  ASSERT_OK_AND_ASSIGN(const SceneLog log, store_.ReadScene(kId));
  EXPECT_EQ(log.snapshot_lsn, 4'096u);
  EXPECT_EQ(log.records.size(), 4u);

  const auto before = scene_->State();
  Restart();
  EXPECT_EQ(scene_->State()->revision, 4'100u);
  EXPECT_TRUE(
      std::ranges::equal(*scene_->State()->control_points, *before->control_points, SameBits));
  EXPECT_EQ(scene_->State()->box.id, before->box.id);
  ASSERT_OK(Move("ann", 4'102, 0.001));
  ASSERT_OK(scene_->ApplyEdits(UndoBatch("ann", 4'103)));
  ASSERT_OK(Move("bob", 4'101, 0.001));
  Restart();
  EXPECT_EQ(scene_->State()->revision, 4'103u);
}

TEST_F(DurableSceneTest, ADeletedSceneStaysDeleted) {
  ASSERT_OK(Move("ann", 1, 0.1));
  ASSERT_OK(registry_->Delete(kId));
  EXPECT_THAT(store_.ReadScene(kId), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(registry_->Find(kId), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_FALSE(Move("ann", 2, 0.1).ok());
}

TEST_F(DurableSceneTest, ASceneThatTheStoreCannotDeleteStays) {
  store_.SetFailure(absl::UnavailableError("a cable was pulled"));
  EXPECT_FALSE(registry_->Delete(kId).ok());
  store_.SetFailure(absl::OkStatus());
  EXPECT_OK(registry_->Find(kId));
  EXPECT_OK(Move("ann", 1, 0.1));
}

TEST_F(DurableSceneTest, ASleeperExpires) {
  store_.Flush();
  scene_ = nullptr;
  registry_ = nullptr;
  Start();
  registry_->AddAsleep(kId, "mesh", absl::Now() + absl::Seconds(60));
  registry_->Tick(absl::Now() + absl::Seconds(59));
  EXPECT_TRUE(registry_->IsAsleep(kId));
  registry_->Tick(absl::Now() + absl::Seconds(61));
  EXPECT_FALSE(registry_->IsAsleep(kId));
  EXPECT_THAT(store_.ReadScene(kId), StatusIs(absl::StatusCode::kNotFound));
}

TEST_F(DurableSceneTest, ASceneThatNobodyUsesSleepsUntilItIsCalled) {
  ASSERT_OK(Move("ann", 1, 0.1));
  const auto later = [] {
    return absl::Now() + absl::Seconds(limits::kStoredIdleSeconds) + absl::Seconds(1);
  };
  registry_->Tick(later());
  EXPECT_FALSE(registry_->IsAsleep(kId)) << "the test still has it";
  store_.Flush();
  scene_ = nullptr;
  registry_->Tick(absl::Now() + absl::Seconds(limits::kStoredIdleSeconds) - absl::Seconds(30));
  EXPECT_FALSE(registry_->IsAsleep(kId));
  registry_->Tick(later());
  EXPECT_TRUE(registry_->IsAsleep(kId));
  EXPECT_EQ(registry_->size(), 0u);
  ASSERT_OK_AND_ASSIGN(scene_, registry_->Find(kId));
  EXPECT_EQ(scene_->State()->revision, 1u);
  EXPECT_OK(Move("ann", 2, 0.2));
  EXPECT_OK(scene_->ApplyEdits(UndoBatch("ann", 3)));
  EXPECT_OK(scene_->ApplyEdits(UndoBatch("ann", 4)));
}

TEST_F(DurableSceneTest, ASceneWithPointsOfAClientDoesNotSleep) {
  CpuArena arena(1);
  const std::vector<Vec3d> points(10);
  ASSERT_OK_AND_ASSIGN(auto set, PointSet::Make("nodes", *scene_->State(), {points, {}, {}},
                                                scene_->backend(), nullptr, arena));
  const std::weak_ptr<PointSet> kept = set;
  ASSERT_OK(scene_->point_sets().Add(std::move(set)));
  store_.Flush();
  scene_ = nullptr;
  const absl::Time later = absl::Now() + absl::Seconds(2 * limits::kStoredIdleSeconds);
  registry_->Tick(later);
  EXPECT_FALSE(registry_->IsAsleep(kId));
  EXPECT_FALSE(kept.expired());

  ASSERT_OK_AND_ASSIGN(scene_, registry_->Find(kId));
  ASSERT_OK(scene_->point_sets().Remove("nodes"));
  EXPECT_TRUE(kept.expired());
  scene_ = nullptr;
  registry_->Tick(later);
  EXPECT_TRUE(registry_->IsAsleep(kId));
}

}  // namespace
}  // namespace latticed::testing
