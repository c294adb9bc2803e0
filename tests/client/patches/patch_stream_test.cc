// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A client that evaluates patches, against a real server in this process: its surface is what the server sends to others.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "client/cpp/library/latticed_client.h"
#include "client/cpp/library/patches/lattice_from_proto.h"
#include "client/cpp/library/patches/patch_evaluator.h"
#include "tests/client/patches/torus_scene.h"
#include "tests/client/quiet_server.h"

namespace latticed::client {
namespace {

using ::latticed::testing::StatusIs;

constexpr double kTorusSize = 3;  // of its bounds, about

class PatchStreamTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_NE(server_, nullptr);
    const auto scene = CreateTorusScene(*client_, {});
    ASSERT_OK(scene);
    scene_ = scene->id();
  }

  v1::WatchRequest Watch(v1::NormalMode normals) const {
    v1::WatchRequest watch;
    watch.set_scene(scene_);
    watch.mutable_view()->set_encoding(v1::ENCODING_PATCHES);
    watch.mutable_view()->set_normals(normals);
    return watch;
  }

  // The corners of all patches, as the server sends them to others.
  DecodedPoints Corners(v1::NormalMode normals) {
    v1::GetUpdateRequest get;
    get.set_scene(scene_);
    get.mutable_view()->set_encoding(v1::ENCODING_RAW);
    get.mutable_view()->set_normals(normals);
    get.mutable_view()->set_segments(1);
    const auto surface = client_->GetUpdate(get);
    EXPECT_OK(surface);
    return *surface->Decode();
  }

  static void ExpectSame(const PatchSurface& surface, const PatchPlan& plan,
                         const DecodedPoints& expected) {
    ASSERT_EQ(surface.positions.size(), expected.positions.size());
    ASSERT_EQ(surface.normals.size(), expected.normals.size());
    for (size_t i = 0; i < expected.positions.size(); ++i) {
      const Vec3d off = ToDouble(surface.positions[i]) + plan.header.origin - expected.positions[i];
      EXPECT_LE(std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}), 2e-5 * kTorusSize);
      if (expected.normals.empty()) continue;
      EXPECT_GT(Dot(ToDouble(surface.normals[i]), ToDouble(expected.normals[i])), 1 - 1e-6);
    }
  }

  // Edits the scene, and compares what a watcher of patches evaluates with what the server sends to others.
  void ExpectFollows(v1::NormalMode normals, std::optional<double> strength = std::nullopt) {
    auto stream = client_->Deform(Watch(normals));
    ASSERT_OK(stream);
    const Surface& held = (*stream)->surface();
    const auto plan =
        client_->GetPatchPlan(scene_, held.topology().topology_id(), held.view().normals());
    ASSERT_OK(plan);
    const auto structure = FromProto(held.update_lattice().lattice());
    auto evaluator = PatchEvaluator::Create(*plan, structure->structure);
    ASSERT_OK(evaluator);
    for (int edit = 0; edit < 3; ++edit) {
      v1::EditBatch batch;
      if (strength.has_value()) batch.add_edits()->mutable_set_strength()->set_strength(*strength);
      auto* move = batch.add_edits()->mutable_move_control_points();
      move->add_indices(static_cast<uint32_t>(20 * edit + 5));
      move->mutable_offset()->set_x(0.3);
      move->mutable_offset()->set_z(0.2);
      const auto sequence = (*stream)->Send(batch);
      ASSERT_OK((*stream)->WaitFor(*sequence));
      const auto lattice = EffectiveLattice(held.update_lattice());
      const auto bounds = held.EdgeBounds();
      ASSERT_OK(bounds);

      PatchSurface coarse, fine;
      ASSERT_OK(evaluator->Evaluate(lattice->control_points, *bounds, 1e6, &coarse));
      ASSERT_OK(evaluator->Evaluate(lattice->control_points, *bounds, 1e-4 * kTorusSize, &fine));

      ExpectSame(coarse, **plan, Corners(normals));
      EXPECT_LE(fine.error, 1e-4 * kTorusSize);
      if (strength != 0.0) {  // at rest all is flat
        EXPECT_GT(fine.positions.size(), coarse.positions.size());
      }
    }
  }

  const std::unique_ptr<InProcessServer> server_ = StartServer();
  const std::unique_ptr<Client> client_ = std::make_unique<Client>(server_->channel(), "");
  std::string scene_;
};

TEST_F(PatchStreamTest, AWatcherEvaluatesWhatOthersAreSent) {
  for (const v1::NormalMode normals :
       {v1::NORMAL_MODE_NONE, v1::NORMAL_MODE_FACET, v1::NORMAL_MODE_SMOOTH}) {
    ExpectFollows(normals);
  }
}

TEST_F(PatchStreamTest, AWatcherEvaluatesTheSceneAtItsStrength) {
  for (const double strength : {0.625, 0.0, 1.0}) ExpectFollows(v1::NORMAL_MODE_SMOOTH, strength);
}

TEST_F(PatchStreamTest, AWatcherEvaluatesWhatGoesOnOutside) {
  for (const v1::OutsideMode mode : {v1::OUTSIDE_MODE_FALLOFF, v1::OUTSIDE_MODE_LINEAR}) {
    auto state = client_->GetLattice(scene_);
    ASSERT_OK(state);
    v1::Lattice lattice = state->lattice();
    if (mode == v1::OUTSIDE_MODE_FALLOFF) {  // around three quarters of the torus in x and y
      lattice.mutable_frame()->mutable_u()->set_x(0.75 * lattice.frame().u().x());
      lattice.mutable_frame()->mutable_v()->set_y(0.75 * lattice.frame().v().y());
      lattice.clear_control_points();
      for (const double width : {0., 0.2, 0., 0., 0., 0.}) {
        lattice.mutable_outside()->add_widths(width);
      }
    } else {
      lattice.mutable_outside()->Clear();
    }
    lattice.mutable_outside()->set_mode(mode);
    v1::EditBatch batch;
    batch.set_scene(scene_);
    batch.set_editor_id("ann");
    batch.set_sequence(mode == v1::OUTSIDE_MODE_FALLOFF ? 1 : 2);
    batch.set_structure_id(state->structure_id());
    *batch.add_edits()->mutable_replace_lattice()->mutable_lattice() = lattice;
    ASSERT_OK(client_->ApplyEdits(batch).status());
    ExpectFollows(v1::NORMAL_MODE_SMOOTH);
  }
}

TEST_F(PatchStreamTest, AViewOfPatchesHasNoPointsToDecode) {
  const auto watch = client_->Watch(Watch(v1::NORMAL_MODE_FACET));
  ASSERT_OK(watch);

  EXPECT_THAT((*watch)->surface().Decode().status(),
              StatusIs(absl::StatusCode::kFailedPrecondition));
  EXPECT_OK((*watch)->surface().EdgeBounds().status());
}

TEST_F(PatchStreamTest, OtherViewsHaveNoEdgeBounds) {
  v1::GetUpdateRequest get;
  get.set_scene(scene_);
  const auto surface = client_->GetUpdate(get);
  ASSERT_OK(surface);

  EXPECT_THAT(surface->EdgeBounds().status(), StatusIs(absl::StatusCode::kFailedPrecondition));
}

TEST_F(PatchStreamTest, AnotherTopologyIsNotFound) {
  EXPECT_THAT(client_->GetPatchPlan(scene_, "none").status(),
              StatusIs(absl::StatusCode::kNotFound));
}

}  // namespace
}  // namespace latticed::client
