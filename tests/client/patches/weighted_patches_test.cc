// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A client that evaluates the patches of a scene with vertex weights, against a real server in this process: the definition
// x + w (F(x) - x) in double where w is linear in the whole mesh, and what the server sends to others where it is not.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "client/cpp/library/latticed_client.h"
#include "client/cpp/library/patches/lattice_from_proto.h"
#include "client/cpp/library/patches/patch_evaluator.h"
#include "core/ffd/direct_ffd.h"
#include "tests/client/patches/torus_scene.h"
#include "tests/client/quiet_server.h"

namespace latticed::client {
namespace {

constexpr uint32_t kSeedOfWeights = 20261128;

class WeightedPatchesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_NE(server_, nullptr);
    for (const Vec3d& p : torus_.positions) bounds_.Extend(p);
  }
  double size() const { return Norm(bounds_.max - bounds_.min); }

  void Create(const std::vector<float>& weights) {
    v1::CreateSceneRequest create;
    create.mutable_weights()->set_values(reinterpret_cast<const char*>(weights.data()),
                                         weights.size() * sizeof(float));
    const auto scene = CreateTorusScene(*client_, create);
    ASSERT_OK(scene);
    scene_ = scene->id();
  }
  std::vector<float> RandomWeights() {
    std::uniform_real_distribution<float> weight(0, 1);
    std::vector<float> weights(torus_.positions.size());
    for (float& w : weights) w = weight(random_);
    return weights;
  }
  v1::EditBatch RandomMoves() {
    std::uniform_real_distribution<double> offset(-0.3, 0.3);
    v1::EditBatch batch;
    for (int i = 0; i < 6; ++i) {
      auto& move = *batch.add_edits()->mutable_move_control_points();
      move.add_indices(static_cast<uint32_t>(random_() % 64));
      move.mutable_offset()->set_x(offset(random_));
      move.mutable_offset()->set_y(offset(random_));
      move.mutable_offset()->set_z(offset(random_));
    }
    return batch;
  }
  std::unique_ptr<DeformStream> Deform(v1::NormalMode normals) {
    v1::WatchRequest watch;
    watch.set_scene(scene_);
    watch.mutable_view()->set_encoding(v1::ENCODING_PATCHES);
    watch.mutable_view()->set_normals(normals);
    auto stream = client_->Deform(watch);
    EXPECT_OK(stream);
    return *std::move(stream);
  }
  void Send(DeformStream& stream, const v1::EditBatch& batch) {
    const auto sequence = stream.Send(batch);
    ASSERT_OK(sequence);
    ASSERT_OK(stream.WaitFor(*sequence));
  }

  const PolygonMesh torus_ = SceneTorus();
  std::mt19937 random_{kSeedOfWeights};
  Bounds bounds_;
  std::string scene_;
  const std::unique_ptr<InProcessServer> server_ = StartServer();
  const std::unique_ptr<Client> client_ = std::make_unique<Client>(server_->channel(), "");
};

TEST_F(WeightedPatchesTest, PointsAndNormalsAreThoseOfTheDefinition) {
  SCOPED_TRACE(kSeedOfWeights);
  const Vec3d slope{1 / (bounds_.max.x - bounds_.min.x), 0, 0};
  const auto weight_at = [&](Vec3d x) { return Dot(slope, x - bounds_.min); };
  std::vector<float> weights;
  for (const Vec3d& p : torus_.positions) weights.push_back(static_cast<float>(weight_at(p)));
  Create(weights);
  const auto stream = Deform(v1::NORMAL_MODE_FACET);
  const Surface& held = stream->surface();
  const auto plan = client_->GetPatchPlan(scene_, held.topology().topology_id());
  ASSERT_OK(plan);
  ASSERT_TRUE((*plan)->header.weighted);
  ASSERT_EQ((*plan)->slopes.size(), (*plan)->patches.size());
  for (int edit = 0; edit < 4; ++edit) {
    Send(*stream, RandomMoves());
    const auto lattice = EffectiveLattice(held.update_lattice());
    ASSERT_OK(lattice);
    auto evaluator = PatchEvaluator::Create(*plan, lattice->structure);
    ASSERT_OK(evaluator);
    PatchSurface rest, moved;
    ASSERT_OK(evaluator->Evaluate(IdentityControlPoints(lattice->structure), *held.EdgeBounds(),
                                  1e-3, &rest));
    ASSERT_OK(evaluator->Evaluate(lattice->control_points, *held.EdgeBounds(), 1e-3, &moved));
    EXPECT_LE(moved.error, 1e-3);
    double worst = 0, flattest = 1;
    for (size_t i = 0; i < rest.positions.size(); ++i) {
      const Vec3d x = (*plan)->header.origin + ToDouble(rest.positions[i]);
      const DeformedPoint f = EvaluateWorld(lattice->structure, lattice->control_points, x);
      const double w = weight_at(x);
      const Vec3d want = x + w * (f.position - x);
      worst = std::max(worst, Norm((*plan)->header.origin + ToDouble(moved.positions[i]) - want));
      std::array<Vec3d, 3> jacobian{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
      for (int a = 0; a < 3; ++a) {
        Vec3d& column = jacobian[static_cast<size_t>(a)];
        column += w * (f.jacobian[static_cast<size_t>(a)] - column) + slope[a] * (f.position - x);
      }
      const Vec3d normal = ApplyCofactor(jacobian, ToDouble(rest.normals[i]));
      flattest = std::min(flattest, Dot(normal, ToDouble(moved.normals[i])) / Norm(normal));
    }
    // Weights are rounded to 16 bits, moves are up to 1.
    EXPECT_LE(worst, 2e-6 * size() + 1.0 / 131070);
    EXPECT_GT(flattest, 1 - 1e-6);
  }
}

TEST_F(WeightedPatchesTest, AWatcherEvaluatesWhatOthersAreSent) {
  SCOPED_TRACE(kSeedOfWeights);
  Create(RandomWeights());
  for (const v1::NormalMode normals :
       {v1::NORMAL_MODE_NONE, v1::NORMAL_MODE_FACET, v1::NORMAL_MODE_SMOOTH}) {
    const auto stream = Deform(normals);
    Send(*stream, RandomMoves());
    const Surface& held = stream->surface();
    const auto plan = client_->GetPatchPlan(scene_, held.topology().topology_id(), normals);
    ASSERT_OK(plan);
    const auto lattice = EffectiveLattice(held.update_lattice());
    auto evaluator = PatchEvaluator::Create(*plan, lattice->structure);
    ASSERT_OK(evaluator);
    PatchSurface corners;
    ASSERT_OK(evaluator->Evaluate(lattice->control_points, *held.EdgeBounds(), 1e6, &corners));
    v1::GetUpdateRequest get;
    get.set_scene(scene_);
    get.mutable_view()->set_encoding(v1::ENCODING_RAW);
    get.mutable_view()->set_normals(normals);
    get.mutable_view()->set_segments(1);
    const auto update = client_->GetUpdate(get);
    ASSERT_OK(update);
    const DecodedPoints expected = *update->Decode();
    const auto most = evaluator->PositionError(lattice->control_points);
    ASSERT_OK(most);
    EXPECT_LE(*most, 1e-4 * size());
    ASSERT_EQ(corners.positions.size(), expected.positions.size());
    ASSERT_EQ(corners.normals.size(), expected.normals.size());
    for (size_t i = 0; i < expected.positions.size(); ++i) {
      const Vec3d p = ToDouble(corners.positions[i]) + (*plan)->header.origin;
      ASSERT_LE(Norm(p - expected.positions[i]), *most);
      if (expected.normals.empty()) continue;
      ASSERT_GT(Dot(ToDouble(corners.normals[i]), ToDouble(expected.normals[i])), 1 - 1e-6);
    }
  }
}

// Corners and edges of a triangle's patches lie at the same places in the patches beside it.
TEST_F(WeightedPatchesTest, PatchesThatShareAPointHaveItsBits) {
  Create(RandomWeights());
  const auto stream = Deform(v1::NORMAL_MODE_NONE);
  Send(*stream, RandomMoves());
  const Surface& held = stream->surface();
  const auto plan =
      client_->GetPatchPlan(scene_, held.topology().topology_id(), v1::NORMAL_MODE_NONE);
  ASSERT_OK(plan);
  EXPECT_TRUE((*plan)->slopes.empty());
  const auto lattice = EffectiveLattice(held.update_lattice());
  auto evaluator = PatchEvaluator::Create(*plan, lattice->structure);
  ASSERT_OK(evaluator);
  PatchSurface surface;
  ASSERT_OK(evaluator->Evaluate(lattice->control_points, *held.EdgeBounds(), 1e-3, &surface));
  // By edge: its points from its lower to its higher vertex.
  std::vector<std::vector<Vec3f>> edges((*plan)->header.edge_count);
  size_t shared = 0;
  for (size_t p = 0; p < (*plan)->patches.size(); ++p) {
    const PatchPlan::Patch& patch = (*plan)->patches[p];
    const AdaptivePattern& pattern =
        AdaptivePattern::Get(*PatternKey::FromCode(surface.patterns[p]));
    for (size_t e = 0; e < 3; ++e) {
      std::vector<Vec3f> points;
      for (const uint16_t i : pattern.edge_points[e]) {
        points.push_back(surface.positions[surface.first_points[p] + i]);
      }
      if (patch.vertex[e] > patch.vertex[(e + 1) % 3]) std::reverse(points.begin(), points.end());
      if (edges[patch.edge[e]].empty()) {
        edges[patch.edge[e]] = points;
        continue;
      }
      ASSERT_EQ(points, edges[patch.edge[e]]) << "patch " << p;
      shared += points.size();
    }
  }
  EXPECT_GT(shared, 2000u);
}

TEST_F(WeightedPatchesTest, WeightsThatAreSetHaveAnotherPlan) {
  Create(RandomWeights());
  const auto stream = Deform(v1::NORMAL_MODE_FACET);
  Send(*stream, RandomMoves());
  const Surface& held = stream->surface();
  const std::string before = held.topology().topology_id();
  v1::EditBatch clear;
  clear.add_edits()->mutable_set_weights()->set_clear(true);
  Send(*stream, clear);
  EXPECT_NE(held.topology().topology_id(), before);
  const auto plan = client_->GetPatchPlan(scene_, held.topology().topology_id());
  ASSERT_OK(plan);
  EXPECT_FALSE((*plan)->header.weighted);
  EXPECT_TRUE((*plan)->weights.empty());
  v1::EditBatch undo;
  undo.add_edits()->mutable_undo();
  Send(*stream, undo);
  EXPECT_EQ(held.topology().topology_id(), before);
  const auto again = client_->GetPatchPlan(scene_, before);
  ASSERT_OK(again);
  EXPECT_TRUE((*again)->header.weighted);
}

}  // namespace
}  // namespace latticed::client
