// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A server on a folder, with a unit cube of which a lattice surrounds the lower half in x.
#ifndef LATTICED_TESTS_SERVER_OUTSIDE_OUTSIDE_FIXTURE_H_
#define LATTICED_TESTS_SERVER_OUTSIDE_OUTSIDE_FIXTURE_H_

#include <array>
#include <initializer_list>
#include <string>
#include <vector>

#include "core/base/vec.h"
#include "fmt/format.h"
#include "tests/server/support/server_test.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {

// The unit cube. Its middle in x is 0.5, where the lattice ends.
inline constexpr char kUnitCubeObj[] =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

inline constexpr double kFaceAt = 0.5;  // the lattice's end in u

class OutsideSceneTest : public SceneFixture {
 protected:
  void SetUp() override {
    Restart();
    mesh_ = Upload(kUnitCubeObj);
  }
  void Restart() {
    const std::string mesh = mesh_;
    server_.reset();
    Options options;
    options.data_dir = folder_.Path("data");
    SceneFixture::StartServer(options);
    mesh_ = mesh;
  }
  // 4 x 4 x 4 control points of degree 2 around x in [-0.1, 0.5], y and z in [-0.1, 1.1].
  static v1::Lattice HalfLattice() {
    v1::Lattice lattice;
    SetFrame(*lattice.mutable_frame(), {-0.1, -0.1, -0.1}, {0.6, 1.2, 1.2});
    return lattice;
  }
  // A falloff beyond the end of u alone; its width is in lengths of the edge, 0.6.
  static v1::Lattice Falloff(
      double width, v1::OutsideContinuity continuity = v1::OUTSIDE_CONTINUITY_UNSPECIFIED) {
    v1::Lattice lattice = HalfLattice();
    lattice.mutable_outside()->set_mode(v1::OUTSIDE_MODE_FALLOFF);
    lattice.mutable_outside()->set_continuity(continuity);
    for (const double w : {0., width, 0., 0., 0., 0.}) lattice.mutable_outside()->add_widths(w);
    return lattice;
  }
  static v1::Lattice Linear() {
    v1::Lattice lattice = HalfLattice();
    lattice.mutable_outside()->set_mode(v1::OUTSIDE_MODE_LINEAR);
    return lattice;
  }
  v1::CreateSceneRequest RequestFor(const v1::Lattice& lattice,
                                    const std::string& id = kScene) const {
    v1::CreateSceneRequest request = SceneRequest(id);
    *request.add_lattices()->mutable_lattice() = lattice;
    return request;
  }
  // Of all control points of the last layer in u, which is the face.
  v1::EditBatch MoveFace(uint64_t sequence, Vec3d offset, const std::string& scene = kScene) const {
    v1::EditBatch batch = MoveOne("ann", sequence, 3, offset);
    batch.set_scene(scene);
    auto* indices = batch.mutable_edits(0)->mutable_move_control_points()->mutable_indices();
    indices->Clear();
    for (uint32_t row = 0; row < 16; ++row) indices->Add(3 + 4 * row);
    return batch;
  }
  static v1::EditBatch Replace(uint64_t sequence, const v1::Lattice& lattice,
                               uint64_t structure = 1) {
    v1::EditBatch batch = MoveOne("ann", sequence, 0, {});
    batch.set_structure_id(structure);
    *batch.mutable_edits(0)->mutable_replace_lattice()->mutable_lattice() = lattice;
    return batch;
  }
  std::vector<Vec3d> Evaluate(const std::vector<Vec3d>& world, const std::string& scene = kScene) {
    auto request = For<v1::EvaluatePointsRequest>(scene);
    for (const Vec3d p : world) {
      for (int a = 0; a < 3; ++a) request.mutable_world_points()->add_positions(p[a]);
    }
    v1::EvaluatePointsResponse response;
    EXPECT_OK(Call(&Scenes::EvaluatePoints, request, &response));
    std::vector<Vec3d> points;
    for (int i = 0; i + 2 < response.positions_size(); i += 3) {
      points.push_back(
          {response.positions(i), response.positions(i + 1), response.positions(i + 2)});
    }
    EXPECT_EQ(points.size(), world.size());
    return points;
  }
  Vec3d Evaluate(Vec3d world, const std::string& scene = kScene) {
    return Evaluate(std::vector<Vec3d>{world}, scene).at(0);
  }
  absl::Status Volume(v1::MeasureSceneResponse* got, bool with_gradient = false) {
    auto request = For<v1::MeasureSceneRequest>();
    request.add_measures(v1::MEASURE_VOLUME);
    request.set_with_gradient(with_gradient);
    return Call(&Scenes::MeasureScene, request, got);
  }

  TemporaryFolder folder_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_OUTSIDE_OUTSIDE_FIXTURE_H_
