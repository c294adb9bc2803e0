// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Edits that change the structure of a scene. Other edits go on while the plan is made. A refused edit
// changes nothing.
#include <array>
#include <future>
#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/server/engine/engine_support.h"
#include "tests/server/support/scripted_backend.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

class StructureEditTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto scene = registry_.Create(MakeSceneConfig("scene-one"));
    ASSERT_OK(scene);
    scene_ = *scene;
  }
  void TearDown() override { script().Release(); }

  using Result = std::future<absl::StatusOr<EditSummary>>;
  Result ApplyBeside(EditBatch batch) {
    return std::async(std::launch::async, [scene = scene_, batch = std::move(batch)] {
      return scene->ApplyEdits(batch);
    });
  }

  Script& script() { return backend_.script(); }

  ScriptedBackend backend_;
  SceneRegistry registry_{&backend_, 1};
  std::shared_ptr<Scene> scene_;
};

TEST_F(StructureEditTest, AStructureThatChangedMeanwhileIsRefusedAndChangesNothing) {
  script().HoldNext(Step::kPrepare, 2);
  Result first = ApplyBeside(KnotBatch(*scene_, "alice", 1, 0, 0.3));
  Result second = ApplyBeside(KnotBatch(*scene_, "bob", 1, 1, 0.3));
  ASSERT_TRUE(script().WaitForHeld(2));
  script().Release();

  const auto alice = first.get();
  const auto bob = second.get();

  ASSERT_NE(alice.ok(), bob.ok());
  const absl::Status refused = alice.ok() ? bob.status() : alice.status();
  EXPECT_THAT(refused, StatusIs(absl::StatusCode::kAborted));
  EXPECT_EQ(error::DetailsOf(refused).reason, "STRUCTURE_CHANGED");
  EXPECT_EQ(scene_->State()->revision, 1u);
  EXPECT_EQ(scene_->State()->structure_id, 2u);
}

TEST_F(StructureEditTest, APlanThatCannotBeMadeRefusesTheEditOnceAndForReplay) {
  const EditBatch batch = KnotBatch(*scene_, "alice", 1, 0, 0.3);
  script().FailNext(Step::kPrepare, error::OutOfMemory("the plan", 3, 2));

  EXPECT_THAT(scene_->ApplyEdits(batch), StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_THAT(scene_->ApplyEdits(batch), StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_EQ(scene_->State()->revision, 0u);
  EXPECT_EQ(scene_->State()->structure_id, 1u);

  EXPECT_OK(scene_->ApplyEdits(KnotBatch(*scene_, "alice", 2, 0, 0.3)));
  EXPECT_EQ(scene_->State()->structure_id, 2u);
}

TEST_F(StructureEditTest, AStoppedPlanChangesNothingAndIsNotKeptForReplay) {
  const EditBatch batch = KnotBatch(*scene_, "alice", 1, 0, 0.3);
  for (const absl::Status& why :
       {absl::CancelledError("gone"), absl::DeadlineExceededError("late")}) {
    EXPECT_EQ(scene_->ApplyEdits(batch, [&why] { return why; }).status(), why);
    EXPECT_EQ(scene_->State()->revision, 0u);
    EXPECT_EQ(scene_->State()->structure_id, 1u);
  }

  const auto inserted = scene_->ApplyEdits(batch);

  ASSERT_OK(inserted);
  EXPECT_EQ(inserted->revision, 1u);
  EXPECT_EQ(inserted->structure_id, 2u);
}

// Counts the times that an edit asks whether to stop. By its first question about moments the plan is made.
TEST_F(StructureEditTest, MomentsForWeightsHoldUpNobodyAndMayBeStopped) {
  SceneConfig config = MakeSceneConfig("scene-two");
  config.mesh = std::make_shared<const PolygonMesh>(TorusMesh(12, 8));
  config.lattices = {*FitLattice(config.mesh->ComputeBounds(), {5, 5, 5}, {2, 2, 2}, 0.05)};
  ASSERT_OK_AND_ASSIGN(const auto scene, registry_.Create(std::move(config)));
  const auto weigh = [&](uint64_t sequence) {
    EditBatch batch = MoveBatch(*scene, "alice", sequence, {}, {});
    batch.edits = {SetWeights{{}, std::vector<float>(12 * 8, 0.5f)}};
    return batch;
  };
  int asked = 0;
  const auto count = [&] {
    ++asked;
    return absl::OkStatus();
  };
  ASSERT_OK(scene->ApplyEdits(weigh(1), count));
  const int of_plan = std::exchange(asked, 0);
  EXPECT_EQ(scene->State()->measures->MemoryBytes(), 0u);
  EditBatch keep = MoveBatch(*scene, "alice", 2, {}, {});
  keep.edits = {SetConstraints{{.volume = KeptVolume{}}}};
  ASSERT_OK(scene->ApplyEdits(keep));

  const auto stopped = scene->ApplyEdits(weigh(3), [&] {
    return ++asked > of_plan ? absl::CancelledError("gone") : absl::OkStatus();
  });
  EXPECT_THAT(stopped, StatusIs(absl::StatusCode::kCancelled));
  EXPECT_EQ(scene->State()->revision, 2u);

  asked = 0;
  const auto move = [&] {  // as another caller does
    return scene->ApplyEdits(MoveBatch(*scene, "bob", 1, {62}, {0.2, 0, 0})).status();
  };
  ASSERT_OK(scene->ApplyEdits(weigh(3), [&] {
    return ++asked == of_plan + 1 ? std::async(std::launch::async, move).get() : absl::OkStatus();
  }));
  EXPECT_EQ(asked, of_plan + 1);
  EXPECT_EQ(scene->State()->revision, 4u);
  EXPECT_GT(scene->State()->measures->MemoryBytes(), 0u);
}

TEST_F(StructureEditTest, ASceneThatIsDeletedMeanwhileRefusesTheEdit) {
  script().HoldNext(Step::kPrepare);
  Result knot = ApplyBeside(KnotBatch(*scene_, "alice", 1, 0, 0.3));
  ASSERT_TRUE(script().WaitForHeld());

  ASSERT_OK(registry_.Delete("scene-one"));
  script().Release();

  EXPECT_THAT(knot.get(), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_EQ(scene_->State()->revision, 0u);
}

TEST_F(StructureEditTest, UndoOfAKnotAlsoLetsOthersEdit) {
  ASSERT_OK(scene_->ApplyEdits(KnotBatch(*scene_, "alice", 1, 0, 0.3)));
  EditBatch undo = KnotBatch(*scene_, "alice", 2, 0, 0.3);
  undo.edits = {Undo{UndoScope::kMine}};
  script().HoldNext(Step::kPrepare);
  Result undone = ApplyBeside(undo);
  ASSERT_TRUE(script().WaitForHeld());

  Result move = ApplyBeside(MoveBatch(*scene_, "bob", 1, {0}, {-0.5, 0, 0}));
  ASSERT_EQ(move.wait_for(std::chrono::seconds(20)), std::future_status::ready)
      << "held up by the plan";
  ASSERT_OK(move.get());
  script().Release();

  // Bob has changed the lattice since alice inserted her knot.
  const auto result = undone.get();
  EXPECT_THAT(result, StatusIs(absl::StatusCode::kAborted));
  EXPECT_EQ(error::DetailsOf(result.status()).reason, "UNDO_CONFLICT");
  EXPECT_EQ(scene_->State()->structure_id, 2u);
  EXPECT_EQ(scene_->State()->revision, 2u);
}

}  // namespace
}  // namespace latticed::testing
