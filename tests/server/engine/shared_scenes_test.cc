// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Registries of several servers over one store: a scene is at one of them at a time, and moves with all its edits.
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "server/store/records/header_codec.h"
#include "server/store/shared_memory_store.h"
#include "tests/server/engine/engine_support.h"
#include "tests/server/support/scripted_backend.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

constexpr char kSharedScene[] = "scene-one";

SceneConfig SharedConfig(const std::string& fingerprint = "") {
  SceneConfig config = MakeSceneConfig(kSharedScene);
  config.fingerprint = fingerprint;
  config.stored_header =
      EncodeHeader({.lattice = config.lattice, .create_time = config.create_time});
  return config;
}

struct ServerOfMany {
  ServerOfMany(const std::shared_ptr<SharedMemory>& memory, const std::string& name)
      : store(memory, name),
        registry(&backend, 1,
                 SceneRegistry::Options{
                     .store = &store,
                     .config_of = [](std::string_view) { return MakeSceneConfig(kSharedScene); },
                     .mesh_of = [](std::string_view) { return "mesh"; }}) {}

  ScriptedBackend backend;
  SharedMemoryStore store;
  SceneRegistry registry;
};

class SharedScenesTest : public ::testing::Test {
 protected:
  static absl::Status Move(Scene& scene, uint64_t sequence, double x) {
    return scene.ApplyEdits(MoveBatch(scene, "ann", sequence, {62}, {x, 0, 0})).status();
  }
  static void ExpectMoved(const absl::Status& status, const std::string& owner) {
    EXPECT_THAT(status, StatusIs(absl::StatusCode::kUnavailable));
    const auto details = error::DetailsOf(status);
    EXPECT_EQ(details.reason, "SCENE_MOVED");
    EXPECT_EQ(details.metadata.at("owner"), owner);
    EXPECT_GT(details.retry_after_ms, 0u);
  }

  const std::shared_ptr<SharedMemory> memory_ = std::make_shared<SharedMemory>();
  ServerOfMany one_{memory_, "one"}, two_{memory_, "two"};
};

TEST_F(SharedScenesTest, AnotherServerNamesTheOwner) {
  ASSERT_OK_AND_ASSIGN(const auto scene, one_.registry.Create(SharedConfig()));
  ASSERT_OK(Move(*scene, 1, 0.1));
  ExpectMoved(two_.registry.Find(kSharedScene).status(), "one");
  ExpectMoved(two_.registry.Delete(kSharedScene), "one");
  EXPECT_THAT(two_.registry.Find("scene-two"), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_OK(Move(*scene, 2, 0.1));
}

TEST_F(SharedScenesTest, TheSameRequestIsSentToTheOwner) {
  ASSERT_OK(one_.registry.Create(SharedConfig("request")));
  ExpectMoved(two_.registry.Create(SharedConfig("request")).status(), "one");
}

TEST_F(SharedScenesTest, AServerThatLeavesHandsOverAllEdits) {
  ASSERT_OK_AND_ASSIGN(const auto scene, one_.registry.Create(SharedConfig()));
  ASSERT_OK(Move(*scene, 1, 0.1));
  ASSERT_OK(Move(*scene, 2, 0.2));
  one_.registry.Retire();
  ExpectMoved(Move(*scene, 3, 0.3), "");
  ASSERT_OK_AND_ASSIGN(const auto moved, two_.registry.Find(kSharedScene));
  EXPECT_EQ(moved->State()->revision, 2u);
  EXPECT_EQ(*moved->State()->control_points, *scene->State()->control_points);
  EXPECT_OK(Move(*moved, 3, 0.3));
  ExpectMoved(one_.registry.Find(kSharedScene).status(), "");  // it claims none any more
}

TEST_F(SharedScenesTest, AFencedServerLosesItsScenesAndWritesNothingMore) {
  ASSERT_OK_AND_ASSIGN(const auto scene, one_.registry.Create(SharedConfig()));
  ASSERT_OK(Move(*scene, 1, 0.1));
  memory_->Fence("one");
  ExpectMoved(Move(*scene, 2, 0.2), "");
  EXPECT_EQ(one_.registry.size(), 0u);
  ASSERT_OK_AND_ASSIGN(const auto moved, two_.registry.Find(kSharedScene));
  EXPECT_EQ(moved->State()->revision, 1u);
  EXPECT_OK(Move(*moved, 2, 0.2));
}

TEST_F(SharedScenesTest, AMeshIsInUseWhileAnyServerHasASceneOfIt) {
  ASSERT_OK(one_.registry.Create(SharedConfig()));
  EXPECT_EQ(two_.registry.UseOfMesh("mesh").scenes, 1u);
  const absl::Status refused =
      two_.registry.DeleteMesh("mesh", false, [] { return absl::OkStatus(); });
  EXPECT_EQ(error::DetailsOf(refused).reason, "MESH_IN_USE");
}

}  // namespace
}  // namespace latticed::testing
