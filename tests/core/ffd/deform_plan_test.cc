// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Plans of small meshes that a hand can check, and of a wavy grid: area, provenance, edges,
// ownership.
#include "core/ffd/deform_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "core/ffd/bspline_basis.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::HasSubstr;

std::shared_ptr<PolygonMesh> Grid(int n, double wave) {
  auto mesh = std::make_shared<PolygonMesh>();
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double x = static_cast<double>(i) / n, y = static_cast<double>(j) / n;
      mesh->positions.push_back({x, y, wave * std::sin(9 * x) * std::cos(7 * y)});
    }
  }
  const auto at = [n](int i, int j) { return static_cast<uint32_t>(i + (n + 1) * j); };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      for (const uint32_t v : {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)}) {
        mesh->corner_vertices.push_back(v);
      }
      mesh->face_offsets.push_back(static_cast<uint32_t>(mesh->corner_vertices.size()));
    }
  }
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

double TriangleArea(Vec3d a, Vec3d b, Vec3d c) { return 0.5 * Norm(Cross(b - a, c - a)); }

double PlanArea(const DeformPlan& plan) {
  double area = 0;
  for (const Patch& p : plan.patches) {
    area += TriangleArea(plan.vertices[p.vertex[0]].world, plan.vertices[p.vertex[1]].world,
                         plan.vertices[p.vertex[2]].world);
  }
  return area;
}

double MeshArea(
    const PolygonMesh& m) {  // quads of a grid, split like the plan's fixed rule or not:
  double area = 0;           // only planar faces give one answer, so wave is 0 where used
  for (size_t f = 0; f < m.face_count(); ++f) {
    const uint32_t b = m.face_offsets[f];
    for (uint32_t c = b + 1; c + 1 < m.face_offsets[f + 1]; ++c) {
      area += TriangleArea(m.positions[m.corner_vertices[b]], m.positions[m.corner_vertices[c]],
                           m.positions[m.corner_vertices[c + 1]]);
    }
  }
  return area;
}

// Edges by the number of patches that use them.
std::map<int, int> EdgeUse(const DeformPlan& plan) {
  std::vector<int> use(plan.edges.size());
  for (const Patch& p : plan.patches) {
    for (const uint32_t e : p.edge) ++use[e];
  }
  std::map<int, int> histogram;
  for (const int u : use) ++histogram[u];
  return histogram;
}

TEST(DeformPlan, OneTriangleInOneBoxIsOnePatch) {
  auto mesh = std::make_shared<PolygonMesh>();
  mesh->positions = {{0.2, 0.2, 0.5}, {0.8, 0.2, 0.5}, {0.2, 0.4, 0.5}};
  mesh->corner_vertices = {0, 1, 2};
  mesh->face_offsets = {0, 3};

  const auto plan = MakePlan(mesh, Cube({2, 2, 2}, {1, 1, 1}, {0, 0, 0}, {1, 1, 1}));

  ASSERT_OK(plan);
  ASSERT_EQ((*plan)->patches.size(), 1u);
  EXPECT_EQ((*plan)->boxes.size(), 2u);
  EXPECT_EQ((*plan)->patches[0].box, 0u);
  EXPECT_EQ((*plan)->outside_patches, 0u);
  // The longest edge, from (0.8, 0.2) to (0.2, 0.4), comes first.
  EXPECT_EQ((*plan)->vertices[(*plan)->patches[0].vertex[0]].world, (Vec3d{0.8, 0.2, 0.5}));
}

TEST(DeformPlan, CutsOneTriangleAtOnePlane) {
  auto mesh = std::make_shared<PolygonMesh>();
  mesh->positions = {{0, 0, 0.5}, {1, 0, 0.5}, {0, 1, 0.5}};
  mesh->corner_vertices = {0, 1, 2};
  mesh->face_offsets = {0, 3};

  const auto plan = MakePlan(mesh, Cube({3, 2, 2}, {1, 1, 1}, {0, 0, 0}, {1, 1, 1}));

  ASSERT_OK(plan);  // a quadrilateral left of u = 1, a triangle right of it
  EXPECT_EQ((*plan)->patches.size(), 3u);
  EXPECT_EQ((*plan)->box_patches, (std::vector<uint32_t>{0, 2, 3, 3}));
  EXPECT_DOUBLE_EQ(PlanArea(**plan), 0.5);
}

TEST(DeformPlan, GridKeepsAreaBoundaryAndProvenance) {
  for (const auto& [lower, upper] :
       {std::pair{Vec3d{-0.1, -0.1, -1}, Vec3d{1.1, 1.1, 1}},
        std::pair{Vec3d{0.3, 0.2, -1}, Vec3d{0.77, 1.3, 1}},
        std::pair{Vec3d{0, 0, 0}, Vec3d{1, 1, 1}}, std::pair{Vec3d{3, 3, 3}, Vec3d{4, 4, 4}}}) {
    const auto mesh = Grid(13, 0.0);
    const auto plan = MakePlan(mesh, Cube({6, 5, 4}, {2, 1, 3}, lower, upper));
    ASSERT_OK(plan);
    const DeformPlan& p = **plan;

    EXPECT_NEAR(PlanArea(p), MeshArea(*mesh), 1e-12);
    // No edge has more than two patches; boundary edges add up to the square's boundary.
    const auto use = EdgeUse(p);
    EXPECT_EQ(use.rbegin()->first, 2);
    double boundary = 0;
    std::vector<int> count(p.edges.size());
    for (const Patch& patch : p.patches) {
      for (const uint32_t e : patch.edge) ++count[e];
    }
    for (size_t e = 0; e < p.edges.size(); ++e) {
      if (count[e] != 1) continue;
      boundary +=
          Norm(p.vertices[p.edges[e].vertex[1]].world - p.vertices[p.edges[e].vertex[0]].world);
    }
    EXPECT_NEAR(boundary, 4.0, 1e-12);
    for (size_t i = 0; i < p.patches.size(); ++i) {
      for (size_t c = 0; c < 3; ++c) {
        Vec3d from_source;
        for (size_t k = 0; k < 3; ++k) {
          const uint32_t vertex = mesh->corner_vertices[p.sources[i].corners[k]];
          from_source += p.sources[i].barycentrics[c][k] * mesh->positions[vertex];
        }
        EXPECT_LT(Norm(from_source - p.vertices[p.patches[i].vertex[c]].world), 1e-14);
      }
    }
  }
}

TEST(DeformPlan, PatchesLieInTheirBoxAndOwnersAreLower) {
  const auto plan =
      MakePlan(Grid(17, 0.2), Cube({6, 5, 4}, {2, 2, 2}, {0.1, -0.1, -0.1}, {0.9, 1.1, 0.15}));
  ASSERT_OK(plan);
  const DeformPlan& p = **plan;
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
  const auto plan = MakePlan(Grid(9, 0.1), Cube({4, 4, 4}, {2, 2, 2}, {0.25, -1, -1}, {2, 2, 1}));
  ASSERT_OK(plan);
  std::vector<Vec3d> points = (*plan)->identity_points;
  ASSERT_FALSE((*plan)->seams.empty());
  auto attached = AttachedSeams(**plan, points);
  EXPECT_EQ(std::count(attached.begin(), attached.end(), true),
            static_cast<int>((*plan)->seams.size()));

  points[static_cast<size_t>((*plan)->structure.Index(1, 1, 1))].z += 1;  // not on the u = 0 face
  attached = AttachedSeams(**plan, points);
  EXPECT_EQ(std::count(attached.begin(), attached.end(), false), 0);

  points[static_cast<size_t>((*plan)->structure.Index(0, 1, 1))].z += 1e-15;
  points[static_cast<size_t>((*plan)->structure.Index(0, 2, 2))].z += 1;
  attached = AttachedSeams(**plan, points);
  EXPECT_GT(std::count(attached.begin(), attached.end(), false), 0);
}

TEST(DeformPlan, RefusesAMeshWithoutArea) {
  auto mesh = std::make_shared<PolygonMesh>();
  mesh->positions = {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}};
  mesh->corner_vertices = {0, 1, 2};
  mesh->face_offsets = {0, 3};
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
  ASSERT_OK(MakePlan(mesh, structure, go_on));
  const size_t most = asked;
  // Vertices and faces while it splits, then faces, patches and edges, some of them twice.
  ASSERT_GE(most * StopPoll::kStepsPerCheck, 10 * mesh->face_count());

  for (size_t nth = 1; nth <= most; ++nth) {
    asked = 0;
    const auto stop = [&asked, nth] {
      return ++asked < nth ? absl::OkStatus() : absl::DeadlineExceededError("late");
    };
    EXPECT_THAT(MakePlan(mesh, structure, stop), StatusIs(absl::StatusCode::kDeadlineExceeded));
    EXPECT_EQ(asked, nth) << "asked on after it was told to stop";
  }
}

}  // namespace
}  // namespace latticed
