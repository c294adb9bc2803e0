// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The budget --memory. A request that does not fit is refused before anything is made and changes nothing.
// The refusal says how many bytes were asked for and how many are free.
#include "server/engine/memory/memory_budget.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

TEST(MemoryBudget, GivesBackWhatIsReleasedAndNeverMoreThanItHas) {
  const auto budget = std::make_shared<MemoryBudget>(100);
  auto first = budget->Reserve("the first", 60);
  ASSERT_OK(first);

  const auto second = budget->Reserve("the second", 41);

  EXPECT_THAT(second, StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_EQ(error::DetailsOf(second.status()).asked_bytes, 41u);
  EXPECT_EQ(error::DetailsOf(second.status()).free_bytes, 40u);
  EXPECT_THAT(first->Resize("the first", 101), StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_EQ(budget->used_bytes(), 60u);
  EXPECT_OK(first->Resize("the first", 100));
  EXPECT_OK(first->Resize("the first", 10));
  MemoryReservation moved = *std::move(first);
  EXPECT_EQ(budget->used_bytes(), 10u);
  moved.Release();
  EXPECT_EQ(budget->used_bytes(), 0u);
}

TEST(MemoryBudget, KeepsTheMostThatWasAskedFor) {
  const auto budget = std::make_shared<MemoryBudget>(100);
  ASSERT_OK(budget->KeepAtLeast("the encoder", 60));
  ASSERT_OK(budget->KeepAtLeast("the encoder", 40));
  EXPECT_EQ(budget->used_bytes(), 60u);

  EXPECT_THAT(budget->KeepAtLeast("the encoder", 101),
              StatusIs(absl::StatusCode::kResourceExhausted));

  EXPECT_EQ(budget->kept_bytes(), 60u);
  ASSERT_OK(budget->KeepAtLeast("the encoder", 100));
  EXPECT_EQ(budget->used_bytes(), 100u);
}

TEST(MemoryBudget, ManyThreadsNeverPassIt) {
  const auto budget = std::make_shared<MemoryBudget>(1'000);
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 2'000; ++i) {
        const auto some = budget->Reserve("some", 400);
        EXPECT_LE(budget->used_bytes(), 1'000u);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(budget->used_bytes(), 0u);
}

// A scene of a plane. Its bytes are first measured on a server with enough memory.
class MemoryBudgetTest : public SceneFixture {
 protected:
  void SetUp() override {
    StartServer({});
    const std::string obj = PlaneObj(60);
    mesh_ = Upload(obj);
    v1::Scene scene;
    ASSERT_OK(Create(SceneRequest(), &scene));
    for (const auto& [purpose, bytes] : scene.bytes()) plan_bytes_ += bytes;
    ASSERT_GT(plan_bytes_, 500'000u);
  }

  // A server with memory for the mesh, its file, and `plans` times the bytes of the scene.
  void Restart(double plans) {
    const std::string obj = PlaneObj(60);
    constexpr uint64_t kMeshBytes = 61 * 61 * 24 + 3'600 * 5 * 4 + 4'096;
    StartServer({.memory_bytes = obj.size() + kMeshBytes +
                                 static_cast<uint64_t>(plans * static_cast<double>(plan_bytes_))});
    mesh_ = Upload(obj);
  }

  static void ExpectOutOfMemory(const absl::Status& status, const std::string& what) {
    ExpectRefused(status, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
    EXPECT_NE(status.message().find(what), std::string::npos) << status;
    EXPECT_GT(error::DetailsOf(status).asked_bytes, error::DetailsOf(status).free_bytes);
  }

  uint64_t plan_bytes_ = 0;
};

TEST_F(MemoryBudgetTest, AViewIsRefusedAndASmallerOneIsServed) {
  Restart(6);
  ASSERT_OK(Create(SceneRequest()));

  ExpectOutOfMemory(Update(32), "the view");

  EXPECT_OK(Update(2));
  auto watch = For<v1::WatchRequest>();
  watch.mutable_view()->set_segments(32);
  ExpectOutOfMemory(ReadAll(&Scenes::Watch, watch), "the view");
}

TEST_F(MemoryBudgetTest, AWatchIsRefusedWithoutRoomForAMessageThatItMayNotRead) {
  Restart(12);
  ASSERT_OK(Create(SceneRequest()));
  std::vector<std::unique_ptr<WatchClient>> watches;
  const auto open = [&] {
    watches.push_back(std::make_unique<WatchClient>(*scenes_, For<v1::WatchRequest>()));
    return watches.back()->Read();
  };
  ASSERT_TRUE(open());
  watches[0]->ReadUpdates(1);  // then the view has its reservation
  while (watches.size() < 100 && open()) continue;

  ExpectOutOfMemory(watches.back()->Finish(), "the stream's messages");
  EXPECT_GT(watches.size(), 3u);
  for (const auto& watch : watches) watch->Cancel();
}

TEST_F(MemoryBudgetTest, AnInsertedKnotNeedsRoomBesideThePlanInUse) {
  Restart(1.5);
  ASSERT_OK(Create(SceneRequest()));

  ExpectOutOfMemory(Apply(Knot("alice", 1)), "the scene's plan");

  const v1::LatticeState state = Lattice();
  EXPECT_EQ(state.revision(), 0u);
  EXPECT_EQ(state.structure_id(), 1u);
}

TEST_F(MemoryBudgetTest, ADeletedSceneGivesItsMemoryBack) {
  Restart(1.5);
  ASSERT_OK(Create(SceneRequest()));
  ExpectOutOfMemory(Create(SceneRequest("scene-two")), "the scene's plan");

  ASSERT_OK(DeleteScene());

  EXPECT_OK(OnceIdle([&] { return Create(SceneRequest("scene-two")); }));
}

TEST_F(MemoryBudgetTest, ACreationPastItsDeadlineGivesItsMemoryBack) {
  Restart(1.5);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(1));
  v1::Scene scene;
  EXPECT_EQ(scenes_->CreateScene(&context, SceneRequest(), &scene).error_code(),
            grpc::StatusCode::DEADLINE_EXCEEDED);

  ASSERT_OK(DeleteMeshOnceUnused()) << "a scene has come up";
  mesh_ = Upload(PlaneObj(60));
  EXPECT_OK(Create(SceneRequest("scene-two")));
}

TEST_F(MemoryBudgetTest, AnExportIsRefusedByItsName) {
  Restart(1.5);
  ASSERT_OK(Create(SceneRequest()));
  auto request = For<v1::ExportRequest>();
  request.set_format(v1::EXPORT_FORMAT_PLY);
  request.mutable_view()->set_segments(32);
  ExpectOutOfMemory(Export(request).status(), "the export");
}

// Scenes of a triangle in a lattice of many control points: only lattices and edits take memory.
class HistoryBudgetTest : public SceneFixture {
 protected:
  static constexpr int kSize = 16, kPoints = kSize * kSize * kSize;

  // A server with memory for one scene, and for `bytes` of edits beyond those that it reserves.
  void Restart(uint64_t bytes, int size = kSize) {
    mesh_ = Upload("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    ASSERT_OK(Create(TriangleScene("scene-one", size)));
    const uint64_t reserved = Info().reserved_host_bytes();
    // Four copies of the control points; and for a strength, those at rest, twice, the moved ones, twice, and rows of 48.
    EXPECT_EQ(Get().bytes().at("lattice"),
              static_cast<uint64_t>(8 * 24 * size * size * size + 3 * 48 * size));
    StartServer({.memory_bytes = reserved + bytes});
    mesh_ = Upload("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    ASSERT_OK(Create(TriangleScene("scene-one", size)));
  }
  v1::CreateSceneRequest TriangleScene(const std::string& id, int size) const {
    v1::CreateSceneRequest request = SceneRequest(id);
    auto& fit = *request.add_lattices()->mutable_fit();
    SetAxes(*fit.mutable_size(), size, size, size);
    SetAxes(*fit.mutable_degree(), 1, 1, 1);
    return request;
  }
  double FirstX() { return Lattice().lattice().control_points(0); }
  // Moves every control point.
  static v1::EditBatch MoveAll(const std::string& editor, uint64_t sequence, double x = 1) {
    v1::EditBatch batch = Move(editor, sequence, 0, x);
    auto& move = *batch.mutable_edits(0)->mutable_move_control_points();
    for (uint32_t i = 1; i < kPoints; ++i) move.add_indices(i);
    return batch;
  }
  static v1::EditBatch Undo(const std::string& editor, uint64_t sequence) {
    v1::EditBatch batch = Move(editor, sequence, 0, 0);
    batch.mutable_edits(0)->mutable_undo();
    return batch;
  }
  uint64_t MoveAllTimes(const std::string& editor, uint64_t times) {
    for (uint64_t n = 1; n <= times; ++n) EXPECT_OK(Apply(MoveAll(editor, n)));
    return times;
  }
};

TEST_F(HistoryBudgetTest, EditsTakeTheirMemoryFromTheBudget) {
  Restart(uint64_t{64} << 20);
  const uint64_t reserved = Info().reserved_host_bytes();

  MoveAllTimes("alice", 40);

  const uint64_t history = Get().bytes().at("history");
  EXPECT_GT(history, 2u * 40 * 28 * kPoints) << "steps to undo, and the log for watchers";
  // For edits, a scene first reserves 136 bytes per point and 16 KiB, and then 16 KiB at a time.
  const uint64_t beyond = history - (136u * kPoints + 16'384);
  EXPECT_EQ(Info().reserved_host_bytes() - reserved, (beyond + 16'383) / 16'384 * 16'384);
  EXPECT_EQ(Info().forgotten_undo_steps(), 0u);
}

TEST_F(HistoryBudgetTest, WithoutRoomTheOldestStepsAreForgottenAndNoEditIsRefused) {
  Restart(uint64_t{1} << 20);
  const double first_x = FirstX();

  uint64_t sequence = MoveAllTimes("alice", 40);

  EXPECT_LE(Info().reserved_host_bytes(), Info().limits().max_host_bytes());
  const uint64_t forgotten = Info().forgotten_undo_steps();
  EXPECT_GT(forgotten, 0u);
  EXPECT_NEAR(FirstX(), first_x + 40, 1e-9) << "what they did stays";
  uint64_t undone = 0;
  while (Apply(Undo("alice", ++sequence)).ok()) ++undone;
  EXPECT_GT(undone, 0u);
  EXPECT_EQ(undone, 40 - forgotten);
  EXPECT_NEAR(FirstX(), first_x + static_cast<double>(forgotten), 1e-9);
}

TEST_F(HistoryBudgetTest, AGestureGoesOnWithNoMemoryLeft) {
  Restart(0);
  const double first_x = FirstX();
  v1::EditBatch drag = MoveAll("alice", 1);
  drag.set_gesture_id("drag");
  for (uint64_t n = 1; n <= 20; ++n) {
    drag.set_sequence(n);
    drag.mutable_edits(0)->mutable_move_control_points()->mutable_offset()->set_x(
        static_cast<double>(n));
    ASSERT_OK(Apply(drag));
  }

  EXPECT_NEAR(FirstX(), first_x + 20, 1e-9) << "not the sum of offsets";
  EXPECT_EQ(Info().forgotten_undo_steps(), 0u);
  ASSERT_OK(Apply(Undo("alice", 21)));
  EXPECT_NEAR(FirstX(), first_x, 1e-9);
}

TEST_F(HistoryBudgetTest, ManyEditorsTakeNoMoreThanThereIs) {
  Restart(0, 10);
  constexpr uint64_t kEditors = 400;
  for (uint64_t n = 1; n <= kEditors; ++n) {
    ASSERT_OK(Apply(Move(fmt::format("{:060}", n), 1, 0, 0.001)));
  }

  EXPECT_LE(Get().bytes().at("history"), 136u * 1'000 + 16'384);
  v1::EditResult again;
  ASSERT_OK(Apply(Move(fmt::format("{:060}", kEditors), 1, 0, 0.001), &again));
  EXPECT_EQ(again.revision(), kEditors) << "what came twice is done once";
}

// The report of 15^3 boxes may take half a megabyte.
TEST_F(HistoryBudgetTest, AReportOfFoldsIsRefusedAndNoEditForIt) {
  Restart(1'000);
  ExpectRefused(Call(&Scenes::CertifyFolds, For<v1::CertifyFoldsRequest>()),
                absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");

  v1::EditBatch batch = Move("alice", 1, 0, 0.001);
  batch.set_refuse_folds(true);
  EXPECT_OK(Apply(batch));
}

TEST_F(HistoryBudgetTest, ScenesAreRefusedForTheirLattices) {
  Restart(uint64_t{100} * kPoints);
  ExpectRefused(Create(TriangleScene("scene-two", kSize)), absl::StatusCode::kResourceExhausted,
                "OUT_OF_MEMORY");
}

}  // namespace
}  // namespace latticed::testing
