// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes by id: creation, creations that are stopped, meshes in use, and the removal of idle scenes.
#include <atomic>
#include <future>

#include <gtest/gtest.h>

#include "absl/time/clock.h"
#include "core/base/error.h"
#include "core/cpu/cpu_backend.h"
#include "tests/server/engine/engine_support.h"
#include "tests/server/support/scripted_backend.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

class SceneRegistryTest : public ::testing::Test {
 protected:
  std::unique_ptr<Backend> backend_ = MakeCpuBackend({.threads = 2});
  SceneRegistry registry_{backend_.get(), 2};
};

TEST_F(SceneRegistryTest, AnIdleSceneIsEvictedAndAWatchedOneStays) {
  SceneConfig config = MakeSceneConfig("scene-idle");
  config.idle_ttl = absl::Hours(1);
  ASSERT_OK(registry_.Create(config));
  config.id = std::string("scene-watched");
  const auto watched = registry_.Create(config);
  ASSERT_OK(watched);
  WatcherClient client(*watched, {.view = config.default_view});

  registry_.Tick(absl::Now() + absl::Hours(2));

  EXPECT_THAT(registry_.Find("scene-idle"), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_OK(registry_.Find("scene-watched"));
}

TEST(DeleteMeshTest, ASceneInTheMakingHoldsItsMesh) {
  ScriptedBackend backend;
  SceneRegistry registry(&backend, 1);
  backend.script().HoldNext(Step::kPrepare);
  auto scene =
      std::async(std::launch::async, [&] { return registry.Create(MakeSceneConfig("scene-one")); });
  ASSERT_TRUE(backend.script().WaitForHeld());
  bool removed = false;
  const auto remove = [&removed] {
    removed = true;
    return absl::OkStatus();
  };

  EXPECT_EQ(registry.UseOfMesh("grid").scenes, 1u);
  const absl::Status status = registry.DeleteMesh("grid", false, remove);
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kFailedPrecondition));
  EXPECT_EQ(error::DetailsOf(status).reason, "MESH_IN_USE");
  EXPECT_FALSE(removed);

  EXPECT_OK(registry.DeleteMesh("grid", true, remove));
  EXPECT_TRUE(removed);
  backend.script().Release();
  EXPECT_THAT(scene.get(), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_EQ(registry.size(), 0u);
}

TEST_F(SceneRegistryTest, WhatAdmitRefusesIsNotMade) {
  const auto refuse = [] { return error::NotFound("mesh", "grid"); };

  EXPECT_THAT(registry_.Create(MakeSceneConfig("scene-one"), refuse),
              StatusIs(absl::StatusCode::kNotFound));

  EXPECT_EQ(registry_.size(), 0u);
  EXPECT_OK(registry_.Create(MakeSceneConfig("scene-one")));
}

TEST(StopTest, AStoppedCreationLeavesNoSceneAndNoMemory) {
  ScriptedBackend backend;
  const auto memory = std::make_shared<MemoryBudget>(uint64_t{1} << 30);
  SceneRegistry registry(&backend, 1, {.memory = memory});
  const SceneConfig config = MakeSceneConfig("scene-one");
  std::atomic<bool> late = false;
  const auto stop = [&late] {
    return late ? absl::DeadlineExceededError("late") : absl::OkStatus();
  };
  backend.script().HoldNext(Step::kPrepare);
  auto scene =
      std::async(std::launch::async, [&] { return registry.Create(config, nullptr, stop); });
  ASSERT_TRUE(backend.script().WaitForHeld());
  EXPECT_GT(memory->used_bytes(), 0u);

  late = true;
  backend.script().Release();

  EXPECT_THAT(scene.get(), StatusIs(absl::StatusCode::kDeadlineExceeded));
  EXPECT_EQ(registry.size(), 0u);
  EXPECT_EQ(registry.UseOfMesh("grid").scenes, 0u);
  EXPECT_EQ(memory->used_bytes(), 0u);
  EXPECT_OK(registry.Create(config)) << "the id is free";
}

TEST(StopTest, WhoWaitsForTheSameSceneStopsToo) {
  ScriptedBackend backend;
  SceneRegistry registry(&backend, 1);
  const SceneConfig config = MakeSceneConfig("scene-one");
  const auto gone = [] { return absl::CancelledError("gone"); };
  backend.script().HoldNext(Step::kPrepare);
  auto scene = std::async(std::launch::async, [&] { return registry.Create(config); });
  ASSERT_TRUE(backend.script().WaitForHeld());

  auto again =
      std::async(std::launch::async, [&] { return registry.Create(config, nullptr, gone); });
  EXPECT_EQ(again.wait_for(std::chrono::seconds(20)), std::future_status::ready);
  backend.script().Release();

  EXPECT_THAT(again.get(), StatusIs(absl::StatusCode::kCancelled));
  EXPECT_OK(scene.get());
}

}  // namespace
}  // namespace latticed::testing
