// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Cutting on its own: snapping, shared cut points, convex triangulation.
#include "core/ffd/plan/knot_split.h"

#include <gtest/gtest.h>

#include <numeric>

#include "core/ffd/plan/convex_triangulation.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

LatticeStructure UnitCube(int size) {
  LatticeStructure s{.degree = {1, 1, 1}, .size = {size, size, size}};
  for (size_t a = 0; a < 3; ++a) s.knots[a] = ClampedUniformKnots(1, size);
  s.frame = {{0, 0, 0}, {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}};
  return s;
}

PolygonMesh Triangles(std::vector<Vec3d> positions, std::vector<uint32_t> corners) {
  PolygonMesh mesh;
  mesh.positions = std::move(positions);
  mesh.corner_vertices = std::move(corners);
  for (uint32_t c = 3; c <= mesh.corner_vertices.size(); c += 3) mesh.face_offsets.push_back(c);
  return mesh;
}

TEST(KnotSplit, VerticesWithinTheSnapAreOnThePlane) {
  const double near = 0.5 + 0x1p-42, far = 0.5 + 0x1p-36;
  const PolygonMesh mesh =
      Triangles({{near, 0.1, 0.1}, {far, 0.1, 0.1}, {0.9, 0.9, 0.4}}, {0, 1, 2});
  ASSERT_OK_AND_ASSIGN(const auto split, SplitAtKnots(mesh, UnitCube(3)));
  EXPECT_EQ(split.vertices[0].parameter.x, 1.0);  // knots 0, 1, 2 over the unit cube
  EXPECT_GT(split.vertices[1].parameter.x, 1.0);
  EXPECT_EQ(split.vertices[0].world.x, near) << "the world keeps the vertex where it was";
}

TEST(KnotSplit, NeighboursShareCutPointsAcrossSeamsOfIndices) {
  // Two triangles share a diagonal, whose ends are stored twice, as at a UV seam.
  const PolygonMesh mesh = Triangles({{0.1, 0.1, 0.2},
                                      {0.9, 0.1, 0.2},
                                      {0.8, 0.9, 0.2},
                                      {0.1, 0.1, 0.2},
                                      {0.8, 0.9, 0.2},
                                      {0.2, 0.8, 0.2}},
                                     {0, 1, 2, 3, 4, 5});
  ASSERT_OK_AND_ASSIGN(const auto split, SplitAtKnots(mesh, UnitCube(4)));
  // Euler: V - E + F = 1 for a disc. A doubled vertex would break this.
  std::vector<std::pair<uint32_t, uint32_t>> edges;
  std::vector<uint32_t> vertices;
  for (const SplitPiece& piece : split.pieces) {
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t a = piece.vertex[c], b = piece.vertex[(c + 1) % 3];
      edges.emplace_back(std::min(a, b), std::max(a, b));
      vertices.push_back(a);
    }
  }
  const auto distinct = [](auto list) {
    std::sort(list.begin(), list.end());
    return std::unique(list.begin(), list.end()) - list.begin();
  };
  EXPECT_EQ(distinct(vertices) - distinct(edges) + static_cast<long>(split.pieces.size()), 1);
}

TEST(KnotSplit, DropsTrianglesOfTwoPositions) {
  const PolygonMesh mesh =
      Triangles({{0.1, 0.1, 0.2}, {0.9, 0.1, 0.2}, {0.1, 0.1, 0.2}}, {0, 1, 2});
  ASSERT_OK_AND_ASSIGN(const auto split, SplitAtKnots(mesh, UnitCube(2)));
  EXPECT_TRUE(split.pieces.empty());
}

TEST(ConvexTriangulation, AvoidsTrianglesWithoutArea) {
  // A square with a vertex in the middle of each side, where a fan from a corner would make slivers.
  const std::vector<Vec3d> points{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0},
                                  {2, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}};
  double area = 0, worst = 1;
  size_t count = 0;
  TriangulateConvex(points, [&](size_t a, size_t b, size_t c) {
    area += 0.5 * Cross(points[b] - points[a], points[c] - points[a]).z;
    worst = std::min(worst, TriangleQuality(points[a], points[b], points[c]));
    ++count;
  });
  EXPECT_EQ(count, 6u);
  EXPECT_DOUBLE_EQ(area, 4.0);
  EXPECT_GE(worst, 0.5);
}

}  // namespace
}  // namespace latticed
