// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Several lattices of one scene through the stub: x goes to x + sum_k (F_k(x) - x), and each lattice has edits of its own.
#include <array>
#include <cmath>
#include <cstring>

#include "core/mesh/mesh_io.h"
#include "tests/server/lattices/several_fixture.h"

namespace latticed::testing {
namespace {

constexpr char kFirst[] = "first-scene", kSecond[] = "second-scene";  // of one lattice each

// The frames are parallel, or turned against each other.
class SumsTest : public SeveralLatticesTest, public ::testing::WithParamInterface<bool> {
 protected:
  v1::Lattice Spot(std::array<int, 3> degree = {2, 2, 2}) const {
    return GetParam() ? TurnedSpot(degree) : SeveralLatticesTest::Spot(degree);
  }
};
INSTANTIATE_TEST_SUITE_P(Frames, SumsTest, ::testing::Bool(),
                         [](const auto& frames) { return frames.param ? "turned" : "parallel"; });

TEST_P(SumsTest, DisplacementsAddAtMixesOfDegrees) {
  for (int mix = 0; mix < 27; ++mix) {
    const auto degree = [](int n) {
      return std::array<int, 3>{1 + n % 3, 1 + n / 3 % 3, 1 + n / 9};
    };
    const v1::Lattice one = Shaken(Whole(degree(mix))), other = Shaken(Spot(degree(26 - mix)));
    ASSERT_OK(Create(RequestOf({one, other})));
    ASSERT_OK(Create(RequestOf({one}, kFirst)));
    ASSERT_OK(Create(RequestOf({other}, kSecond)));
    const std::vector<Vec3d> world = SomePoints(100);
    const auto sum = Evaluate(world), first = Evaluate(world, kFirst);
    const auto second = Evaluate(world, kSecond);
    for (size_t n = 0; n < world.size(); ++n) {
      EXPECT_LE(Norm(sum[n] - (first[n] + second[n] - world[n])), 1e-13)
          << n << ", mix " << mix << ", seed " << kSeed;
    }
    for (const char* id : {kScene, kFirst, kSecond}) ASSERT_OK(DeleteScene(id));
  }
}

TEST_P(SumsTest, AWatcherFollowsTheEditsOfEach) {
  ASSERT_OK(Create(RequestOf({Whole(), Spot()})));
  EXPECT_EQ(Get().lattices_size(), 2);
  EXPECT_EQ(Get().lattices(1).frame().origin().x(), Spot().frame().origin().x());
  WatchClient watcher(*scenes_, RawWatch());
  watcher.ReadUpdates(1);
  ASSERT_EQ(watcher.log.others.size(), 1u);
  EXPECT_EQ(watcher.log.others.at(1).lattice().frame().u().x(), Spot().frame().u().x());

  ASSERT_OK(Apply(MoveIn(1, 1, 21, {0.05, 0, 0})));
  ASSERT_OK(Apply(MoveIn(0, 2, 42, {0, 0.1, 0})));

  watcher.ReadUntilRevision(2);
  EXPECT_EQ(watcher.log.deltas, 2u);
  for (const uint32_t k : {0u, 1u}) {
    const v1::LatticeState& seen = k == 0 ? watcher.log.lattice : watcher.log.others.at(k);
    EXPECT_EQ(seen.lattice().SerializeAsString(), LatticeAt(k).lattice().SerializeAsString());
  }
  v1::CreateSceneRequest fresh =
      RequestOf({LatticeAt(0).lattice(), LatticeAt(1).lattice()}, kFirst);
  ASSERT_OK(Create(fresh));
  EXPECT_TRUE(Chunks() == Chunks(kFirst));
}

TEST_P(SumsTest, EachHasItsOwnUndoAlsoAfterARestart) {
  ASSERT_OK(Create(RequestOf({Whole(), Spot()})));
  const std::string first = LatticeAt(0).lattice().SerializeAsString();
  ASSERT_OK(Apply(MoveIn(0, 1, 42, {0, 0.1, 0})));
  ASSERT_OK(Apply(MoveIn(1, 2, 21, {0.05, 0, 0})));
  ASSERT_OK(Apply(MoveIn(1, 3, 22, {0.05, 0, 0})));
  const std::string second = LatticeAt(1).lattice().SerializeAsString();
  const auto before = Chunks();

  Restart();

  EXPECT_TRUE(Chunks() == before);
  EXPECT_EQ(Get().revision(), 3u);
  ASSERT_OK(Apply(UndoMine("ann", 4)));  // of lattice 0
  EXPECT_EQ(LatticeAt(0).lattice().SerializeAsString(), first);
  EXPECT_EQ(LatticeAt(1).lattice().SerializeAsString(), second);
  v1::EditBatch undo = UndoMine("ann", 5);
  undo.set_lattice(1);
  ASSERT_OK(Apply(undo));
  EXPECT_NE(LatticeAt(1).lattice().SerializeAsString(), second);
  EXPECT_EQ(Get().revision(), 5u);
}

TEST_P(SumsTest, AnInsertedKnotKeepsTheShape) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole()), Shaken(Spot())})));
  const std::vector<Vec3d> world = SomePoints(50);
  const auto before = Evaluate(world);
  v1::EditBatch insert = MoveIn(1, 1, 0, {});
  auto& knot = *insert.mutable_edits(0)->mutable_insert_knot();
  knot.set_axis(v1::LATTICE_AXIS_U);
  knot.set_value(0.5);
  ASSERT_OK(Apply(insert));
  EXPECT_EQ(LatticeAt(1).lattice().size().u(), 5);
  EXPECT_EQ(LatticeAt(0).lattice().size().u(), 4);
  EXPECT_EQ(Get().structure_id(), 2u);
  const auto after = Evaluate(world);
  for (size_t n = 0; n < world.size(); ++n) EXPECT_LE(Norm(after[n] - before[n]), 1e-13);
  ExpectRefused(Apply(MoveIn(0, 2, 0, {})), absl::StatusCode::kAborted, "STRUCTURE_CHANGED");
}

TEST_P(SumsTest, StrengthIsOfOneLattice) {
  const v1::Lattice one = Shaken(Whole()), other = Shaken(Spot());
  ASSERT_OK(Create(RequestOf({one, other})));
  ASSERT_OK(Create(RequestOf({one}, kFirst)));
  v1::EditBatch batch = MoveIn(1, 1, 0, {});
  batch.mutable_edits(0)->mutable_set_strength()->set_strength(0);
  ASSERT_OK(Apply(batch));
  EXPECT_EQ(LatticeAt(1).strength(), 0);
  EXPECT_FALSE(LatticeAt(0).has_strength());
  const std::vector<Vec3d> world = SomePoints(50);
  const auto sum = Evaluate(world), alone = Evaluate(world, kFirst);
  for (size_t n = 0; n < world.size(); ++n) EXPECT_LE(Norm(sum[n] - alone[n]), 1e-14);
}

TEST_P(SumsTest, ADragOfOneReachesItsTargetBesideTheOther) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole()), Shaken(Spot())})));
  v1::EditBatch batch = MoveIn(1, 1, 0, {});
  auto& drag = *batch.mutable_edits(0)->mutable_drag_points();
  auto& point = *drag.add_points();  // (0.5, 0.75, 0), in the fading part of the spot
  for (const uint32_t corner : {0u, 1u, 2u}) point.add_corners(corner);
  for (const double b : {0.5, 0.25, 0.25}) point.add_barycentrics(b);
  const Vec3d rest{0.5, 0.75, 0}, target{0.55, 0.8, 0.05};
  for (int a = 0; a < 3; ++a) drag.add_targets(target[a]);
  v1::EditResult result;
  ASSERT_OK(Apply(batch, &result));
  EXPECT_LE(result.drag_residual(), 1e-12);
  EXPECT_LE(Norm(Evaluate(rest) - target), 1e-12);
}

TEST_P(SumsTest, DerivativesAreByThePointsOfOne) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole()), Shaken(Spot())})));
  const auto volume = [&] {
    auto request = For<v1::MeasureSceneRequest>();
    request.add_measures(v1::MEASURE_VOLUME);
    request.set_with_gradient(true);
    request.set_lattice(1);
    v1::MeasureSceneResponse got;
    EXPECT_OK(Call(&Scenes::MeasureScene, request, &got));
    return got;
  };
  const v1::MeasureSceneResponse before = volume();
  constexpr double kStep = 1e-6;
  constexpr uint32_t kIndex = 21;  // (1, 1, 1)
  ASSERT_OK(Apply(MoveIn(1, 1, kIndex, {0, 0, kStep})));
  ASSERT_EQ(before.volume_gradient_size(), 3 * 64);
  const double slope = before.volume_gradient(3 * kIndex + 2);
  EXPECT_NEAR((volume().volume() - before.volume()) / kStep, slope, 1e-8);
  EXPECT_GT(std::abs(slope), 1e-4);
}

TEST_P(SumsTest, OneKeepsTheVolumeBesideTheOther) {
  ASSERT_OK(Create(RequestOf({Shaken(Whole()), Spot()})));
  v1::EditBatch keep = MoveIn(1, 1, 0, {});
  keep.mutable_edits(0)->mutable_set_constraints()->mutable_constraints()->mutable_volume();
  ASSERT_OK(Apply(keep));
  ASSERT_OK(Apply(MoveIn(1, 2, 21, {0.05, 0.02, -0.05})));
  v1::MeasureSceneResponse got;
  ASSERT_OK(Volume(&got));
  EXPECT_NEAR(got.volume(), 1, 1e-12);
}

// Exports of two scenes with the same patches: at rest, and moved.
class SumsExportTest : public SumsTest {
 protected:
  void SetUp() override {
    SeveralLatticesTest::SetUp();
    ASSERT_OK(Create(RequestOf({Shaken(Whole({2, 1, 3})), Shaken(Spot())})));
    ASSERT_OK(Create(RequestOf({Whole({2, 1, 3}), Spot()}, kFirst)));
  }
  // A corner and the middle of each patch, from its control net: sum of n! / (i! j! k!) / 3^n T_ijk.
  std::vector<Vec3d> PointsOfNets(const std::string& scene) {
    auto request = For<v1::ExportRequest>(scene);
    request.set_format(v1::EXPORT_FORMAT_CONTROL_NETS);
    const auto bytes = Export(request);
    EXPECT_OK(bytes);
    uint32_t degree = 0;
    std::memcpy(&degree, bytes->data() + 12, sizeof(degree));
    const int n = static_cast<int>(degree);
    std::vector<Vec3d> points;
    for (size_t at = 32; at < bytes->size();) {
      Vec3d middle;
      for (int i = n; i >= 0; --i) {
        for (int j = n - i; j >= 0; --j, at += sizeof(Vec3d)) {
          Vec3d p;
          std::memcpy(&p, bytes->data() + at, sizeof(p));
          if (i == n) points.push_back(p);
          middle += std::tgamma(n + 1) / std::tgamma(i + 1) / std::tgamma(j + 1) /
                    std::tgamma(n - i - j + 1) / std::pow(3, n) * p;
        }
      }
      points.push_back(middle);
    }
    return points;
  }
  std::vector<Vec3d> VerticesOfPatches(const std::string& scene) {
    auto request = For<v1::ExportRequest>(scene);
    request.set_format(v1::EXPORT_FORMAT_PLY);
    request.set_geometry(v1::EXPORT_GEOMETRY_PATCHES);
    request.mutable_view()->set_segments(3);
    const auto bytes = Export(request);
    EXPECT_OK(bytes);
    const auto mesh = ReadMesh(MeshFormat::kPly, *bytes);
    EXPECT_OK(mesh);
    EXPECT_EQ(mesh->positions.size(), 10 * Get(scene).patches());
    return mesh->positions;
  }
  void ExpectMoved(const std::vector<Vec3d>& rest, const std::vector<Vec3d>& moved, double most) {
    ASSERT_EQ(rest.size(), moved.size());
    ASSERT_GT(rest.size(), 100u);
    constexpr size_t kMostPoints = 4096;  // of one call
    for (size_t first = 0; first < rest.size(); first += kMostPoints) {
      const size_t end = std::min(rest.size(), first + kMostPoints);
      const auto want = Evaluate(std::vector<Vec3d>(rest.begin() + static_cast<ptrdiff_t>(first),
                                                    rest.begin() + static_cast<ptrdiff_t>(end)));
      for (size_t i = first; i < end; ++i) {
        ASSERT_LE(Norm(moved[i] - want[i - first]), most) << i << ", seed " << kSeed;
      }
    }
  }
};

INSTANTIATE_TEST_SUITE_P(Frames, SumsExportTest, ::testing::Bool(),
                         [](const auto& frames) { return frames.param ? "turned" : "parallel"; });

TEST_P(SumsExportTest, ControlNetsAreOfTheSum) {
  ExpectMoved(PointsOfNets(kFirst), PointsOfNets(kScene), 1e-12);
}

TEST_P(SumsExportTest, UnweldedPatchesAreOfTheSum) {
  ExpectMoved(VerticesOfPatches(kFirst), VerticesOfPatches(kScene), 1e-4);  // a grid of 16 bits
}

}  // namespace
}  // namespace latticed::testing
