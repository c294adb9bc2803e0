// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene that several devices share, as a client of patches sees it: the plan and the bounds of one device, and a surface
// without cracks.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "client/cpp/library/latticed_client.h"
#include "client/cpp/library/patches/lattice_from_proto.h"
#include "client/cpp/library/patches/patch_evaluator.h"
#include "core/backend.h"
#include "tests/client/patches/torus_scene.h"
#include "tests/client/quiet_server.h"
#include "tests/support/backends.h"

namespace latticed::client {
namespace {

constexpr double kFineTolerance = 3e-4;  // of a torus of about 3

std::unique_ptr<InProcessServer> StartOnDevices(int devices) {
  if (devices == 1) return StartServer();
  auto backend = testing::MakeSpannedBackend("cpu", devices);
  EXPECT_OK(backend);
  std::vector<std::unique_ptr<Backend>> backends;
  backends.push_back(*std::move(backend));
  auto server = InProcessServer::Start(QuietOptions(), std::move(backends));
  EXPECT_OK(server);
  return server.ok() ? *std::move(server) : nullptr;
}

// A lattice around a part of the torus: seven of ten in each direction.
v1::CreateSceneRequest PartlyOutside() {
  const Bounds bounds = SceneTorus().ComputeBounds();
  const Vec3d size = bounds.max - bounds.min, origin = bounds.min + 0.15 * size;
  v1::CreateSceneRequest create;
  v1::LatticeFrame& frame = *create.add_lattices()->mutable_lattice()->mutable_frame();
  frame.mutable_origin()->set_x(origin.x);
  frame.mutable_origin()->set_y(origin.y);
  frame.mutable_origin()->set_z(origin.z);
  frame.mutable_u()->set_x(0.7 * size.x);
  frame.mutable_v()->set_y(0.7 * size.y);
  frame.mutable_w()->set_z(0.7 * size.z);
  return create;
}

// How often an edge of the triangles, between points of the same bits, lacks its other side.
size_t Cracks(const PatchSurface& surface) {
  std::map<std::array<uint32_t, 3>, uint32_t> numbers;
  std::vector<uint32_t> welded;
  for (const Vec3f& position : surface.positions) {
    std::array<uint32_t, 3> bits;
    std::memcpy(bits.data(), &position, sizeof(bits));
    welded.push_back(
        numbers.try_emplace(bits, static_cast<uint32_t>(numbers.size())).first->second);
  }
  std::map<std::pair<uint32_t, uint32_t>, int> sides;
  for (const auto& triangle : surface.triangles) {
    for (size_t e = 0; e < 3; ++e) {
      const uint32_t a = welded[triangle[e]], b = welded[triangle[(e + 1) % 3]];
      sides[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  size_t cracks = 0;
  for (const auto& [edge, sum] : sides) cracks += sum != 0 ? 1 : 0;
  return cracks;
}

// What a client has of a scene after each of some edits.
struct Watched {
  std::string topology_id;
  std::shared_ptr<const PatchPlan> plan;
  std::vector<std::vector<uint8_t>> bounds;  // by edit
  std::vector<size_t> cracks, points;        // by edit
  uint64_t bytes = 0;                        // of the server's memory for bounds
};

// Moves control points in the middle of a lattice of 4 x 4 x 4, so that its faces stay attached, then a corner.
Watched Watch(int devices) {
  Watched watched;
  const auto server = StartOnDevices(devices);
  Client client(server->channel(), "");
  const auto scene = CreateTorusScene(client, PartlyOutside());
  EXPECT_OK(scene);
  EXPECT_GT(scene->patches_outside(), 0u);
  v1::WatchRequest watch;
  watch.set_scene(scene->id());
  watch.mutable_view()->set_encoding(v1::ENCODING_PATCHES);
  auto stream = client.Deform(watch);
  EXPECT_OK(stream);
  const Surface& held = (*stream)->surface();
  watched.topology_id = held.topology().topology_id();
  const auto plan = client.GetPatchPlan(scene->id(), watched.topology_id, held.view().normals());
  EXPECT_OK(plan);
  watched.plan = *plan;
  auto evaluator = PatchEvaluator::Create(*plan, FromProto(held.lattice().lattice())->structure);
  EXPECT_OK(evaluator);
  for (const uint32_t index : {21u, 38u, 26u, 41u, 0u}) {
    v1::EditBatch batch;
    auto* move = batch.add_edits()->mutable_move_control_points();
    move->add_indices(index);
    move->mutable_offset()->set_x(0.3);
    move->mutable_offset()->set_z(0.2);
    const auto sequence = (*stream)->Send(batch);
    EXPECT_OK(sequence);
    EXPECT_OK((*stream)->WaitFor(*sequence));
    watched.bounds.push_back(*held.EdgeBounds());
    PatchSurface surface;
    EXPECT_OK(evaluator->Evaluate(FromProto(held.lattice().lattice())->control_points,
                                  watched.bounds.back(), kFineTolerance, &surface));
    watched.cracks.push_back(Cracks(surface));
    watched.points.push_back(surface.positions.size());
  }
  const auto now = client.GetScene(scene->id());
  EXPECT_OK(now);
  watched.bytes = now->bytes().at("bounds");
  return watched;
}

TEST(SpannedPatches, AClientSeesTheSceneOfOneDevice) {
  const Watched one = Watch(1);
  ASSERT_NE(one.plan, nullptr);
  EXPECT_GT(one.points.front(), 4 * one.plan->patches.size()) << "some edges are split";
  for (const int devices : {2, 4}) {
    SCOPED_TRACE(devices);
    const Watched several = Watch(devices);

    EXPECT_EQ(several.topology_id, one.topology_id);
    ASSERT_NE(several.plan, nullptr);
    EXPECT_EQ(several.plan->places, one.plan->places);
    EXPECT_EQ(several.plan->edge_seams, one.plan->edge_seams);
    EXPECT_EQ(several.bounds, one.bounds);
    EXPECT_EQ(several.points, one.points);
    EXPECT_GT(several.bytes, one.bytes) << "both sides of a cut, and the bytes of all edges";
    EXPECT_LT(several.bytes, 2 * one.bytes);
    // The last edit tears the surface at the lattice's faces.
    for (size_t edit = 0; edit + 1 < several.cracks.size(); ++edit) {
      EXPECT_EQ(several.cracks[edit], 0u) << "edit " << edit;
    }
    EXPECT_EQ(several.cracks.back(), one.cracks.back());
    EXPECT_GT(several.cracks.back(), 0u);
  }
}

}  // namespace
}  // namespace latticed::client
