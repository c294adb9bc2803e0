// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Registries of several servers over one store: a scene is at one of them at a time, and moves with all its edits.
#include <functional>
#include <future>
#include <memory>
#include <new>
#include <string>

#include <gtest/gtest.h>

#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "core/base/error.h"
#include "server/store/records/header_codec.h"
#include "server/store/shared_memory_store.h"
#include "tests/server/engine/engine_support.h"
#include "tests/server/support/scripted_backend.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

constexpr char kSharedScene[] = "scene-one";
constexpr absl::Duration kLong = absl::Minutes(1);

SceneConfig SharedConfig(const std::string& fingerprint = "") {
  SceneConfig config = MakeSceneConfig(kSharedScene);
  config.fingerprint = fingerprint;
  config.stored_header =
      EncodeHeader({.lattices = config.lattices, .create_time = config.create_time});
  return config;
}

void Pass(std::function<void()>& hook) {
  if (const auto called = std::exchange(hook, nullptr)) called();
}

// A store whose next call of a kind runs an action of the test first.
class HookedStore : public SharedMemoryStore {
 public:
  using SharedMemoryStore::SharedMemoryStore;

  absl::Status CreateScene(std::string_view id, std::string header) override {
    Pass(on_create);
    return SharedMemoryStore::CreateScene(id, std::move(header));
  }
  absl::Status DeleteScene(std::string_view id) override {
    Pass(on_delete);
    return SharedMemoryStore::DeleteScene(id);
  }
  absl::StatusOr<SceneLog> ReadScene(std::string_view id) override {
    Pass(on_read);
    return SharedMemoryStore::ReadScene(id);
  }
  absl::Status ReleaseScene(std::string_view id) override {
    Pass(on_release);
    return SharedMemoryStore::ReleaseScene(id);
  }

  std::function<void()> on_create, on_delete, on_read, on_release;
};

struct ServerOfMany {
  ServerOfMany(const std::shared_ptr<SharedMemory>& memory, const std::string& name)
      : store(memory, name),
        registry(&backend, 1,
                 SceneRegistry::Options{
                     .store = &store,
                     .config_of = [](std::string_view) { return MakeSceneConfig(kSharedScene); },
                     .mesh_of = [](std::string_view) { return "mesh"; },
                     .idle_ttl_of = [this](std::string_view) { return idle_ttl; }}) {}

  absl::Duration idle_ttl = absl::Hours(24);
  ScriptedBackend backend;
  HookedStore store;
  SceneRegistry registry;
};

class SharedScenesTest : public ::testing::Test {
 protected:
  static absl::Status Move(Scene& scene, uint64_t sequence, double x) {
    return scene.ApplyEdits(MoveBatch(scene, "ann", sequence, {62}, {x, 0, 0})).status();
  }
  static bool Await(const std::function<bool()>& done) {
    const absl::Time end = absl::Now() + absl::Minutes(1);
    while (!done() && absl::Now() < end) absl::SleepFor(absl::Milliseconds(1));
    return done();
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
  one_.registry.Retire(kLong);
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
  EXPECT_TRUE(Await([&] { return one_.registry.size() == 0; }));
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

TEST_F(SharedScenesTest, AMeshIsNotDeletedByForceWhileAnotherServerHasASceneOfIt) {
  ASSERT_OK(one_.registry.Create(SharedConfig()));
  bool removed = false;
  const auto remove = [&] {
    removed = true;
    return absl::OkStatus();
  };
  const absl::Status refused = two_.registry.DeleteMesh("mesh", true, remove);
  EXPECT_THAT(refused,
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       "scene 'scene-one' uses the mesh, on server 'one'; delete it first"));
  EXPECT_EQ(error::DetailsOf(refused).reason, "MESH_IN_USE");
  EXPECT_FALSE(removed);
  EXPECT_OK(one_.registry.Find(kSharedScene));

  EXPECT_OK(one_.registry.DeleteMesh("mesh", true, remove));
  EXPECT_TRUE(removed);
  EXPECT_THAT(two_.registry.Find(kSharedScene), StatusIs(absl::StatusCode::kNotFound));
}

// Else the watchdog would end a server whose store stands still.
TEST_F(SharedScenesTest, HousekeepingDoesNotWaitForTheStore) {
  absl::Notification waits, ends;
  one_.store.on_delete = [&] {
    waits.Notify();
    ends.WaitForNotification();
  };
  SceneConfig config = SharedConfig();
  config.idle_ttl = absl::Milliseconds(1);
  ASSERT_OK(one_.registry.Create(std::move(config)));
  ASSERT_TRUE(waits.WaitForNotificationWithTimeout(kLong));

  const uint64_t ticks = one_.registry.ticks();
  EXPECT_TRUE(Await([&] { return one_.registry.ticks() > ticks + 1; }));
  ends.Notify();
  EXPECT_TRUE(Await([&] { return one_.registry.size() == 0; }));
}

TEST_F(SharedScenesTest, ADrainDoesNotWaitForAStoreThatStandsStill) {
  ASSERT_OK_AND_ASSIGN(const auto scene, one_.registry.Create(SharedConfig()));
  absl::Notification ends;
  one_.store.on_release = [&] { ends.WaitForNotification(); };

  auto retired =
      std::async(std::launch::async, [&] { one_.registry.Retire(absl::Milliseconds(50)); });
  EXPECT_EQ(retired.wait_for(absl::ToChronoSeconds(kLong)), std::future_status::ready);
  EXPECT_TRUE(Await([&] { return scene->is_lost(); }));
  ExpectMoved(two_.registry.Find(kSharedScene).status(), "one");
  ends.Notify();
  EXPECT_TRUE(Await([&] { return two_.registry.Find(kSharedScene).ok(); }));
}

TEST_F(SharedScenesTest, ALostLeaseIsNotedWithoutWaiting) {
  class Slow : public SceneListener {
   public:
    void OnSceneChanged() override { ends.WaitForNotification(); }
    absl::Notification ends;
  };
  ASSERT_OK_AND_ASSIGN(const auto scene, one_.registry.Create(SharedConfig()));
  const auto slow = std::make_shared<Slow>();
  scene->AddListener(slow);

  auto fenced = std::async(std::launch::async, [&] { memory_->Fence("one"); });
  EXPECT_EQ(fenced.wait_for(absl::ToChronoSeconds(kLong)), std::future_status::ready);
  EXPECT_TRUE(scene->is_lost());
  slow->ends.Notify();
  EXPECT_TRUE(Await([&] { return one_.registry.size() == 0; }));
}

TEST_F(SharedScenesTest, ASceneThatIsMadeWhileItsServerLeavesIsReleased) {
  const auto leave = [&] { one_.registry.Retire(kLong); };
  one_.store.on_create = leave;
  ExpectMoved(one_.registry.Create(SharedConfig()).status(), "");
  EXPECT_OK(two_.registry.Find(kSharedScene));

  two_.registry.Retire(kLong);
  ServerOfMany three(memory_, "three"), four(memory_, "four");
  three.store.on_read = [&] { three.registry.Retire(kLong); };
  ExpectMoved(three.registry.Find(kSharedScene).status(), "");
  EXPECT_OK(four.registry.Find(kSharedScene));
}

TEST_F(SharedScenesTest, AReleasedSceneExpires) {
  ASSERT_OK(one_.registry.Create(SharedConfig()).status());
  const absl::Time later = absl::Now() + absl::Minutes(11);
  two_.idle_ttl = absl::ZeroDuration();
  two_.registry.Tick(later);
  EXPECT_OK(one_.registry.Find(kSharedScene).status()) << "a server has it";

  one_.registry.Retire(kLong);
  absl::SleepFor(absl::Milliseconds(1));
  two_.idle_ttl = absl::Hours(24);
  two_.registry.Tick(later + absl::Minutes(11));
  EXPECT_OK(two_.store.ReadSceneHeader(kSharedScene).status()) << "it was used lately";

  two_.idle_ttl = absl::Milliseconds(1);
  two_.registry.Tick(later + absl::Minutes(22));
  EXPECT_THAT(two_.registry.Find(kSharedScene), StatusIs(absl::StatusCode::kNotFound));
}

TEST_F(SharedScenesTest, WithoutMemoryAnIdStaysFree) {
  one_.store.on_create = [] { throw std::bad_alloc(); };
  EXPECT_THROW((void)one_.registry.Create(SharedConfig()), std::bad_alloc);

  const absl::Time end = absl::Now() + kLong;
  const auto stop = [&] {
    return absl::Now() < end ? absl::OkStatus() : absl::DeadlineExceededError("it is taken");
  };
  EXPECT_OK(one_.registry.Create(SharedConfig(), nullptr, stop).status());
}

TEST_F(SharedScenesTest, TheOldPlanOfALostSceneIsFreedBeforeTheNewOneIsMade) {
  ASSERT_OK_AND_ASSIGN(auto scene, one_.registry.Create(SharedConfig()));
  ASSERT_OK(Move(*scene, 1, 0.1));
  const std::weak_ptr<Scene> old = scene;
  scene->Lose().IgnoreError();
  scene.reset();

  bool freed = false;
  one_.store.on_read = [&] { freed = old.expired(); };
  ASSERT_OK_AND_ASSIGN(const auto again, one_.registry.Find(kSharedScene));
  EXPECT_TRUE(freed);
  EXPECT_EQ(again->State()->revision, 1u);
}

TEST(WakingScenesTest, ASceneThatWakesCountsOnce) {
  ScriptedBackend backend;
  MemoryStore store;
  ASSERT_OK(store.CreateScene(kSharedScene, SharedConfig().stored_header));
  absl::Notification wakes, ends;
  SceneRegistry registry(&backend, 1,
                         {.max_scenes = 2, .store = &store, .config_of = [&](std::string_view) {
                            wakes.Notify();
                            ends.WaitForNotification();
                            return MakeSceneConfig(kSharedScene);
                          }});
  registry.AddAsleep(kSharedScene, "mesh", absl::InfiniteFuture());
  auto woken = std::async(std::launch::async, [&] { return registry.Find(kSharedScene).status(); });
  ASSERT_TRUE(wakes.WaitForNotificationWithTimeout(kLong));

  SceneConfig config = SharedConfig();
  config.id = "scene-two";
  EXPECT_OK(registry.Create(config));
  ends.Notify();
  EXPECT_OK(woken.get());
  config.id = "scene-three";
  EXPECT_THAT(registry.Create(config), StatusIs(absl::StatusCode::kResourceExhausted));
}

}  // namespace
}  // namespace latticed::testing
