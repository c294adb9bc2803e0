// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Plans of real meshes keep what they cut: area, and edges by the number of faces that meet there.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "core/ffd/deform_plan.h"
#include "core/mesh/triangulate.h"
#include "tests/support/real_meshes.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

constexpr double kArea = 1e-6;    // relative
constexpr double kLength = 1e-9;  // of the mesh's diagonal

// The same for the triangles of a mesh, by the project's rule, and for the patches of its plan.
struct Measures {
  double area = 0;
  std::map<int, double> length;  // of the edges that so many triangles share
};

// Edges by the positions of their ends: seams of normals or UVs are no boundary.
using Position = std::tuple<double, double, double>;
using EdgeUse = std::map<std::pair<Position, Position>, int>;

void AddTriangle(Vec3d a, Vec3d b, Vec3d c, double& area, EdgeUse& use) {
  area += 0.5 * Norm(Cross(b - a, c - a));
  const auto at = [](Vec3d p) { return Position{p.x, p.y, p.z}; };
  for (const auto& [p, q] : {std::pair{at(a), at(b)}, {at(b), at(c)}, {at(c), at(a)}}) {
    ++use[{std::min(p, q), std::max(p, q)}];
  }
}

Measures Finish(double area, const EdgeUse& use) {
  Measures measures{.area = area};
  for (const auto& [edge, count] : use) {
    const auto [ax, ay, az] = edge.first;
    const auto [bx, by, bz] = edge.second;
    measures.length[count] += Norm(Vec3d{ax, ay, az} - Vec3d{bx, by, bz});
  }
  return measures;
}

Measures OfMesh(const PolygonMesh& mesh) {
  double area = 0;
  EdgeUse use;
  std::vector<std::array<uint32_t, 3>> triangles;
  for (size_t f = 0; f < mesh.face_count(); ++f) {
    std::vector<Vec3d> polygon;
    for (uint32_t c = mesh.face_offsets[f]; c < mesh.face_offsets[f + 1]; ++c) {
      polygon.push_back(mesh.positions[mesh.corner_vertices[c]]);
    }
    triangles.clear();
    TriangulatePolygon(polygon, &triangles);
    for (const auto& [a, b, c] : triangles) {
      AddTriangle(polygon[a], polygon[b], polygon[c], area, use);
    }
  }
  return Finish(area, use);
}

Measures OfPlan(const DeformPlan& plan) {
  double area = 0;
  EdgeUse use;
  for (const Patch& patch : plan.patches) {
    const auto at = [&](size_t c) { return plan.vertices[patch.vertex[c]].world; };
    AddTriangle(at(0), at(1), at(2), area, use);
  }
  return Finish(area, use);
}

TEST(RealMeshPlans, KeepAreaAndBoundary) {
  std::vector<RealMesh> meshes = RealMeshes();
  if (meshes.empty()) GTEST_SKIP() << "no meshes in $LATTICED_SHARED/models";
  for (auto& [name, mesh] : meshes) {
    for (const double scale : {1.1, 0.7}) {  // wholly inside, and partly outside
      SCOPED_TRACE(name);
      const double diagonal = mesh.ComputeBounds().diagonal();
      const LatticeStructure structure =
          MakeStructure(mesh.ComputeBounds(), {.extra = {3, 4, 5}, .scale = scale});
      const auto plan = MakePlan(std::make_shared<const PolygonMesh>(mesh), structure);
      ASSERT_OK(plan);

      const Measures source = OfMesh(mesh), cut = OfPlan(**plan);

      EXPECT_GT((*plan)->patches.size(), mesh.face_count());
      EXPECT_NEAR(cut.area, source.area, kArea * source.area);
      // Cutting adds edges of two patches inside faces, and none of any other kind.
      for (int count = 1; count <= 8; ++count) {
        if (count == 2) continue;
        const auto of = [count](const Measures& m) {
          const auto found = m.length.find(count);
          return found == m.length.end() ? 0.0 : found->second;
        };
        EXPECT_NEAR(of(cut), of(source), kLength * diagonal) << count << " patches an edge";
      }
    }
  }
}

}  // namespace
}  // namespace latticed::testing
