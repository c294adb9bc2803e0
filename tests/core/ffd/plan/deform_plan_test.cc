// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Plans of small meshes that can be checked by hand, and of grids and real meshes: area,
// provenance, edges and ownership.
#include "core/ffd/plan/deform_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "core/mesh/triangulate.h"
#include "tests/support/real_meshes.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::HasSubstr;

constexpr double kLength = 1e-9;  // fraction of the mesh's diagonal

std::shared_ptr<PolygonMesh> Grid(int n, double wave) {
  auto mesh = std::make_shared<PolygonMesh>(testing::FlatGrid(n, 0));
  for (Vec3d& p : mesh->positions) p.z = wave * std::sin(9 * p.x) * std::cos(7 * p.y);
  return mesh;
}

std::shared_ptr<PolygonMesh> Triangle(Vec3d a, Vec3d b, Vec3d c) {
  auto mesh = std::make_shared<PolygonMesh>(testing::OneTriangle());
  mesh->positions = {a, b, c};
  return mesh;
}

LatticeStructure Cube(std::array<int, 3> size, std::array<int, 3> degree, Vec3d lower,
                      Vec3d upper) {
  LatticeStructure s{.degree = degree, .size = size};
  for (size_t a = 0; a < 3; ++a) s.knots[a] = ClampedUniformKnots(degree[a], size[a]);
  const Vec3d e = upper - lower;
  s.frame = {lower, {Vec3d{e.x, 0, 0}, Vec3d{0, e.y, 0}, Vec3d{0, 0, e.z}}};
  return s;
}

// Area and edge lengths, both of a mesh's triangles (by the project's rule) and of its plan's patches.
struct Measures {
  double area = 0;
  std::map<int, double> length;  // of edges, by the number of triangles that share them
};

// Edges are identified by the positions of their ends, since seams of normals or UVs are no boundary.
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
    const std::vector<Vec3d> polygon = testing::FacePositions(mesh, f);
    EXPECT_OK(TriangulatePolygon(polygon, &triangles));
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

// The plan keeps the area, the edges by the number of patches that meet there, and each corner's origin.
void ExpectKeepsTheMesh(const std::shared_ptr<const PolygonMesh>& mesh,
                        const LatticeStructure& structure, double area_tolerance) {
  ASSERT_OK_AND_ASSIGN(const auto plan, MakePlan(mesh, structure));
  const DeformPlan& p = *plan;
  const double diagonal = mesh->ComputeBounds().diagonal();

  const Measures source = OfMesh(*mesh), cut = OfPlan(p);

  EXPECT_NEAR(cut.area, source.area, area_tolerance * source.area);
  // Cutting adds edges between two patches inside faces, and no other edges.
  for (const int count : {1, 3, 4, 5, 6, 7, 8}) {
    const auto of = [count](const Measures& m) {
      const auto found = m.length.find(count);
      return found == m.length.end() ? 0.0 : found->second;
    };
    EXPECT_NEAR(of(cut), of(source), kLength * diagonal) << count << " patches an edge";
  }
  for (size_t i = 0; i < p.patches.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) {
      Vec3d from_source;
      for (size_t k = 0; k < 3; ++k) {
        const uint32_t vertex = mesh->corner_vertices[p.sources[i].corners[k]];
        from_source += p.sources[i].barycentrics[c][k] * mesh->positions[vertex];
      }
      ASSERT_LT(Norm(from_source - p.vertices[p.patches[i].vertex[c]].world), 1e-14 * diagonal);
    }
  }
}

TEST(DeformPlan, OneTriangleInOneBoxIsOnePatch) {
  const auto mesh = Triangle({0.2, 0.2, 0.5}, {0.8, 0.2, 0.5}, {0.2, 0.4, 0.5});

  ASSERT_OK_AND_ASSIGN(const auto plan,
                       MakePlan(mesh, Cube({2, 2, 2}, {1, 1, 1}, {0, 0, 0}, {1, 1, 1})));
  ASSERT_EQ(plan->patches.size(), 1u);
  EXPECT_EQ(plan->boxes.size(), 2u);
  EXPECT_EQ(plan->patches[0].box, 0u);
  EXPECT_EQ(plan->outside_patches, 0u);
  // The shortest edge, from (0.2, 0.4) to (0.2, 0.2), comes first.
  EXPECT_EQ(plan->vertices[plan->patches[0].vertex[0]].world, (Vec3d{0.2, 0.4, 0.5}));
}

TEST(DeformPlan, CutsOneTriangleAtOnePlane) {
  const auto mesh = Triangle({0, 0, 0.5}, {1, 0, 0.5}, {0, 1, 0.5});

  ASSERT_OK_AND_ASSIGN(const auto plan,
                       MakePlan(mesh, Cube({3, 2, 2}, {1, 1, 1}, {0, 0, 0}, {1, 1, 1})));
  // There is a quadrilateral left of u = 1 and a triangle right of it.
  EXPECT_EQ(plan->patches.size(), 3u);
  EXPECT_EQ(plan->box_patches, (std::vector<uint32_t>{0, 2, 3, 3}));
  EXPECT_DOUBLE_EQ(OfPlan(*plan).area, 0.5);
}

TEST(DeformPlan, KeepsWhatItCutsOfAGrid) {
  for (const auto& [lower, upper] :
       {std::pair{Vec3d{-0.1, -0.1, -1}, Vec3d{1.1, 1.1, 1}},
        std::pair{Vec3d{0.3, 0.2, -1}, Vec3d{0.77, 1.3, 1}},
        std::pair{Vec3d{0, 0, 0}, Vec3d{1, 1, 1}}, std::pair{Vec3d{3, 3, 3}, Vec3d{4, 4, 4}}}) {
    ExpectKeepsTheMesh(Grid(13, 0.0), Cube({6, 5, 4}, {2, 1, 3}, lower, upper), 1e-12);
  }
}

TEST(DeformPlan, KeepsWhatItCutsOfRealMeshes) {
  const std::vector<testing::RealMesh> meshes = testing::RealMeshes();
  if (meshes.empty()) GTEST_SKIP() << "no meshes in $LATTICED_SHARED/models";
  for (const auto& [name, mesh] : meshes) {
    for (const double scale : {1.1, 0.7}) {  // wholly inside, and partly outside
      SCOPED_TRACE(name);
      const LatticeStructure structure =
          testing::MakeStructure(mesh.ComputeBounds(), {.extra = {3, 4, 5}, .scale = scale});
      ExpectKeepsTheMesh(std::make_shared<const PolygonMesh>(mesh), structure, 1e-6);
    }
  }
}

TEST(DeformPlan, PatchesLieInTheirBoxAndOwnersAreLower) {
  ASSERT_OK_AND_ASSIGN(
      const auto plan,
      MakePlan(Grid(17, 0.2), Cube({6, 5, 4}, {2, 2, 2}, {0.1, -0.1, -0.1}, {0.9, 1.1, 0.15})));
  const DeformPlan& p = *plan;
  EXPECT_GT(p.outside_patches, 0u);
  EXPECT_GT(p.seam_patches, 0u);
  EXPECT_FALSE(p.seams.empty());
  for (const Patch& patch : p.patches) {
    if (patch.box == p.outside_box()) continue;
    const KnotBox& box = p.boxes[patch.box];
    for (const uint32_t v : patch.vertex) {
      for (int a = 0; a < 3; ++a) {
        EXPECT_GE(p.vertices[v].parameter[a], box.lower[a]);
        EXPECT_LE(p.vertices[v].parameter[a], box.upper[a]);
        EXPECT_LE(p.boxes[p.vertices[v].box].span[static_cast<size_t>(a)],
                  box.span[static_cast<size_t>(a)]);
      }
    }
  }
}

TEST(DeformPlan, SeamsDetachWhenAControlPointOnThemMoves) {
  ASSERT_OK_AND_ASSIGN(const auto plan, MakePlan(Grid(9, 0.1), Cube({4, 4, 4}, {2, 2, 2},
                                                                    {0.25, -1, -1}, {2, 2, 1})));
  std::vector<Vec3d> points = plan->identity_points;
  ASSERT_FALSE(plan->seams.empty());
  auto attached = AttachedSeams(*plan, points);
  EXPECT_EQ(std::count(attached.begin(), attached.end(), true),
            static_cast<int>(plan->seams.size()));

  points[static_cast<size_t>(plan->structure.Index(1, 1, 1))].z += 1;  // not on the u = 0 face
  attached = AttachedSeams(*plan, points);
  EXPECT_EQ(std::count(attached.begin(), attached.end(), false), 0);

  points[static_cast<size_t>(plan->structure.Index(0, 1, 1))].z += 1e-15;
  points[static_cast<size_t>(plan->structure.Index(0, 2, 2))].z += 1;
  attached = AttachedSeams(*plan, points);
  EXPECT_GT(std::count(attached.begin(), attached.end(), false), 0);
}

TEST(DeformPlan, RefusesAMeshWithoutArea) {
  const auto mesh = Triangle({0, 0, 0}, {1, 0, 0}, {0, 0, 0});
  EXPECT_THAT(MakePlan(mesh, Cube({2, 2, 2}, {1, 1, 1}, {0, 0, 0}, {1, 1, 1})),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("three corners")));
}

TEST(DeformPlan, StopsWhereverItIsToldTo) {
  const auto mesh = Grid(60, 0.2);
  const LatticeStructure structure = Cube({5, 5, 5}, {2, 2, 2}, {0, 0, -1}, {1, 1, 1});
  size_t asked = 0;
  const auto go_on = [&asked] {
    ++asked;
    return absl::OkStatus();
  };
  ASSERT_OK(MakePlan(mesh, structure, {}, go_on));
  const size_t most = asked;
  // The poll counts vertices and faces while splitting, then faces, patches and edges, some of them
  // twice.
  ASSERT_GE(most * StopPoll::kStepsPerCheck, 10 * mesh->face_count());

  for (size_t nth = 1; nth <= most; ++nth) {
    asked = 0;
    const auto stop = [&asked, nth] {
      return ++asked < nth ? absl::OkStatus() : absl::DeadlineExceededError("late");
    };
    EXPECT_THAT(MakePlan(mesh, structure, {}, stop), StatusIs(absl::StatusCode::kDeadlineExceeded));
    EXPECT_EQ(asked, nth) << "asked on after it was told to stop";
  }
}

}  // namespace
}  // namespace latticed
