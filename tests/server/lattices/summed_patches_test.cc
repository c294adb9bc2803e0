// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views of patches in scenes of several lattices, through the stub: each update has the lattice that is the sum of all.
#include <algorithm>

#include "core/ffd/direct_ffd.h"
#include "core/ffd/outside/outside_map.h"
#include "core/patches/edge_bound.h"
#include "fmt/format.h"
#include "server/wire/converters.h"
#include "tests/server/lattices/several_fixture.h"

namespace latticed::testing {
namespace {

class SummedPatchesTest : public SeveralLatticesTest {
 protected:
  static v1::WatchRequest WatchPatches(const std::string& scene = kScene) {
    v1::WatchRequest watch = For<v1::WatchRequest>(scene);
    watch.mutable_view()->set_encoding(v1::ENCODING_PATCHES);
    watch.set_max_unacked_updates(100);
    return watch;
  }
  static size_t CountSums(const EventLog& log, bool whole) {
    return static_cast<size_t>(std::ranges::count_if(log.events, [&](const auto& event) {
      return event.has_patch_lattice() && event.patch_lattice().has_state() == whole;
    }));
  }
  static const v1::LatticeDelta& LastDelta(const EventLog& log) {
    for (auto event = log.events.rbegin();; ++event) {
      if (event->has_patch_lattice()) return event->patch_lattice().delta();
    }
  }
  // x + sum_k s_k (F_k(x) - x) by formula (1), from the lattices that a client is told of, at points of the cube.
  void ExpectDefinition(const EventLog& log) {
    ASSERT_OK_AND_ASSIGN(const auto sum, FromProto(log.sum.lattice(), "sum"));
    std::vector<v1::LatticeState> states{log.lattice};
    for (const auto& [index, state] : log.others) states.push_back(state);
    for (const Vec3d x : SomePoints(40)) {
      Vec3d want = x;
      for (const v1::LatticeState& state : states) {
        ASSERT_OK_AND_ASSIGN(const auto one, FromProto(state.lattice(), "lattice"));
        const OutsideMap map(one.structure);
        const Vec3d moved =
            EvaluateWorld(map.continued(), map.Continue(one.control_points), x).position;
        want += (state.has_strength() ? state.strength() : 1) * (moved - x);
      }
      const Vec3d got = EvaluateWorld(sum.structure, sum.control_points, x).position;
      EXPECT_LE(Norm(got - want), 1e-13) << "seed " << kSeed;
    }
    EventLog now;
    auto request = For<v1::GetUpdateRequest>();
    request.mutable_view()->set_encoding(v1::ENCODING_PATCHES);
    ASSERT_OK(Update(request, now));
    EXPECT_TRUE(log.bounds == now.bounds);
    EXPECT_EQ(log.sum.SerializeAsString(), now.sum.SerializeAsString());
  }
};

TEST_F(SummedPatchesTest, EachEditSendsWhatItMovesOfTheSum) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole({2, 1, 3})), Shaken(Spot())})));
  DeformClient client(*scenes_, WatchPatches());
  client.ReadUntilRevision(0);
  EXPECT_EQ(CountSums(client.log, true), 1u);
  ExpectDefinition(client.log);
  const int points = client.log.sum.lattice().control_points_size() / 3;
  std::uniform_real_distribution<double> move(-0.1, 0.1);
  for (uint64_t i = 1; i <= 12; ++i) {
    SCOPED_TRACE(fmt::format("edit {}, seed {}", i, kSeed));
    const auto lattice = static_cast<uint32_t>(i % 2);
    const auto before = client.log.sum;
    ASSERT_TRUE(client.Send(MoveIn(lattice, i, static_cast<uint32_t>(random_() % 64),
                                   {move(random_), move(random_), move(random_)})));
    client.ReadUntilRevision(i);
    const v1::LatticeDelta& delta = LastDelta(client.log);
    EXPECT_GT(delta.indices_size(), 0);
    EXPECT_LT(delta.indices_size(), points);
    for (int n = 0; n < delta.indices_size(); ++n) {  // none that rests
      const int at = 3 * static_cast<int>(delta.indices(n));
      bool differs = false;
      for (int k = 0; k < 3; ++k) {
        differs |= before.lattice().control_points(at + k) != delta.positions(3 * n + k);
      }
      EXPECT_TRUE(differs);
    }
    ExpectDefinition(client.log);
  }
  EXPECT_EQ(CountSums(client.log, true), 1u);
}

TEST_F(SummedPatchesTest, StrengthAndUndoAreInTheSum) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole()), Shaken(Spot())})));
  DeformClient client(*scenes_, WatchPatches());
  client.ReadUntilRevision(0);
  v1::EditBatch weaker = MoveIn(1, 1, 0, {});
  weaker.mutable_edits(0)->mutable_set_strength()->set_strength(0.375);
  ASSERT_TRUE(client.Send(weaker));
  client.ReadUntilRevision(1);
  ExpectDefinition(client.log);
  EXPECT_FALSE(client.log.sum.has_strength());
  ASSERT_TRUE(client.Send(MoveIn(0, 2, 42, {0, 0.1, 0})));
  client.ReadUntilRevision(2);
  v1::EditBatch undo = UndoMine("ann", 3);
  undo.set_lattice(1);
  ASSERT_TRUE(client.Send(undo));
  client.ReadUntilRevision(3);
  EXPECT_EQ(client.log.others.at(1).strength(), 1);
  ExpectDefinition(client.log);
}

TEST_F(SummedPatchesTest, AnAddedLatticeBringsAnotherPlan) {
  v1::CreateSceneRequest request = RequestOf({Shaken(Whole())});
  request.mutable_default_view()->set_encoding(v1::ENCODING_PATCHES);
  ASSERT_OK(Create(request));
  DeformClient client(*scenes_, WatchPatches());
  client.ReadUntilRevision(0);
  EXPECT_EQ(CountSums(client.log, true), 0u);
  v1::EditBatch add = MoveIn(1, 1, 0, {});
  *add.mutable_edits(0)->mutable_replace_lattice()->mutable_lattice() = Shaken(Spot({1, 2, 3}));
  ASSERT_TRUE(client.Send(add));
  client.ReadUntilRevision(1);
  ASSERT_EQ(client.log.topologies.size(), 2u);
  EXPECT_EQ(CountSums(client.log, true), 1u);
  EXPECT_EQ(client.log.sum.structure_id(), 2u);
  ExpectDefinition(client.log);
  v1::EditBatch move = MoveIn(1, 2, 21, {0.05, 0, 0});
  move.set_structure_id(2);
  ASSERT_TRUE(client.Send(move));
  client.ReadUntilRevision(2);
  ExpectDefinition(client.log);
  v1::EditBatch undo = UndoMine("ann", 3);
  undo.set_lattice(1);
  undo.set_structure_id(2);
  ASSERT_TRUE(client.Send(undo));
  client.ReadUntilRevision(3);
  ExpectDefinition(client.log);
  undo.set_sequence(4);  // of the addition: one lattice is left, which needs no sum
  ASSERT_TRUE(client.Send(undo));
  client.ReadUntilRevision(4);
  EXPECT_TRUE(client.log.others.empty());
  EXPECT_EQ(client.log.topologies.size(), 3u);
  EXPECT_EQ(CountSums(client.log, true), 1u);
  EXPECT_LT(client.log.sum.revision(), 4u);
}

TEST_F(SummedPatchesTest, AResumedStreamBeginsWithTheWholeSum) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole()), Shaken(Spot())})));
  v1::WatchRequest watch = WatchPatches();
  EventLog before;
  {
    WatchClient watcher(*scenes_, watch);
    watcher.ReadUpdates(1);
    before = watcher.log;
  }
  ASSERT_OK(Apply(MoveIn(1, 1, 21, {0.05, 0, 0})));
  watch.set_resume_token(before.ends.back().resume_token());
  WatchClient resumed(*scenes_, watch);
  resumed.ReadUpdates(1);
  EXPECT_TRUE(resumed.log.hello.resumed());
  EXPECT_EQ(CountSums(resumed.log, true), 1u);
  EXPECT_EQ(resumed.log.sum.revision(), 1u);
}

TEST_F(SummedPatchesTest, AViewOfPointsHasNone) {
  ASSERT_OK(Create(RequestOf({Whole(), Spot()})));
  v1::WatchRequest watch = WatchPatches();
  watch.mutable_view()->set_encoding(v1::ENCODING_RAW);
  WatchClient points(*scenes_, watch);
  points.ReadUpdates(1);
  EXPECT_EQ(CountSums(points.log, true), 0u);
}

TEST_F(SummedPatchesTest, PatchesAfterPointsBringTheWholeSum) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole()), Shaken(Spot())})));
  DeformClient client(*scenes_, WatchPatches());
  client.ReadUpdates(1);
  const auto see = [&](v1::Encoding encoding) {
    v1::DeformRequest message;
    message.mutable_control()->mutable_view()->set_encoding(encoding);
    return client.Send(message);
  };
  ASSERT_TRUE(see(v1::ENCODING_RAW));
  client.ReadUpdates(2);
  EXPECT_EQ(CountSums(client.log, true), 1u);
  ASSERT_TRUE(client.Send(MoveIn(1, 1, 21, {0.05, 0, 0})));
  client.ReadUntilRevision(1);
  ASSERT_TRUE(see(v1::ENCODING_PATCHES));
  client.ReadUpdates(client.log.ends.size() + 1);
  EXPECT_EQ(CountSums(client.log, true), 2u);
  EXPECT_EQ(CountSums(client.log, false), 0u);
  EXPECT_EQ(client.log.sum.revision(), 1u);
}

// The sum does not depend on weights; the plan has them.
TEST_F(SummedPatchesTest, WeightsAreInThePlan) {
  v1::CreateSceneRequest request = RequestOf({Shaken(Whole()), Shaken(Spot())});
  auto& values = *request.mutable_weights()->mutable_values();
  values.resize(8 * sizeof(float));
  ASSERT_OK(Create(request));
  WatchClient watcher(*scenes_, WatchPatches());
  watcher.ReadUpdates(1);
  ExpectDefinition(watcher.log);
  auto plan = For<v1::GetPatchPlanRequest>();
  plan.set_topology_id(watcher.log.topologies.back().topology_id());
  std::vector<v1::PatchPlanPart> parts;
  ASSERT_OK(ReadAll(&Scenes::GetPatchPlan, plan, &parts));
  EXPECT_TRUE(parts.at(0).header().weighted());
  const double unit = parts.at(0).header().curvature_unit();
  EXPECT_LT(EdgeBound(std::ranges::max(watcher.log.bounds), unit), 1e-6) << "all vertices rest";
}

}  // namespace
}  // namespace latticed::testing
