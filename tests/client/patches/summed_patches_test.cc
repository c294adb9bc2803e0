// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A client that evaluates the patches of several lattices, against a real server in this process and the definition
// x + sum_k s_k (F_k(x) - x), in double, from the lattices that GetLattice tells.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "client/cpp/library/latticed_client.h"
#include "client/cpp/library/patches/lattice_from_proto.h"
#include "client/cpp/library/patches/patch_evaluator.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/outside/outside_map.h"
#include "tests/client/patches/torus_scene.h"
#include "tests/client/quiet_server.h"

namespace latticed::client {
namespace {

constexpr uint32_t kSumSeed = 20261129;
constexpr double kSumTolerance = 1e-6;  // of float32, of the diagonal
constexpr std::array<Vec3d, 3> kColumns{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};

class SummedPatchesClientTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_NE(server_, nullptr);
    for (const Vec3d& p : SceneTorus().positions) bounds_.Extend(p);
  }

  // Over this part of the torus's bounds. It fades out in all directions; degree 2 and 3, so that normals are continuous.
  v1::Lattice Part(Vec3d low, Vec3d high, std::array<int, 3> degree, double width) const {
    v1::Lattice lattice;
    const Vec3d size = bounds_.max - bounds_.min;
    v1::LatticeFrame& frame = *lattice.mutable_frame();
    frame.mutable_origin()->set_x(bounds_.min.x + low.x * size.x);
    frame.mutable_origin()->set_y(bounds_.min.y + low.y * size.y);
    frame.mutable_origin()->set_z(bounds_.min.z + low.z * size.z);
    frame.mutable_u()->set_x((high.x - low.x) * size.x);
    frame.mutable_v()->set_y((high.y - low.y) * size.y);
    frame.mutable_w()->set_z((high.z - low.z) * size.z);
    lattice.mutable_degree()->set_u(degree[0]);
    lattice.mutable_degree()->set_v(degree[1]);
    lattice.mutable_degree()->set_w(degree[2]);
    lattice.mutable_outside()->set_mode(v1::OUTSIDE_MODE_FALLOFF);
    lattice.mutable_outside()->add_widths(width);
    return lattice;
  }
  v1::Lattice Whole() const { return Part({-0.1, -0.1, -0.1}, {1.1, 1.1, 1.1}, {2, 3, 2}, 0.1); }
  v1::Lattice Left() const { return Part({-0.1, 0.1, -0.2}, {0.4, 0.8, 1.2}, {3, 2, 2}, 0.4); }
  v1::Lattice Right() const { return Part({0.5, 0.3, 0.1}, {0.9, 0.9, 0.8}, {2, 2, 2}, 0.3); }

  std::string Create(const std::vector<v1::Lattice>& lattices) {
    v1::CreateSceneRequest create;
    for (const v1::Lattice& lattice : lattices) *create.add_lattices()->mutable_lattice() = lattice;
    const auto scene = CreateTorusScene(*client_, create);
    EXPECT_OK(scene);
    return scene->id();
  }
  v1::EditBatch RandomMove(uint32_t lattice) {
    std::uniform_real_distribution<double> offset(-0.2, 0.2);
    v1::EditBatch batch;
    batch.set_lattice(lattice);
    auto& move = *batch.add_edits()->mutable_move_control_points();
    move.add_indices(static_cast<uint32_t>(random_() % 64));
    move.mutable_offset()->set_x(offset(random_));
    move.mutable_offset()->set_y(offset(random_));
    move.mutable_offset()->set_z(offset(random_));
    return batch;
  }

  std::vector<Lattice> LatticesOf(const std::string& scene, size_t count) {
    std::vector<Lattice> lattices;
    for (uint32_t k = 0; k < count; ++k) {
      const auto state = client_->GetLattice(scene, k);
      EXPECT_OK(state);
      const Lattice given = *FromProto(state->lattice());
      const OutsideMap map(given.structure, state->has_strength() ? state->strength() : 1);
      lattices.push_back({map.continued(), map.Continue(given.control_points)});
    }
    return lattices;
  }
  static DeformedPoint Define(const std::vector<Lattice>& lattices, Vec3d x) {
    DeformedPoint sum{.position = x, .jacobian = kColumns};
    for (const Lattice& lattice : lattices) {
      const DeformedPoint one = EvaluateWorld(lattice.structure, lattice.control_points, x);
      sum.position += one.position - x;
      for (size_t c = 0; c < 3; ++c) sum.jacobian[c] += one.jacobian[c] - kColumns[c];
    }
    return sum;
  }

  // Compares the points and normals that a client makes from what `held` has with the definition.
  void ExpectDefinition(const std::string& scene, const Surface& held, size_t count) {
    const auto plan =
        client_->GetPatchPlan(scene, held.topology().topology_id(), held.view().normals());
    ASSERT_OK(plan);
    ASSERT_EQ(held.update_lattice().revision(), held.revision());
    const auto sum = EffectiveLattice(held.update_lattice());
    ASSERT_OK(sum);
    auto evaluator = PatchEvaluator::Create(*plan, sum->structure);
    ASSERT_OK(evaluator);
    const auto bounds = held.EdgeBounds();
    ASSERT_OK(bounds);
    PatchSurface rest, moved;
    ASSERT_OK(evaluator->Evaluate(IdentityControlPoints(sum->structure), *bounds, 1e-3, &rest));
    ASSERT_OK(evaluator->Evaluate(sum->control_points, *bounds, 1e-3, &moved));
    ASSERT_EQ(rest.positions.size(), moved.positions.size());
    ASSERT_EQ(rest.normals.size(), moved.normals.size());
    const std::vector<Lattice> lattices = LatticesOf(scene, count);
    const Vec3d origin = (*plan)->header.origin;
    double worst = 0, flattest = 1, farthest = 0;
    for (size_t i = 0; i < rest.positions.size(); ++i) {
      const Vec3d x = origin + ToDouble(rest.positions[i]);
      const DeformedPoint want = Define(lattices, x);
      worst = std::max(worst, Norm(origin + ToDouble(moved.positions[i]) - want.position));
      farthest = std::max(farthest, Norm(want.position - x));
      const Vec3d normal = ApplyCofactor(want.jacobian, ToDouble(rest.normals[i]));
      flattest = std::min(flattest, Dot(normal, ToDouble(moved.normals[i])) / Norm(normal));
    }
    EXPECT_LE(worst, 3 * kSumTolerance * Norm(bounds_.max - bounds_.min));
    EXPECT_GT(flattest, 1 - 1e-6);
    EXPECT_GT(farthest, 0.01);
    EXPECT_LE(moved.error, 1e-3);
  }

  std::mt19937 random_{kSumSeed};
  Bounds bounds_;
  const std::unique_ptr<InProcessServer> server_ = StartServer();
  const std::unique_ptr<Client> client_ = std::make_unique<Client>(server_->channel(), "");
};

v1::WatchRequest WatchSum(const std::string& scene) {
  v1::WatchRequest watch;
  watch.set_scene(scene);
  watch.mutable_view()->set_encoding(v1::ENCODING_PATCHES);
  watch.mutable_view()->set_normals(v1::NORMAL_MODE_SMOOTH);
  return watch;
}

TEST_F(SummedPatchesClientTest, EvaluatesTheSumAfterEditsOfEach) {
  SCOPED_TRACE(kSumSeed);
  const std::string scene = Create({Whole(), Left(), Right()});
  auto stream = client_->Deform(WatchSum(scene));
  ASSERT_OK(stream);
  for (int edit = 0; edit < 9; ++edit) {
    SCOPED_TRACE(edit);
    v1::EditBatch batch = RandomMove(static_cast<uint32_t>(edit % 3));
    if (edit == 4) batch.add_edits()->mutable_set_strength()->set_strength(0.625);
    const auto sequence = (*stream)->Send(batch);
    ASSERT_OK((*stream)->WaitFor(*sequence));
    if (edit > 1) ExpectDefinition(scene, (*stream)->surface(), 3);
  }
  v1::EditBatch undo;
  undo.set_lattice(1);
  undo.add_edits()->mutable_undo();
  const auto sequence = (*stream)->Send(undo);
  ASSERT_OK((*stream)->WaitFor(*sequence));
  ExpectDefinition(scene, (*stream)->surface(), 3);
}

TEST_F(SummedPatchesClientTest, FollowsALatticeThatIsAdded) {
  SCOPED_TRACE(kSumSeed);
  const std::string scene = Create({Whole()});
  auto stream = client_->Deform(WatchSum(scene));
  ASSERT_OK(stream);
  const Surface& held = (*stream)->surface();
  const auto send = [&](const v1::EditBatch& batch, size_t count) {
    const auto sequence = (*stream)->Send(batch);
    ASSERT_OK((*stream)->WaitFor(*sequence));
    ExpectDefinition(scene, held, count);
  };
  send(RandomMove(0), 1);
  const std::string first = held.topology().topology_id();
  v1::EditBatch add;
  add.set_lattice(1);
  *add.add_edits()->mutable_replace_lattice()->mutable_lattice() = Left();
  send(add, 2);
  EXPECT_NE(held.topology().topology_id(), first);
  send(RandomMove(1), 2);
  send(RandomMove(0), 2);
  v1::EditBatch undo;
  undo.set_lattice(1);
  undo.add_edits()->mutable_undo();
  send(undo, 2);
}

TEST_F(SummedPatchesClientTest, AnEarlierWatcherAndANewOneHaveTheSameSum) {
  const std::string scene = Create({Whole(), Left()});
  auto stream = client_->Deform(WatchSum(scene));
  ASSERT_OK(stream);
  for (int edit = 0; edit < 5; ++edit) {
    const auto sequence = (*stream)->Send(RandomMove(static_cast<uint32_t>(edit % 2)));
    ASSERT_OK((*stream)->WaitFor(*sequence));
  }
  v1::GetUpdateRequest get;
  get.set_scene(scene);
  *get.mutable_view() = WatchSum(scene).view();
  const auto now = client_->GetUpdate(get);
  ASSERT_OK(now);
  EXPECT_EQ((*stream)->surface().update_lattice().SerializeAsString(),
            now->update_lattice().SerializeAsString());
}

TEST(SurfaceOfSums, ASumBelongsInAnUpdate) {
  Surface surface;
  v1::SceneEvent event;
  event.mutable_patch_lattice()->mutable_state()->set_structure_id(1);
  EXPECT_THAT(surface.Apply(event).status(),
              ::latticed::testing::StatusIs(absl::StatusCode::kDataLoss));
}

}  // namespace
}  // namespace latticed::client
