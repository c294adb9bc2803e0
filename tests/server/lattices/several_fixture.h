// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A unit cube in two lattices: one around all of it, and one around a part of it, which fades out. Its frame is parallel to the
// other one or turned.
#ifndef LATTICED_TESTS_SERVER_LATTICES_SEVERAL_FIXTURE_H_
#define LATTICED_TESTS_SERVER_LATTICES_SEVERAL_FIXTURE_H_

#include <random>
#include <string>
#include <vector>

#include "core/ffd/lattice.h"
#include "tests/server/outside/outside_fixture.h"

namespace latticed::testing {

class SeveralLatticesTest : public OutsideSceneTest {
 protected:
  static constexpr uint32_t kSeed = 62;

  // 4 x 4 x 4 control points around the whole cube.
  static v1::Lattice Whole(std::array<int, 3> degree = {2, 2, 2}) {
    v1::Lattice lattice;
    SetFrame(*lattice.mutable_frame(), {-0.1, -0.1, -0.1}, {1.2, 1.2, 1.2});
    SetAxes(*lattice.mutable_degree(), degree[0], degree[1], degree[2]);
    return lattice;
  }
  // 4 x 4 x 4 around a part of the cube, z from -0.1 to 0.3, x and y from 0.2 to 0.6. It fades out within the cube.
  static v1::Lattice Spot(std::array<int, 3> degree = {2, 2, 2}) {
    v1::Lattice lattice;
    SetFrame(*lattice.mutable_frame(), {0.2, 0.2, -0.1}, {0.4, 0.4, 0.4});
    SetAxes(*lattice.mutable_degree(), degree[0], degree[1], degree[2]);
    lattice.mutable_outside()->set_mode(v1::OUTSIDE_MODE_FALLOFF);
    for (const double w : {0.5, 0.5, 0.5, 0.5, 0., 0.5}) lattice.mutable_outside()->add_widths(w);
    return lattice;
  }
  // The same, turned about the z axis, and elsewhere.
  static v1::Lattice TurnedSpot(std::array<int, 3> degree = {2, 2, 2}) {
    v1::Lattice lattice = Spot(degree);
    v1::LatticeFrame& frame = *lattice.mutable_frame();
    SetFrame(frame, {0.4, 0.15, -0.1}, {0.35, 0.35, 0.4});
    frame.mutable_u()->set_y(0.2);
    frame.mutable_v()->set_x(-0.2);
    return lattice;
  }
  // Sets x y z of all control points: those at rest, each moved at random.
  v1::Lattice Shaken(v1::Lattice lattice) {
    LatticeStructure s;
    s.degree = {lattice.degree().u(), lattice.degree().v(), lattice.degree().w()};
    for (size_t a = 0; a < 3; ++a) s.knots[a] = ClampedUniformKnots(s.degree[a], s.size[a]);
    const auto vector = [](const auto& v) { return Vec3d{v.x(), v.y(), v.z()}; };
    const auto& frame = lattice.frame();
    s.frame = {vector(frame.origin()), {vector(frame.u()), vector(frame.v()), vector(frame.w())}};
    std::uniform_real_distribution<double> move(-0.1, 0.1);
    for (const Vec3d p : IdentityControlPoints(s)) {
      for (int a = 0; a < 3; ++a) lattice.add_control_points(p[a] + move(random_));
    }
    return lattice;
  }
  v1::CreateSceneRequest RequestOf(const std::vector<v1::Lattice>& lattices,
                                   const std::string& id = kScene) const {
    v1::CreateSceneRequest request = SceneRequest(id);
    for (const v1::Lattice& lattice : lattices) {
      *request.add_lattices()->mutable_lattice() = lattice;
    }
    return request;
  }
  // Of raw points by 3 segments, with room for ten updates that are not acknowledged.
  v1::WatchRequest RawWatch() const {
    v1::WatchRequest watch = For<v1::WatchRequest>();
    watch.mutable_view()->set_encoding(v1::ENCODING_RAW);
    watch.mutable_view()->set_segments(3);
    watch.set_max_unacked_updates(10);
    return watch;
  }
  static v1::EditBatch MoveIn(uint32_t lattice, uint64_t sequence, uint32_t index, Vec3d offset) {
    v1::EditBatch batch = MoveOne("ann", sequence, index, offset);
    batch.set_lattice(lattice);
    return batch;
  }
  v1::LatticeState LatticeAt(uint32_t index) {
    auto request = For<v1::GetLatticeRequest>();
    request.set_lattice(index);
    v1::LatticeState state;
    EXPECT_OK(Call(&Scenes::GetLattice, request, &state));
    EXPECT_EQ(state.index(), index);
    return state;
  }
  std::vector<Vec3d> SomePoints(int count) {
    std::uniform_real_distribution<double> place(0, 1);
    std::vector<Vec3d> points;
    for (int n = 0; n < count; ++n) {
      points.push_back({place(random_), place(random_), place(random_)});
    }
    return points;
  }
  // Raw chunks of 3 segments: positions do not depend on the scene's grid.
  auto Chunks(const std::string& scene = kScene) {
    auto request = For<v1::GetUpdateRequest>(scene);
    request.mutable_view()->set_encoding(v1::ENCODING_RAW);
    request.mutable_view()->set_segments(3);
    EventLog log;
    EXPECT_OK(Update(request, log));
    EXPECT_FALSE(log.chunks.empty());
    return log.chunks;
  }

  std::mt19937 random_{kSeed};
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_LATTICES_SEVERAL_FIXTURE_H_
