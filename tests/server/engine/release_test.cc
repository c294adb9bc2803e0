// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views and snapshots are destroyed with no lock held, for that may wait for a device: meanwhile
// everybody else is answered.
#include <chrono>
#include <future>
#include <thread>

#include "tests/server/engine/staged_scene.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

class ReleaseTest : public StagedScene {
 protected:
  // Whether `call` returns while the gate of `stage` is closed, which is opened then.
  bool ReturnsBefore(Stage stage, const std::function<void()>& call) {
    auto answer = std::async(std::launch::async, call);
    const bool returned = answer.wait_for(std::chrono::seconds(20)) == std::future_status::ready;
    gates().Open(stage);
    return returned;
  }
  // The key of a view that has vertices, and that nobody watches or works for: who made its update
  // may hold it for a moment longer than the watcher.
  ViewKey IdleView() {
    Watch();
    const ViewKey key = std::exchange(view_, nullptr)->key();
    EXPECT_TRUE(Becomes(2000, [&] { return scene_->GivableBytes() > 0; }));
    return key;
  }
  static ViewKey WithSegments(ViewKey key, int segments) {
    key.spec.segments = segments;
    return key;
  }
};

TEST_F(ReleaseTest, OfAViewThatWasIdleForLong) {
  const ViewKey key = IdleView();
  gates().Close(Stage::kDestroyView);

  std::thread housekeeper([&] { scene_->Tick(absl::Now() + absl::Minutes(2)); });
  EXPECT_TRUE(gates().WaitForBegun(Stage::kDestroyView, 1));

  EXPECT_TRUE(ReturnsBefore(Stage::kDestroyView, [&] { EXPECT_OK(scene_->AcquireView(key)); }));
  housekeeper.join();
  ExpectRight(*Watch());
}

TEST_F(ReleaseTest, OfAViewThatMakesRoomForAnother) {
  const ViewKey key = IdleView();
  for (int more = 1; more < limits::kMaxViewsPerScene; ++more) {
    ASSERT_OK(scene_->AcquireView(WithSegments(key, key.spec.segments + more)));
  }
  gates().Close(Stage::kDestroyView);

  std::thread watcher([&] { EXPECT_OK(scene_->AcquireView(WithSegments(key, 1))); });
  EXPECT_TRUE(gates().WaitForBegun(Stage::kDestroyView, 1)) << "the one idle longest";

  EXPECT_TRUE(ReturnsBefore(Stage::kDestroyView,
                            [&] { EXPECT_OK(scene_->AcquireView(WithSegments(key, 1))); }));
  watcher.join();
}

TEST_F(ReleaseTest, OfASnapshotThatItsLastReaderLetsGo) {
  const auto client = Watch();
  const uint64_t number = view_->PinNewest(0, /*takes_next=*/true)->number;
  Move(kCorner);
  client->RunToHead();
  gates().Close(Stage::kFreeChunk);

  std::thread reader([&] { view_->Unpin(number); });
  EXPECT_TRUE(gates().WaitForBegun(Stage::kFreeChunk, 1));

  EXPECT_TRUE(ReturnsBefore(Stage::kFreeChunk, [&] { EXPECT_NE(view_->newest(), nullptr); }));
  reader.join();
}

TEST_F(ReleaseTest, OfASnapshotThatIsRetired) {
  const auto client = Watch();
  for (int reader = 0; reader < limits::kMaxSnapshotsPerView; ++reader) {
    ASSERT_NE(view_->PinNewest(0, /*takes_next=*/true), nullptr);
    if (reader + 1 == limits::kMaxSnapshotsPerView) break;
    Move(kCorner);
    client->RunToHead();
  }
  const int freed = gates().begun(Stage::kFreeChunk);
  gates().Close(Stage::kFreeChunk);

  Move(kCorner);
  EXPECT_TRUE(gates().WaitForBegun(Stage::kFreeChunk, freed + 1));

  EXPECT_TRUE(ReturnsBefore(Stage::kFreeChunk, [&] { EXPECT_NE(view_->newest(), nullptr); }));
  ExpectRightAtHead(*client);
}

// A scene gives back; while its view is destroyed another watcher comes and has a view made.
TEST_F(ReleaseTest, OfAViewThatIsGivenBackWhileAnotherIsMade) {
  IdleView();
  gates().Close(Stage::kDestroyView);
  std::thread giver([&] { EXPECT_TRUE(scene_->GiveBack()) << "its view"; });
  EXPECT_TRUE(gates().WaitForBegun(Stage::kDestroyView, 1));

  std::unique_ptr<WatcherClient> client;
  EXPECT_TRUE(ReturnsBefore(Stage::kDestroyView, [&] { client = Watch(); }));
  giver.join();

  ASSERT_NE(client, nullptr);
  Move(kCorner);
  ExpectRightAtHead(*client);
  options_.view.key.spec.segments = 2;
  ExpectRight(*Watch());
  EXPECT_EQ(gates().begun(Stage::kPrepare), 1) << "the target that the first view uses was kept";
  EXPECT_FALSE(scene_->GiveBack()) << "it is watched";
}

TEST(ResidentTargetTest, IsNotGivenBackWhileAViewUsesIt) {
  StagedBackend backend(true);
  Residency residency(&backend);
  const SceneConfig config = MakeSceneConfig("scene-one");
  const auto plan = MakePlan(config.mesh, config.lattice.structure);
  ASSERT_OK(plan);
  const auto target = residency.Prepare(*plan, config.pipeline);
  ASSERT_OK(target);
  auto view = (*target)->CreateView(config.default_view.key.spec);
  ASSERT_OK(view);

  EXPECT_FALSE((*target)->GiveBack());
  ASSERT_OK((*target)->CreateView(config.default_view.key.spec));
  EXPECT_EQ(backend.gates().begun(Stage::kPrepare), 1);

  view->reset();
  EXPECT_TRUE((*target)->GiveBack());
  EXPECT_FALSE((*target)->GiveBack()) << "there is nothing left to give";
  ASSERT_OK((*target)->CreateView(config.default_view.key.spec));
  EXPECT_EQ(backend.gates().begun(Stage::kPrepare), 2);
}

}  // namespace
}  // namespace latticed::testing
