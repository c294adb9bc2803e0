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
