// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene that is restored is the scene that was backed up, in every bit: on another server, and in another store.
#include <tuple>

#include "server/store/records/scene_log.pb.h"
#include "tests/server/backup/backup_fixture.h"
#include "tests/server/store/opened_store.h"

namespace latticed::testing {
namespace {

// A store of a kind of OpenedStore, or none.
class AnyStore {
 public:
  explicit AnyStore(const std::string& kind) {
    if (kind != "none") store_ = std::make_unique<OpenedStore>(kind);
  }
  std::shared_ptr<Store> Get() const {
    return store_ == nullptr ? nullptr : std::shared_ptr<Store>(&**store_, [](Store*) {});
  }

 private:
  std::unique_ptr<OpenedStore> store_;
};

// The bits of a history. The clock of a scene runs on without a store, and is told anew in each copy.
std::string BitsOf(const BackedUp& scene) {
  store::Image image;
  EXPECT_TRUE(image.ParseFromString(scene.content()));
  EXPECT_GT(image.commit_time(), 0);
  image.clear_now();
  image.clear_commit_time();
  return image.SerializeAsString();
}

class MovedScene : public BackupFixture,
                   public ::testing::WithParamInterface<std::tuple<const char*, const char*>> {
 protected:
  void SetUp() override { StartEmpty(from_.Get()); }
  void TearDown() override { server_.reset(); }  // before the stores

  // Edits of two editors, with a knot, a gesture, an undone step, and one that was refused.
  void MakeScene() {
    mesh_ = Upload(kGridObj);
    v1::CreateSceneRequest request = SceneRequest();
    request.set_name("a grid");
    (*request.mutable_labels())["kind"] = "test";
    ASSERT_OK(Create(request));
    ASSERT_OK(Apply(Move("ann", 1, 5, 0.1)));
    ASSERT_OK(Apply(Move("bob", 1, 6, 1e-17)));
    ASSERT_OK(Apply(Knot("ann", 2)));
    v1::EditBatch drag = Move("bob", 2, 7, 0.3);
    drag.set_structure_id(2);
    drag.set_gesture_id("a drag");
    drag.set_gesture_phase(v1::GESTURE_PHASE_UPDATE);
    ASSERT_OK(Apply(drag));
    ASSERT_FALSE(Apply(Move("bob", 3, 1'000'000, 1)).ok());
    v1::EditBatch again = Move("ann", 3, 8, -0.2);
    again.set_structure_id(2);
    ASSERT_OK(Apply(again));
    ASSERT_OK(Apply(UndoMine("ann", 4)));
  }

  // Down to before the knot.
  void RedoAndUndo() {
    ASSERT_OK(Apply(RedoMine("ann", 5)));
    ASSERT_OK(Apply(UndoMine("bob", 4)));
    ASSERT_OK(Apply(UndoMine("ann", 6)));
    ASSERT_OK(Apply(UndoMine("ann", 7)));
  }

  const AnyStore from_{std::get<0>(GetParam())};
  const AnyStore to_{std::get<1>(GetParam())};
};

TEST_P(MovedScene, HasEveryBit) {
  MakeScene();
  const std::string cube = Upload(CubeObj());
  const v1::Scene scene = Get();
  const v1::LatticeState lattice = Lattice();
  const std::string ply = Ply();
  ASSERT_OK_AND_ASSIGN(const BackupParts parts, Backup());
  RedoAndUndo();
  const v1::LatticeState undone = Lattice();

  StartEmpty(to_.Get());
  ASSERT_OK_AND_ASSIGN(const v1::RestoreResponse restored, Restore(parts));

  EXPECT_EQ(restored.meshes(), 2u);
  EXPECT_EQ(restored.scenes(), 1u);
  EXPECT_EQ(MeshCount(), 2);
  EXPECT_EQ(SceneCount(), 1);
  const v1::Scene again = Get();
  EXPECT_EQ(again.revision(), scene.revision());
  EXPECT_EQ(again.structure_id(), scene.structure_id());
  EXPECT_EQ(again.patches(), scene.patches());
  EXPECT_EQ(again.name(), "a grid");
  EXPECT_EQ(again.labels().at("kind"), "test");
  EXPECT_EQ(again.create_time().nanos(), scene.create_time().nanos());
  EXPECT_EQ(Lattice().lattice().SerializeAsString(), lattice.lattice().SerializeAsString());
  EXPECT_EQ(Ply(), ply);
  ASSERT_OK_AND_ASSIGN(const BackupParts copy, Backup());
  const auto first = ItemsOf(parts), second = ItemsOf(copy);
  ASSERT_EQ(first.size(), 3u);
  ASSERT_EQ(second.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(first[i].item.records(), second[i].item.records());
    if (first[i].item.has_mesh()) {
      EXPECT_EQ(first[i].content(), second[i].content());
    } else {
      EXPECT_EQ(BitsOf(first[i]), BitsOf(second[i]));
    }
  }

  // It goes on as the first one did: an edit that comes again counts once, and what can be undone is the same.
  v1::EditResult repeated;
  EXPECT_OK(Apply(UndoMine("ann", 4), &repeated));
  EXPECT_EQ(repeated.revision(), scene.revision());
  RedoAndUndo();
  EXPECT_EQ(Lattice().lattice().SerializeAsString(), undone.lattice().SerializeAsString());
  EXPECT_EQ(Lattice().structure_id(), undone.structure_id());
  EXPECT_OK(Create([&] {
    v1::CreateSceneRequest request = SceneRequest();
    request.set_name("a grid");
    (*request.mutable_labels())["kind"] = "test";
    return request;
  }()))
      << "the same request is the same scene";
}

TEST_P(MovedScene, WithoutEditsIsASceneWithoutEdits) {
  mesh_ = Upload(kGridObj);
  ASSERT_OK(Create(SceneRequest()));
  const v1::LatticeState lattice = Lattice();
  ASSERT_OK_AND_ASSIGN(const BackupParts parts, Backup());

  StartEmpty(to_.Get());
  ASSERT_OK(Restore(parts));

  EXPECT_EQ(Get().revision(), 0u);
  EXPECT_EQ(Lattice().lattice().SerializeAsString(), lattice.lattice().SerializeAsString());
  EXPECT_OK(Apply(Move("ann", 1, 5, 0.1)));
}

INSTANTIATE_TEST_SUITE_P(
    Stores, MovedScene,
    ::testing::Values(std::tuple("none", "none"), std::tuple("none", "sqlite"),
                      std::tuple("sqlite", "none"), std::tuple("memory", "shared_memory"),
                      std::tuple("sqlite", "postgres"), std::tuple("postgres", "sqlite")),
    [](const auto& info) {
      return fmt::format("{}_to_{}", std::get<0>(info.param), std::get<1>(info.param));
    });

}  // namespace
}  // namespace latticed::testing
