// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Procedural meshes and lattices for tests. They are small, and together cover the difficult cases of
// real meshes.
#ifndef LATTICED_TESTS_SUPPORT_TEST_MESHES_H_
#define LATTICED_TESTS_SUPPORT_TEST_MESHES_H_

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/ffd/lattice.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed::testing {

// A closed torus of rings * sides quads around the z axis, radii 1 and 0.4, with vertex normals.
[[nodiscard]] PolygonMesh TorusMesh(int rings, int sides, Vec3d centre = {});
// n * n quads on [0, 1]^2 at height z: flat, and aligned with the planes of any uniform lattice.
[[nodiscard]] PolygonMesh FlatGrid(int n, double z);
// The surface of the cube [0, 1]^3, n * n quads a side: every face lies in a face of the fitted
// frame.
[[nodiscard]] PolygonMesh CubeMesh(int n);
[[nodiscard]] PolygonMesh OneTriangle();
// The corners of a face.
[[nodiscard]] std::vector<Vec3d> FacePositions(const PolygonMesh& mesh, size_t face);
// `count` unconnected triangles in [-1, 1]^3, every fourth a sliver of height 1e-5.
[[nodiscard]] PolygonMesh TriangleSoup(int count, uint32_t seed);

// A binary PLY file of one strip, a byte an index: as many triangles, less two.
[[nodiscard]] std::string PlyStrip(uint32_t indices);

enum class KnotKind { kUniform, kNonUniform, kUnclamped, kRepeated };
// Knots for an axis of `size` control points. kRepeated: the first interior knot has multiplicity
// `degree`, if there are that many interior knots.
[[nodiscard]] std::vector<double> MakeKnots(KnotKind kind, int degree, int size);

struct LatticeOptions {
  std::array<int, 3> degree{2, 2, 2};
  std::array<int, 3> extra{2, 1, 2};  // size = degree + 1 + extra
  KnotKind knots = KnotKind::kUniform;
  double shear = 0;       // off-diagonal parts of the frame's edges / their diagonal parts
  bool mirrored = false;  // a left-handed frame
  double scale = 1.1;     // frame edge / longest edge of the bounds; below 1: pieces lie outside
  double turn = 0;        // of the frame about its centre and the direction (1, 2, 2), in rad
  Vec3d shift;            // (frame centre - bounds' centre) / longest edge of the bounds
};
[[nodiscard]] LatticeStructure MakeStructure(const Bounds& bounds, const LatticeOptions& options);

// A mesh and a lattice with random degrees, knots, frame and position. Parts of the mesh may lie outside
// of the lattice.
struct RandomCase {
  PolygonMesh mesh;
  LatticeOptions options;
  int segments = 1;  // 1 … 8
};
[[nodiscard]] RandomCase DrawCase(uint32_t seed);

// Control points at rest plus uniform noise of `amount` times the shortest frame edge.
[[nodiscard]] std::vector<Vec3d> Jitter(const LatticeStructure& structure, double amount,
                                        uint32_t seed);

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SUPPORT_TEST_MESHES_H_
