// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lattices that edits remove from a scene: what is left, undo and redo, watchers, restarts.
#include <algorithm>
#include <string>
#include <vector>

#include "tests/server/lattices/removed_fixture.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

constexpr char kLeft[] = "left-scene";  // created without the lattice that is removed

TEST_F(RemovedLatticesTest, TheSceneIsAsIfItHadNeverHadIt) {
  const v1::Lattice one = Shaken(Whole()), other = Shaken(Spot()), third = Shaken(Spot({1, 2, 3}));
  const std::vector<v1::Lattice> all{one, other, third};
  const std::vector<Vec3d> world = SomePoints(100);
  for (uint32_t gone = 0; gone < 3; ++gone) {
    std::vector<v1::Lattice> rest = all;
    rest.erase(rest.begin() + gone);
    ASSERT_OK(Create(RequestOf(all)));
    ASSERT_OK(Create(RequestOf(rest, kLeft)));
    v1::EditResult result;

    ASSERT_OK(Apply(Remove(gone), &result));

    EXPECT_EQ(result.structure_id(), 2u);
    EXPECT_EQ(result.revision(), 1u);
    EXPECT_EQ(Evaluate(world), Evaluate(world, kLeft)) << gone << ", seed " << kSeed;
    EXPECT_EQ(Get().patches(), Get(kLeft).patches());
    Numbered left{0, 1, 2};
    left.erase(left.begin() + gone);
    EXPECT_EQ(Numbers(), left);
    for (size_t n = 0; n < 2; ++n) {  // the others keep their numbers
      const v1::LatticeState state = LatticeAt(left[n]);
      EXPECT_EQ(Numbered(state.indexes().begin(), state.indexes().end()), left);
      EXPECT_EQ(
          std::vector<double>(state.lattice().control_points().begin(),
                              state.lattice().control_points().end()),
          std::vector<double>(rest[n].control_points().begin(), rest[n].control_points().end()));
    }
    ExpectRefused(GetLattice(gone), Code::kInvalidArgument, "OUT_OF_RANGE", "lattice");
    ASSERT_OK(Apply(Push(left[1], 21, {0.05, 0, 0})));
    EXPECT_NE(Evaluate(world), Evaluate(world, kLeft));
    for (const char* id : {kScene, kLeft}) ASSERT_OK(DeleteScene(id));
  }
}

TEST_F(RemovedLatticesTest, UndoGivesItBackWithItsPointsConstraintsAndSteps) {
  ASSERT_OK(Create(RequestOf({Whole(), Spot()})));
  const std::vector<Vec3d> world = SomePoints(50);
  const auto first = Evaluate(world);
  ASSERT_OK(Apply(Push(1, 21, {0.05, 0, 0})));
  v1::EditBatch hold = Batch(1);
  hold.add_edits()->mutable_set_constraints()->mutable_constraints()->add_held(5);
  ASSERT_OK(Apply(hold));
  v1::EditBatch strength = Batch(1);
  strength.add_edits()->mutable_set_strength()->set_strength(0.5);
  ASSERT_OK(Apply(strength));
  const auto before = Evaluate(world);
  v1::LatticeState state = LatticeAt(1);

  ASSERT_OK(Apply(Remove(1)));
  const auto without = Evaluate(world);
  EXPECT_NE(without, before);
  ASSERT_OK(Apply(Undo(1)));

  EXPECT_EQ(Evaluate(world), before);
  state.set_structure_id(3);
  state.set_revision(5);
  EXPECT_EQ(LatticeAt(1).SerializeAsString(), state.SerializeAsString());
  ASSERT_OK(Apply(Redo(1)));
  EXPECT_EQ(Evaluate(world), without);
  EXPECT_EQ(Numbers(), Numbered{0});
  for (int n = 0; n < 4; ++n) ASSERT_OK(Apply(Undo(1)));  // removal, strength, hold, push
  EXPECT_EQ(Evaluate(world), first);
  ExpectRefused(Apply(Undo(1)), Code::kFailedPrecondition, "NOTHING_TO_UNDO");
}

TEST_F(RemovedLatticesTest, TheOthersKeepTheirUndoSteps) {
  ASSERT_OK(Create(RequestOf({Whole(), Spot(), Spot()})));
  const std::string at_rest = LatticeAt(2).lattice().SerializeAsString();
  ASSERT_OK(Apply(Push(2, 21, {0.05, 0, 0})));
  ASSERT_OK(Apply(Remove(1)));
  ASSERT_OK(Apply(Undo(2)));
  EXPECT_EQ(LatticeAt(2).lattice().SerializeAsString(), at_rest);
  EXPECT_EQ(Numbers(), (Numbered{0, 2}));
}

TEST_F(RemovedLatticesTest, AWatcherFollows) {
  ASSERT_OK(Create(RequestOf({Whole(), Spot(), Spot({1, 1, 1})})));
  WatchClient watcher(*scenes_, RawWatch());
  watcher.ReadUpdates(1);
  ASSERT_EQ(watcher.log.others.size(), 2u);

  ASSERT_OK(Apply(Remove(1)));
  watcher.ReadUntilRevision(1);
  ASSERT_EQ(watcher.log.others.size(), 1u);
  EXPECT_EQ(watcher.log.lattice.structure_id(), 2u);
  ASSERT_OK(Apply(Push(2, 21, {0.05, 0, 0})));
  watcher.ReadUntilRevision(2);
  EXPECT_EQ(watcher.log.deltas, 1u);
  EXPECT_EQ(watcher.log.others.at(2).lattice().SerializeAsString(),
            LatticeAt(2).lattice().SerializeAsString());
  watcher.ReadUntil([&] { return watcher.log.ends.back().full_detail(); });
  auto now = For<v1::GetUpdateRequest>();
  *now.mutable_view() = RawWatch().view();
  EventLog fresh;
  ASSERT_OK(Update(now, fresh));
  ASSERT_FALSE(fresh.chunks.empty());
  for (const auto& [index, chunk] : fresh.chunks) {  // there were more before the removal
    EXPECT_EQ(watcher.log.chunks.at(index), chunk) << index;
  }
  ASSERT_OK(Apply(Undo(1)));
  watcher.ReadUntilRevision(3);
  EXPECT_EQ(watcher.log.others.size(), 2u);
}

TEST_F(RemovedLatticesTest, ARestartKeepsWhatIsLeftAndWhatUndoGivesBack) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole()), Shaken(Spot()), Shaken(Spot({1, 1, 1}))})));
  const std::vector<Vec3d> world = SomePoints(50);
  ASSERT_OK(Apply(Push(0, 42, {0, 0.1, 0})));
  const auto all = Evaluate(world);
  ASSERT_OK(Apply(Remove(0)));
  ASSERT_OK(Apply(Remove(2)));
  ASSERT_OK(Apply(Put(2, Shaken(Spot({3, 2, 1})))));
  ASSERT_OK(Apply(Undo(2)));
  ASSERT_OK(Apply(Push(1, 21, {0.05, 0, 0})));
  const auto before = Chunks();

  for (int i = 0; i < 2; ++i) {
    Restart();
    EXPECT_TRUE(Chunks() == before);
    EXPECT_EQ(Numbers(), Numbered{1});
    EXPECT_EQ(Get().revision(), 6u);
    EXPECT_EQ(Get().structure_id(), 5u);
  }
  ASSERT_OK(Apply(Undo(1)));
  ASSERT_OK(Apply(Undo(2)));
  ASSERT_OK(Apply(Undo(0)));
  Restart();
  EXPECT_EQ(Numbers(), (Numbered{0, 1, 2}));
  EXPECT_EQ(Evaluate(world), all);
  ASSERT_OK(Apply(Undo(0)));  // the push
  EXPECT_NE(Evaluate(world), all);
}

TEST_F(RemovedLatticesTest, AnotherLatticeInItsPlaceBeginsAfresh) {
  const v1::Lattice other = Shaken(Spot({1, 2, 3}));
  ASSERT_OK(Create(RequestOf({Whole(), Shaken(Spot())})));
  ASSERT_OK(Create(RequestOf({Whole(), other}, kLeft)));
  v1::EditBatch strength = Batch(1);
  strength.add_edits()->mutable_set_strength()->set_strength(0.5);
  ASSERT_OK(Apply(strength));
  v1::EditBatch keep = Batch(1);
  keep.add_edits()->mutable_set_constraints()->mutable_constraints()->mutable_volume();
  ASSERT_OK(Apply(keep));
  const std::vector<Vec3d> world = SomePoints(50);
  const auto first = Evaluate(world);
  ASSERT_OK(Apply(Remove(1)));
  const auto without = Evaluate(world);

  ASSERT_OK(Apply(Put(1, other)));

  EXPECT_EQ(Numbers(), (Numbered{0, 1}));
  EXPECT_EQ(Evaluate(world), Evaluate(world, kLeft));
  EXPECT_FALSE(LatticeAt(1).has_strength());
  EXPECT_FALSE(LatticeAt(1).has_constraints());
  ASSERT_OK(Apply(Undo(1)));
  EXPECT_EQ(Evaluate(world), without);
  EXPECT_EQ(Numbers(), Numbered{0});
  ASSERT_OK(Apply(Undo(1)));
  EXPECT_EQ(Evaluate(world), first);
  EXPECT_EQ(LatticeAt(1).strength(), 0.5);
}

TEST_F(RemovedLatticesTest, TheFirstMayGoAndWeightsStay) {
  v1::CreateSceneRequest request = RequestOf({Shaken(Whole()), Shaken(Whole({1, 1, 1}))});
  const std::vector<float> weights{1, 0.5f, 1, 1, 0, 1, 1, 1}, half(8, 0.5f);
  const auto bytes = [](const std::vector<float>& w) {
    return std::string(reinterpret_cast<const char*>(w.data()), w.size() * sizeof(float));
  };
  request.mutable_weights()->set_values(bytes(weights));
  ASSERT_OK(Create(request));
  request = RequestOf({LatticeAt(1).lattice()}, kLeft);
  request.mutable_weights()->set_values(bytes(weights));
  ASSERT_OK(Create(request));
  v1::CreateSceneRequest halves = request;
  halves.set_scene_id("halves-scene");
  halves.mutable_weights()->set_values(bytes(half));
  ASSERT_OK(Create(halves));
  const auto positions = [this](const std::string& scene) {
    auto corners = For<v1::EvaluatePointsRequest>(scene);
    for (uint32_t face = 0; face < 6; ++face) {
      auto& point = *corners.mutable_surface_points()->add_points();
      point.set_face(face);
      for (uint32_t corner = 0; corner < 3; ++corner) {
        point.add_corners(4 * face + corner);
        point.add_barycentrics(corner == 0 ? 0.5 : 0.25);
      }
    }
    v1::EvaluatePointsResponse response;
    EXPECT_OK(Call(&Scenes::EvaluatePoints, corners, &response));
    return std::vector<double>(response.positions().begin(), response.positions().end());
  };

  ASSERT_OK(Apply(Remove(0)));
  EXPECT_EQ(positions(kScene), positions(kLeft));
  v1::EditBatch weigh = Batch(0);
  weigh.add_edits()->mutable_set_weights()->set_values(bytes(half));
  ASSERT_OK(Apply(weigh));
  EXPECT_EQ(positions(kScene), positions("halves-scene"));
  Restart();
  EXPECT_EQ(positions(kScene), positions("halves-scene"));
  EXPECT_EQ(Numbers(), Numbered{1});
  ASSERT_OK(Apply(Undo(0)));  // the weights
  EXPECT_EQ(positions(kScene), positions(kLeft));
  ASSERT_OK(Apply(Undo(0)));
  EXPECT_EQ(Numbers(), (Numbered{0, 1}));
}

TEST_F(RemovedLatticesTest, WeightsRestoreTheVolumeThatLatticeZeroKeeps) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole()), Shaken(Whole({1, 1, 1})), Spot()})));
  ASSERT_OK(Apply(Remove(2)));
  v1::EditBatch keep = Batch(0);
  keep.add_edits()->mutable_set_constraints()->mutable_constraints()->mutable_volume();
  ASSERT_OK(Apply(keep));
  const std::string other = LatticeAt(1).lattice().SerializeAsString();
  const std::vector<float> weights = {0, 1, 1, 0, 0.5f, 1, 0.75f, 0.25f};
  const auto weigh = [&] {
    v1::EditBatch batch = Batch(0);
    batch.add_edits()->mutable_set_weights()->set_values(
        reinterpret_cast<const char*>(weights.data()), weights.size() * sizeof(float));
    return batch;
  };
  ASSERT_OK(Apply(weigh()));
  EXPECT_NEAR(MeasuredVolume(), 1, 1e-12);
  EXPECT_EQ(LatticeAt(1).lattice().SerializeAsString(), other);

  ASSERT_OK(Apply(Undo(0)));
  ASSERT_OK(Apply(Remove(0, "bob")));
  ExpectRefused(Apply(Redo(0)), Code::kFailedPrecondition, "LATTICE_REMOVED");
  v1::EditBatch kept = weigh();
  kept.mutable_keep_volume();
  ExpectRefused(Apply(kept), Code::kFailedPrecondition, "LATTICE_REMOVED");
  EXPECT_OK(Apply(weigh()));
}

TEST_F(RemovedLatticesTest, RequestsNameWhatIsLeft) {
  ASSERT_OK(Create(RequestOf({Whole(), Shaken(Spot({1, 1, 1})), Shaken(Whole({3, 3, 3}))})));
  ASSERT_OK(Apply(Remove(1)));
  auto measure = For<v1::MeasureSceneRequest>();
  measure.add_measures(v1::MEASURE_VOLUME);
  measure.set_with_gradient(true);
  v1::MeasureSceneResponse got;
  measure.set_lattice(1);
  ExpectRefused(Call(&Scenes::MeasureScene, measure, &got), Code::kInvalidArgument, "OUT_OF_RANGE",
                "lattice");
  measure.set_lattice(2);
  ASSERT_OK(Call(&Scenes::MeasureScene, measure, &got));
  constexpr double kStep = 1e-6;
  constexpr int kIndex = 21;
  const double volume = got.volume(), slope = got.volume_gradient(3 * kIndex + 2);
  ASSERT_OK(Apply(Push(2, kIndex, {0, 0, kStep})));
  ASSERT_OK(Call(&Scenes::MeasureScene, measure, &got));
  EXPECT_NEAR((got.volume() - volume) / kStep, slope, 1e-7);

  v1::EditBatch batch = Batch(2);
  auto& drag = *batch.add_edits()->mutable_drag_points();
  auto& point = *drag.add_points();
  for (const uint32_t corner : {0u, 1u, 2u}) point.add_corners(corner);
  for (const double b : {0.5, 0.25, 0.25}) point.add_barycentrics(b);
  const Vec3d target{0.55, 0.8, 0.05};
  for (int a = 0; a < 3; ++a) drag.add_targets(target[a]);
  ASSERT_OK(Apply(batch));
  EXPECT_LE(Norm(Evaluate(Vec3d{0.5, 0.75, 0}) - target), 1e-12);
}

TEST_F(RemovedLatticesTest, MeasuresWithoutDerivativesNameNoLattice) {
  ASSERT_OK(Create(RequestOf({Whole(), Shaken(Whole({1, 1, 1}))})));
  ASSERT_OK(Create(RequestOf({LatticeAt(1).lattice()}, kLeft)));
  ASSERT_OK(Apply(Remove(0)));
  auto measure = For<v1::MeasureSceneRequest>();
  for (const auto what :
       {v1::MEASURE_VOLUME, v1::MEASURE_AREA, v1::MEASURE_CENTROID, v1::MEASURE_BOUNDS}) {
    measure.add_measures(what);
  }
  v1::MeasureSceneResponse got, left;
  ASSERT_OK(Call(&Scenes::MeasureScene, measure, &got));
  measure.set_scene(kLeft);
  ASSERT_OK(Call(&Scenes::MeasureScene, measure, &left));
  EXPECT_NEAR(got.volume(), left.volume(), 1e-12);
  EXPECT_NEAR(got.area(), left.area(), 1e-12);
  EXPECT_NEAR(got.centroid().x(), left.centroid().x(), 1e-12);
  EXPECT_NEAR(got.greatest().x(), left.greatest().x(), 1e-12);
  EXPECT_EQ(got.area_gradient_size(), 0);

  measure.set_scene(kScene);
  measure.set_with_gradient(true);
  ExpectRefused(Call(&Scenes::MeasureScene, measure, &got), Code::kInvalidArgument, "OUT_OF_RANGE",
                "lattice");
}

TEST_F(RemovedLatticesTest, AnOpenViewOfPatchesGoesOnWithoutASum) {
  ASSERT_OK(Create(RequestOf({Whole(), Shaken(Whole({1, 1, 1}))})));
  v1::WatchRequest patches = For<v1::WatchRequest>();
  patches.mutable_view()->set_encoding(v1::ENCODING_PATCHES);
  patches.set_max_unacked_updates(10);
  WatchClient watcher(*scenes_, patches);
  watcher.ReadUpdates(1);
  const auto sums = [&] {
    return std::ranges::count_if(watcher.log.events,
                                 [](const auto& event) { return event.has_patch_lattice(); });
  };
  EXPECT_EQ(sums(), 1);
  EXPECT_TRUE(watcher.log.sum.has_lattice());

  ASSERT_OK(Apply(Remove(0)));
  watcher.ReadUntilRevision(1);
  ASSERT_OK(Apply(Push(1, 21, {0.05, 0, 0})));
  watcher.ReadUntilRevision(2);

  EXPECT_EQ(sums(), 1);
  ASSERT_EQ(watcher.log.others.count(1), 1u);
  EXPECT_EQ(watcher.log.others.at(1).lattice().SerializeAsString(),
            LatticeAt(1).lattice().SerializeAsString());
  EventLog now;
  auto request = For<v1::GetUpdateRequest>();
  *request.mutable_view() = patches.view();
  ASSERT_OK(Update(request, now));
  EXPECT_EQ(watcher.log.bounds, now.bounds);
  EXPECT_EQ(watcher.log.topologies.back().topology_id(), now.topologies.back().topology_id());
  ASSERT_OK(Apply(Undo(1)));
  ASSERT_OK(Apply(Undo(0)));
  watcher.ReadUntilRevision(4);
  EXPECT_EQ(sums(), 2);
  EXPECT_EQ(watcher.log.sum.revision(), 4u);
}

}  // namespace
}  // namespace latticed::testing
