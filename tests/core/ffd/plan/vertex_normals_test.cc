// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Creases: which faces a corner's normal is a sum of.
#include "core/ffd/plan/vertex_normals.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "gmock/gmock.h"
#include "tests/support/real_meshes.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

double DegreesBetween(Vec3d a, Vec3d b) {
  return std::atan2(Norm(Cross(a, b)), Dot(a, b)) * 180 / std::numbers::pi;
}

Vec3d FaceNormal(const PolygonMesh& mesh, size_t face) {
  const std::vector<Vec3d> p = FacePositions(mesh, face);
  Vec3d sum;
  for (size_t k = 1; k + 1 < p.size(); ++k) sum += Cross(p[k] - p[0], p[k + 1] - p[0]);
  return sum;
}

std::vector<Vec3d> Normals(const PolygonMesh& mesh, std::optional<double> crease_angle) {
  const auto normals = UnitCornerNormals(mesh, crease_angle);
  EXPECT_OK(normals);
  std::vector<Vec3d> out;
  for (const Vec3f n : *normals) out.push_back(ToDouble(n));
  return out;
}

// The largest angle between a corner's normal and its face's; faces without area do not count.
double LargestDegrees(const PolygonMesh& mesh, std::optional<double> crease_angle) {
  const std::vector<Vec3d> normals = Normals(mesh, crease_angle);
  double largest = 0;
  for (size_t f = 0; f < mesh.face_count(); ++f) {
    const Vec3d face_normal = FaceNormal(mesh, f);
    if (!(Norm(face_normal) > 0)) continue;
    for (uint32_t c = mesh.face_offsets[f]; c < mesh.face_offsets[f + 1]; ++c) {
      largest = std::max(largest, DegreesBetween(normals[c], face_normal));
    }
  }
  return largest;
}

void AddFace(PolygonMesh& mesh, const std::vector<uint32_t>& vertices) {
  mesh.corner_vertices.insert(mesh.corner_vertices.end(), vertices.begin(), vertices.end());
  mesh.face_offsets.push_back(static_cast<uint32_t>(mesh.corner_vertices.size()));
}

// An open prism around z, radius 1, whose sides meet at 360 / sides degrees.
PolygonMesh Prism(uint32_t sides) {
  PolygonMesh mesh;
  for (uint32_t k = 0; k < sides; ++k) {
    const double angle = 2 * std::numbers::pi * k / sides;
    // Rounded to float, as most files have it.
    const auto x = static_cast<float>(std::cos(angle)), y = static_cast<float>(std::sin(angle));
    mesh.positions.push_back({x, y, 0});
    mesh.positions.push_back({x, y, 0.25});
  }
  for (uint32_t k = 0; k < sides; ++k) {
    const uint32_t next = (k + 1) % sides;
    AddFace(mesh, {2 * k, 2 * next, 2 * next + 1, 2 * k + 1});
  }
  return mesh;
}

TEST(VertexNormals, ABoxStaysABox) {
  EXPECT_EQ(LargestDegrees(CubeMesh(4), {}), 0);
  EXPECT_EQ(LargestDegrees(CubeMesh(4), 89.9), 0);
  EXPECT_NEAR(LargestDegrees(CubeMesh(1), 90),
              std::acos(1 / std::sqrt(3.)) * 180 / std::numbers::pi, 1e-5);
}

TEST(VertexNormals, AnEdgeOfJustTheCreaseAngleIsSmoothThoughPositionsAreRounded) {
  EXPECT_NEAR(LargestDegrees(Prism(12), {}), 15, 1e-4);
  EXPECT_NEAR(LargestDegrees(Prism(12), 29.9), 0, 1e-4);
  EXPECT_NEAR(LargestDegrees(Prism(11), {}), 0, 1e-4);
  EXPECT_NEAR(LargestDegrees(Prism(11), 33), 360 / 11. / 2, 1e-4);
}

TEST(VertexNormals, AngleZeroIsFlatAndAngle180Smooth) {
  const PolygonMesh soup = TriangleSoup(200, 7);
  EXPECT_NEAR(LargestDegrees(soup, 0), 0, 1e-3);
  EXPECT_NEAR(LargestDegrees(Prism(3), 0), 0, 1e-4);
  EXPECT_NEAR(LargestDegrees(Prism(3), 180), 60, 1e-4);

  PolygonMesh both_sides;  // a triangle, and behind it a smaller one at two of its corners
  both_sides.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0.5, 0}};
  AddFace(both_sides, {0, 1, 2});
  AddFace(both_sides, {1, 0, 3});
  EXPECT_NEAR(LargestDegrees(both_sides, 179.9), 0, 1e-4);
  EXPECT_NEAR(LargestDegrees(both_sides, 180), 180, 1e-4) << "the larger face decides";
}

// A sum of all faces within the angle of a corner's own face would differ from corner to corner here.
TEST(VertexNormals, CornersThatSmoothEdgesJoinHaveTheSameNormal) {
  PolygonMesh fan;  // five faces along y, 20 degrees apart
  for (int k = 0; k < 6; ++k) {
    const double angle = k * 20 * std::numbers::pi / 180;
    fan.positions.push_back({std::cos(angle), 0, std::sin(angle)});
    fan.positions.push_back({std::cos(angle), 1, std::sin(angle)});
  }
  for (uint32_t k = 0; k + 1 < 6; ++k) {
    AddFace(fan, {2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2});
  }
  const std::vector<Vec3d> smooth = Normals(fan, {});
  for (uint32_t f = 0; f + 1 < 5; ++f) {
    EXPECT_EQ(Norm(smooth[4 * f + 2] - smooth[4 * (f + 1) + 1]), 0) << f;
    EXPECT_EQ(Norm(smooth[4 * f + 3] - smooth[4 * (f + 1)]), 0) << f;
  }

  PolygonMesh cones;  // two pyramids that touch with their tips
  cones.positions = {{0, 0, 0},  {1, 0, 1},  {0, 1, 1},   {-1, -1, 1},
                     {1, 0, -1}, {0, 1, -1}, {-1, -1, -1}};
  for (const auto& [a, b] : {std::pair<uint32_t, uint32_t>{1, 2}, {2, 3}, {3, 1}}) {
    AddFace(cones, {0, b, a});
    AddFace(cones, {0, a + 3, b + 3});
  }
  const std::vector<Vec3d> tips = Normals(cones, 180);
  EXPECT_LT(tips[0].z, -0.9);
  EXPECT_GT(tips[3].z, 0.9);
}

TEST(VertexNormals, SeamsOfOtherAttributesAndFacesThatRepeatAPositionDoNotCount) {
  PolygonMesh welded = Prism(24), torn = welded;
  torn.positions.clear();
  for (uint32_t& vertex : torn.corner_vertices) {
    torn.positions.push_back(welded.positions[vertex]);
    vertex = static_cast<uint32_t>(torn.positions.size()) - 1;
  }
  const std::vector<Vec3d> expected = Normals(welded, {}), got = Normals(torn, {});
  ASSERT_EQ(got.size(), 96);
  for (size_t c = 0; c < 96; ++c) EXPECT_EQ(Norm(got[c] - expected[c]), 0) << c;

  PolygonMesh repeated = Prism(24);  // its first face has the first corner twice
  repeated.corner_vertices.insert(repeated.corner_vertices.begin(), repeated.corner_vertices[0]);
  for (size_t f = 1; f < repeated.face_offsets.size(); ++f) ++repeated.face_offsets[f];
  const std::vector<Vec3d> normals = Normals(repeated, {});
  EXPECT_EQ(Norm(normals[0] - normals[1]), 0);
  EXPECT_GT(DegreesBetween(normals[0], FaceNormal(repeated, 0)), 3);
}

TEST(VertexNormals, OfManyFacesAtAnEdgeThoseOfOneSurfaceAreJoined) {
  PolygonMesh doubled = Prism(24);  // both sides of every face
  for (uint32_t f = 0; f < 24; ++f) {
    std::vector<uint32_t> back(doubled.corner_vertices.begin() + 4 * f,
                               doubled.corner_vertices.begin() + 4 * f + 4);
    std::reverse(back.begin(), back.end());
    AddFace(doubled, back);
  }
  EXPECT_NEAR(LargestDegrees(doubled, {}), 7.5, 1e-4);

  PolygonMesh wall;  // a floor of two faces, with a wall on their common edge
  wall.positions = {{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {-1, 1, 0.1},
                    {0, 1, 0},  {1, 1, 0}, {0, 0, 1}, {0, 1, 1}};
  AddFace(wall, {0, 1, 4, 3});
  AddFace(wall, {1, 4, 7, 6});
  AddFace(wall, {1, 2, 5, 4});
  const std::vector<Vec3d> normals = Normals(wall, {});
  EXPECT_EQ(Norm(normals[1] - normals[8]), 0);
  EXPECT_GT(DegreesBetween(normals[1], normals[4]), 80);
}

TEST(VertexNormals, TheFilesNormalsAreKeptUnlessAnAngleIsAskedFor) {
  PolygonMesh cube = CubeMesh(1);
  cube.normals = {{0, 3, 4}, {0, 0, 0}};
  cube.corner_normals.assign(cube.corner_count(), 0);
  cube.corner_normals[0] = 1;  // no length
  cube.corner_normals[1] = PolygonMesh::kNoAttribute;
  const std::vector<Vec3d> kept = Normals(cube, {});
  EXPECT_NEAR(Norm(kept[2] - Vec3d{0, 0.6, 0.8}), 0, 1e-7);
  EXPECT_NEAR(DegreesBetween(kept[0], FaceNormal(cube, 0)), 0, 1e-5);
  EXPECT_NEAR(DegreesBetween(kept[1], FaceNormal(cube, 0)), 0, 1e-5);
  EXPECT_NEAR(LargestDegrees(cube, 30), 0, 1e-5);
}

TEST(VertexNormals, FandiskKeepsItsEdges) {
  for (const RealMesh& model : RealMeshes()) {
    if (model.name != "fandisk") continue;
    EXPECT_LT(LargestDegrees(model.mesh, 30), 30);
    EXPECT_GT(LargestDegrees(model.mesh, 180), 60);
    return;
  }
  GTEST_SKIP() << "no fandisk in $LATTICED_SHARED/models";
}

}  // namespace
}  // namespace latticed::testing
