// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The strength of a scene through the stub: x goes to x + s (F(x) - x), in all that is evaluated, streamed and measured.
#include <cmath>
#include <limits>
#include <random>

#include "core/ffd/lattice.h"
#include "core/mesh/mesh_io.h"
#include "tests/server/outside/outside_fixture.h"
#include "tests/server/points/point_set_client.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

constexpr uint32_t kSeed = 61;
constexpr char kWhole[] = "whole-scene";  // the same at strength 1
constexpr double kStrength = 0.375;

class StrengthTest : public OutsideSceneTest {
 protected:
  // Sets x y z of all control points: those at rest of HalfLattice, each moved at random.
  void Deform(v1::Lattice& lattice) {
    std::uniform_real_distribution<double> move(-0.1, 0.1);
    lattice.clear_control_points();
    for (const Vec3d p : RestOf(lattice)) {
      for (int a = 0; a < 3; ++a) lattice.add_control_points(p[a] + move(random_));
    }
  }
  static std::vector<Vec3d> RestOf(const v1::Lattice& lattice) {
    LatticeStructure s;
    if (lattice.has_degree()) {
      s.degree = {lattice.degree().u(), lattice.degree().v(), lattice.degree().w()};
    }
    for (size_t a = 0; a < 3; ++a) s.knots[a] = ClampedUniformKnots(s.degree[a], s.size[a]);
    s.frame = {{-0.1, -0.1, -0.1}, {Vec3d{0.6, 0, 0}, Vec3d{0, 1.2, 0}, Vec3d{0, 0, 1.2}}};
    return IdentityControlPoints(s);
  }
  v1::CreateSceneRequest Weak(const v1::Lattice& lattice, double strength = kStrength) const {
    v1::CreateSceneRequest request = RequestFor(lattice);
    request.set_strength(strength);
    return request;
  }
  static v1::EditBatch SetStrength(uint64_t sequence, double strength) {
    v1::EditBatch batch = MoveOne("ann", sequence, 0, {});
    batch.mutable_edits(0)->mutable_set_strength()->set_strength(strength);
    return batch;
  }
  std::vector<Vec3d> SomePoints(int count) {
    std::uniform_real_distribution<double> place(-0.2, 1.2);
    std::vector<Vec3d> points;
    for (int n = 0; n < count; ++n)
      points.push_back({place(random_), place(random_), place(random_)});
    return points;
  }
  // Both scenes have the same lattice; kScene has the strength.
  void ExpectPartOfTheWay(double strength) {
    const std::vector<Vec3d> world = SomePoints(100);
    const auto whole = Evaluate(world, kWhole), part = Evaluate(world);
    for (size_t n = 0; n < world.size(); ++n) {
      EXPECT_LE(Norm(part[n] - (world[n] + strength * (whole[n] - world[n]))), 1e-13)
          << n << ", seed " << kSeed;
    }
  }
  std::string Bytes(const std::string& scene = kScene, int segments = 3) {
    EventLog log;
    EXPECT_OK(Update(segments, scene, &log));
    std::string bytes;
    for (const auto& [index, chunk] : log.chunks) bytes += chunk;
    EXPECT_FALSE(bytes.empty());
    return bytes;
  }

  std::mt19937 random_{kSeed};
};

TEST_F(StrengthTest, EveryMixOfDegreesGoesPartOfTheWay) {
  for (int mix = 0; mix < 27; ++mix) {
    v1::Lattice lattice = mix % 2 == 0 ? HalfLattice() : Falloff(0.3);
    SetAxes(*lattice.mutable_degree(), 1 + mix % 3, 1 + mix / 3 % 3, 1 + mix / 9);
    Deform(lattice);
    ASSERT_OK(Create(RequestFor(lattice, kWhole)));
    ASSERT_OK(Create(Weak(lattice)));
    ExpectPartOfTheWay(kStrength);
    ASSERT_OK(DeleteScene(kWhole));
    ASSERT_OK(DeleteScene());
  }
}

TEST_F(StrengthTest, TheSurfaceIsThatOfTheEffectiveLattice) {
  v1::Lattice lattice = HalfLattice();
  Deform(lattice);
  v1::Lattice effective = lattice;
  const std::vector<Vec3d> rest = RestOf(lattice);
  for (int i = 0; i < lattice.control_points_size(); ++i) {
    const double at_rest = rest[static_cast<size_t>(i / 3)][i % 3];
    effective.set_control_points(i, at_rest + kStrength * (lattice.control_points(i) - at_rest));
  }
  ASSERT_OK(Create(RequestFor(effective, kWhole)));
  ASSERT_OK(Create(Weak(lattice)));
  EXPECT_EQ(Bytes(), Bytes(kWhole));
  EXPECT_EQ(Get().strength(), kStrength);
  EXPECT_EQ(Get(kWhole).strength(), 1);
  EXPECT_EQ(Lattice().strength(), kStrength);
  EXPECT_EQ(Lattice().lattice().control_points(0), lattice.control_points(0));
}

TEST_F(StrengthTest, AnEditSetsItAndAWatcherFollows) {
  v1::Lattice lattice = Falloff(0.3);
  Deform(lattice);
  ASSERT_OK(Create(RequestFor(lattice, kWhole)));
  ASSERT_OK(Create(RequestFor(lattice)));
  v1::WatchRequest watch = For<v1::WatchRequest>();
  watch.mutable_view()->set_encoding(v1::ENCODING_RAW);
  watch.mutable_view()->set_segments(3);
  WatchClient watcher(*scenes_, watch);
  watcher.ReadUpdates(1);
  const uint64_t structure = Get().structure_id();

  v1::EditResult result;
  ASSERT_OK(Apply(SetStrength(1, kStrength), &result));

  EXPECT_EQ(result.structure_id(), structure);
  EXPECT_EQ(result.largest_move(), 0);
  EXPECT_GT(result.patches_touched(), 0u);
  watcher.ReadUntilRevision(1);
  EXPECT_EQ(watcher.log.deltas, 1u);
  EXPECT_EQ(watcher.log.lattice.strength(), kStrength);
  ExpectPartOfTheWay(kStrength);
  v1::CreateSceneRequest fresh = Weak(lattice);
  fresh.set_scene_id("fresh-scene");
  ASSERT_OK(Create(fresh));
  const auto raw = [&](const std::string& scene) {
    auto request = For<v1::GetUpdateRequest>(scene);
    *request.mutable_view() = watch.view();
    EventLog log;
    EXPECT_OK(Update(request, log));
    return log.chunks;
  };
  EXPECT_EQ(watcher.log.chunks.size(), raw(kScene).size());
  EXPECT_TRUE(watcher.log.chunks == raw(kScene));
  EXPECT_TRUE(raw("fresh-scene") == raw(kScene));
}

TEST_F(StrengthTest, UndoRedoAndARestartKeepIt) {
  v1::Lattice lattice = HalfLattice();
  Deform(lattice);
  ASSERT_OK(Create(Weak(lattice, 0.75)));
  ASSERT_OK(Apply(SetStrength(1, 0.5)));
  ASSERT_OK(Apply(SetStrength(2, kStrength)));
  ASSERT_OK(Apply(UndoMine("ann", 3)));
  EXPECT_EQ(Get().strength(), 0.5);
  const auto at_half = Evaluate({0.3, 0.4, 0.5});

  Restart();

  EXPECT_EQ(Get().strength(), 0.5);
  EXPECT_EQ(Norm(Evaluate({0.3, 0.4, 0.5}) - at_half), 0);
  ASSERT_OK(Apply(UndoMine("ann", 4)));
  EXPECT_EQ(Get().strength(), 0.75);
  v1::EditBatch redo = MoveOne("ann", 5, 0, {});
  redo.mutable_edits(0)->mutable_redo();
  ASSERT_OK(Apply(redo));
  EXPECT_EQ(Get().strength(), 0.5);
}

TEST_F(StrengthTest, AGestureOfASliderIsOneStep) {
  ASSERT_OK(Create(RequestFor(HalfLattice())));
  uint64_t sequence = 0;
  for (const double s : {0.9, 0.7, 0.3}) {
    v1::EditBatch batch = SetStrength(++sequence, s);
    batch.set_gesture_id("slide");
    ASSERT_OK(Apply(batch));
  }
  EXPECT_EQ(Get().strength(), 0.3);
  ASSERT_OK(Apply(UndoMine("ann", ++sequence)));
  EXPECT_EQ(Get().strength(), 1);
}

TEST_F(StrengthTest, BadStrengthsAreRefusedAndChangeNothing) {
  struct Case {
    double strength;
    const char* reason;
  };
  for (const auto& [strength, reason] :
       {Case{-0.001, "OUT_OF_RANGE"},
        {1.001, "OUT_OF_RANGE"},
        {std::numeric_limits<double>::infinity(), "NOT_FINITE"},
        {std::numeric_limits<double>::quiet_NaN(), "NOT_FINITE"}}) {
    ExpectRefused(Create(Weak(HalfLattice(), strength)), Code::kInvalidArgument, reason,
                  "strength");
  }
  ASSERT_OK(Create(Weak(HalfLattice())));
  uint64_t sequence = 0;
  for (const double strength : {-0.5, 2.0}) {
    ExpectRefused(Apply(SetStrength(++sequence, strength)), Code::kInvalidArgument, "OUT_OF_RANGE",
                  "edits[0].set_strength.strength");
  }
  v1::EditBatch unset = SetStrength(++sequence, 1);
  unset.mutable_edits(0)->mutable_set_strength()->clear_strength();
  ExpectRefused(Apply(unset), Code::kInvalidArgument, "INVALID_FIELD",
                "edits[0].set_strength.strength");
  EXPECT_EQ(Get().strength(), kStrength);
  EXPECT_EQ(Get().revision(), 0u);
}

TEST_F(StrengthTest, ADragReachesItsTargetUnlessThereIsNone) {
  v1::Lattice lattice = Falloff(0.3);
  Deform(lattice);
  ASSERT_OK(Create(Weak(lattice)));
  v1::EditBatch batch = MoveOne("ann", 1, 0, {});
  auto& drag = *batch.mutable_edits(0)->mutable_drag_points();
  auto& point = *drag.add_points();  // in the first face, at x = 0.25
  for (const uint32_t corner : {0u, 1u, 2u}) point.add_corners(corner);
  for (const double b : {0.5, 0.25, 0.25}) point.add_barycentrics(b);
  for (const double x : {0.3, 0.4, 0.1}) drag.add_targets(x);
  v1::EditResult result;
  ASSERT_OK(Apply(batch, &result));
  EXPECT_LE(result.drag_residual(), 1e-12);

  ASSERT_OK(Apply(SetStrength(2, 0)));
  batch.set_sequence(3);
  ExpectRefusal(Apply(batch), {Code::kFailedPrecondition, "NO_STRENGTH", "", "strength is 0"});
}

TEST_F(StrengthTest, AtNoneTheMeshIsAtRestAndNothingTears) {
  v1::Lattice lattice = HalfLattice();
  Deform(lattice);
  ASSERT_OK(Create(RequestFor(lattice)));
  v1::MeasureSceneResponse got;
  ExpectRefused(Volume(&got), Code::kFailedPrecondition, "OPEN_SURFACE");
  ASSERT_OK(Apply(SetStrength(1, 0)));
  ASSERT_OK(Volume(&got));
  EXPECT_NEAR(got.volume(), 1, 1e-14);
  for (const Vec3d p : SomePoints(20)) EXPECT_LE(Norm(Evaluate(p) - p), 1e-15);
}

TEST_F(StrengthTest, MeasuresAndTheirDerivativesHaveIt) {
  v1::Lattice lattice = Falloff(0.5);
  Deform(lattice);
  ASSERT_OK(Create(Weak(lattice)));
  v1::MeasureSceneResponse before, after;
  ASSERT_OK(Volume(&before, true));
  constexpr double kStep = 1e-6;
  ASSERT_OK(Apply(MoveOne("ann", 1, 22, {kStep, 0, 0})));
  ASSERT_OK(Volume(&after));
  ASSERT_EQ(before.volume_gradient_size(), 3 * 64);
  EXPECT_NEAR((after.volume() - before.volume()) / kStep, before.volume_gradient(3 * 22), 1e-8);
  EXPECT_GT(std::abs(before.volume_gradient(3 * 22)), 1e-4);
}

TEST_F(StrengthTest, TheKeptVolumeIsKept) {
  v1::Lattice lattice = Falloff(0.5);
  Deform(lattice);
  ASSERT_OK(Create(RequestFor(lattice)));
  v1::EditBatch keep = MoveOne("ann", 1, 0, {});
  keep.mutable_edits(0)->mutable_set_constraints()->mutable_constraints()->mutable_volume();
  ASSERT_OK(Apply(keep));
  ASSERT_OK(Apply(SetStrength(2, kStrength)));
  v1::MeasureSceneResponse got;
  ASSERT_OK(Volume(&got));
  EXPECT_NEAR(got.volume(), 1, 1e-12);
  ASSERT_OK(Apply(MoveOne("ann", 3, 22, {0.2, 0, 0})));
  ASSERT_OK(Volume(&got));
  EXPECT_NEAR(got.volume(), 1, 1e-12);
}

TEST_F(StrengthTest, AStrengthThatFoldsIsRefused) {
  ASSERT_OK(Create(Weak(Falloff(0.5), 0.1)));
  v1::EditBatch fold = MoveOne("ann", 1, 22, {-1.5, 0, 0});
  fold.set_refuse_folds(true);
  ASSERT_OK(Apply(fold));
  v1::EditBatch more = SetStrength(2, 1);
  more.set_refuse_folds(true);
  ExpectRefused(Apply(more), Code::kFailedPrecondition, "FOLD");
  EXPECT_EQ(Get().strength(), 0.1);
  more.set_refuse_folds(false);
  more.set_sequence(3);
  EXPECT_OK(Apply(more));
}

TEST_F(StrengthTest, WeightsAndItMultiply) {
  std::vector<float> weights = {0, 1, 1, 0, 0.5f, 1, 1, 0.25f};
  const std::string bytes(reinterpret_cast<const char*>(weights.data()),
                          weights.size() * sizeof(float));
  v1::Lattice lattice = Falloff(0.5);
  Deform(lattice);
  v1::CreateSceneRequest request = Weak(lattice);
  request.mutable_weights()->set_values(bytes);
  ASSERT_OK(Create(request));
  request.set_scene_id(kWhole);
  request.clear_strength();
  ASSERT_OK(Create(request));
  const auto vertices = [&](const std::string& scene) {
    auto exported = For<v1::ExportRequest>(scene);
    exported.set_geometry(v1::EXPORT_GEOMETRY_ORIGINAL);
    return ReadMesh(MeshFormat::kPly, *Export(exported))->positions;
  };
  const auto rest = ReadMesh(MeshFormat::kObj, kUnitCubeObj)->positions;
  const auto part = vertices(kScene), whole = vertices(kWhole);
  ASSERT_EQ(part.size(), 8u);
  for (size_t v = 0; v < part.size(); ++v) {
    EXPECT_LE(Norm(part[v] - (rest[v] + kStrength * (whole[v] - rest[v]))), 1e-6) << v;
  }
}

}  // namespace
}  // namespace latticed::testing
