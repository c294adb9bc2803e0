// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The comparator's steps on the host, in the order of its kernels, against the definition.
#include "tests/bench/paper/tensor/tensor_product.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "tests/bench/exact_mesh.h"
#include "tests/bench/paper/tensor/tensor_surfaces.h"
#include "tests/bench/paper/tensor/tensor_verify.h"

namespace latticed::bench {
namespace {

using Plan = std::shared_ptr<const DeformPlan>;

constexpr size_t kPatches = 1'003;
constexpr uint32_t kLargeTriangles = 103;

// A tube of small triangles: most polygons are whole triangles, as in the paper's models.
Plan Tube() {
  const auto plan = MakeExactPlan(kPatches, {2, 2, 2});
  EXPECT_TRUE(plan.ok()) << plan.status();
  return plan.ok() ? *plan : nullptr;
}

// Triangles across many knot boxes, whose planes leave polygons of up to nine corners.
Plan LargeTriangles(std::array<int, 3> degree = {2, 2, 2}, double reach = 1.05) {
  std::mt19937 random(20130103);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  auto mesh = std::make_shared<PolygonMesh>();
  for (uint32_t corner = 0; corner < 3 * kLargeTriangles; ++corner) {
    mesh->positions.push_back({coordinate(random), coordinate(random), coordinate(random)});
    mesh->corner_vertices.push_back(corner);
    if (corner % 3 == 2) mesh->face_offsets.push_back(corner + 1);
  }
  Bounds bounds;
  bounds.Extend(Vec3d{-reach, -reach, -reach});
  bounds.Extend(Vec3d{reach, reach, reach});
  const auto lattice = FitLattice(bounds, {6, 6, 6}, degree, /*padding=*/0);
  EXPECT_TRUE(lattice.ok()) << lattice.status();
  if (!lattice.ok()) return nullptr;
  const auto plan = MakePlan(mesh, lattice->structure);
  EXPECT_TRUE(plan.ok()) << plan.status();
  return plan.ok() ? *plan : nullptr;
}

std::vector<Vec3d> Jittered(const DeformPlan& plan) {
  std::vector<Vec3d> points = IdentityControlPoints(plan.structure);
  std::mt19937 random(20130101);
  std::uniform_real_distribution<double> jitter(-0.05, 0.05);
  for (Vec3d& p : points) p += Vec3d{jitter(random), jitter(random), jitter(random)};
  return points;
}

void RunControl(const TensorJob& job) {
  const auto group = std::make_unique<TensorControlGroup>();
  for (size_t first = 0; first < job.count; first += kTensorGroup) {
    for (int i = 0; i < kTensorControlSteps; ++i) ControlSample(job, first, i, *group);
    for (int i = 0; i < kTensorControlSteps; ++i) ControlRelative(job, first, i, *group);
    for (int i = 0; i < kTensorControlSteps; ++i) ControlHalf(job, first, i, *group);
    for (int i = 0; i < kTensorControlSteps; ++i) ControlWhole(job, first, i, *group);
  }
}

void RunTessellation(const TensorJob& job, size_t most_lines) {
  std::vector<TensorCurve> curves(most_lines);
  float control[kTensorGroup][3][kTensorNet];
  const TensorTessellationGroup group{control, curves.data()};
  for (size_t first = 0; first < job.count; first += kTensorGroup) {
    ASSERT_LE(static_cast<size_t>(GroupLines(job, first)), most_lines);
    for (int i = 0; i < kTensorLoadSteps; ++i) LoadControl(job, first, i, group);
    for (int i = 0; i < 3 * GroupLines(job, first); ++i) CollapseLine(job, first, i, group);
    for (int i = 0; i < GroupPoints(job, first); ++i) TessellationPoint(job, first, i, group);
  }
}

std::vector<TensorVertex> VerticesOnHost(const DeformPlan& plan, const TensorSurfaces& surfaces,
                                         std::vector<Vec3d> control_points) {
  for (Vec3d& p : control_points) p -= plan.local_origin;
  const TensorInverse inverse = MakeTensorInverse();
  std::vector<Vec3d> centres(surfaces.count());
  std::vector<float> control(surfaces.count() * 3 * kTensorNet);
  constexpr float kUnwritten = std::numeric_limits<float>::quiet_NaN();
  std::vector<TensorVertex> vertices(surfaces.points.size(), {{kUnwritten}, {kUnwritten}});
  TensorJob job{.surfaces = surfaces.surfaces.data(),
                .count = surfaces.count(),
                .lines = surfaces.lines.data(),
                .points = surfaces.points.data(),
                .inverse = &inverse,
                .volume = {.control_points = control_points.data()},
                .centres = centres.data(),
                .control = control.data(),
                .vertices = vertices.data()};
  for (size_t a = 0; a < 3; ++a) {
    job.volume.degree[a] = plan.structure.degree[a];
    job.volume.size[a] = plan.structure.size[a];
    job.volume.knots[a] = plan.structure.knots[a].data();
  }
  RunControl(job);
  RunTessellation(job, surfaces.most_lines);
  return vertices;
}

double Area(const DeformPlan& plan, const SubPolygon& polygon) {
  double area = 0;
  for (const uint32_t patch : polygon.patches) {
    std::array<Vec3d, 3> corner;
    for (size_t c = 0; c < 3; ++c) corner[c] = plan.vertices[plan.patches[patch].vertex[c]].world;
    area += Norm(Cross(corner[1] - corner[0], corner[2] - corner[0])) / 2;
  }
  return area;
}

double Area(const ParameterRectangle& rectangle) {
  return Norm(rectangle.along) * Norm(rectangle.across);
}

// Part of the rectangle that the trimmed grid covers.
double Covered(const ParameterRectangle& rectangle) {
  const TrimmedGrid grid = TrimGrid(rectangle.polygon, kTensorSegments);
  double twice = 0;
  for (const auto& [i, j, k] : grid.triangles) {
    const TrimmedPoint a = grid.points[i], b = grid.points[j], c = grid.points[k];
    twice += (b.s - a.s) * (c.t - a.t) - (c.s - a.s) * (b.t - a.t);
  }
  return twice / 2;
}

TEST(SubPolygonsTest, EveryPatchIsInOnePolygonAndTrimmedGridsCoverIt) {
  const Plan plan = LargeTriangles();
  ASSERT_NE(plan, nullptr);
  const auto polygons = FindSubPolygons(*plan);
  ASSERT_TRUE(polygons.ok()) << polygons.status();

  const DirectFfd rest(*plan, plan->identity_points);
  std::vector<int> polygons_of(plan->patches.size(), 0);
  std::array<int, 10> of_corners{};
  for (const SubPolygon& polygon : *polygons) {
    for (const uint32_t patch : polygon.patches) ++polygons_of[patch];
    ++of_corners.at(polygon.corners.size());
    const ParameterRectangle rectangle =
        RectangleOf(*plan, polygon, rest.RestFacetNormal(polygon.patches.front()));
    const double area = Area(*plan, polygon), whole = Area(rectangle);
    EXPECT_NEAR(Covered(rectangle) * whole, area, 1e-11 * whole);
    EXPECT_LE(whole, (2 + 1e-9) * area);  // as the smallest rectangle of any convex polygon
  }
  EXPECT_EQ(std::count(polygons_of.begin(), polygons_of.end(), 1),
            static_cast<ptrdiff_t>(plan->patches.size()));
  for (size_t corners = 3; corners <= 7; ++corners) {
    EXPECT_GT(of_corners.at(corners), 0) << corners << " corners";
  }
}

TEST(SubPolygonsTest, ThereAreNoneOutsideTheFrame) {
  const Plan plan = LargeTriangles({2, 2, 2}, 0.9);
  ASSERT_NE(plan, nullptr);

  EXPECT_EQ(FindSubPolygons(*plan).status().code(), absl::StatusCode::kUnimplemented);
}

TEST(TensorProductTest, OtherDegreesAreNotOfThePapersTables) {
  const Plan plan = LargeTriangles({1, 2, 2});
  ASSERT_NE(plan, nullptr);

  EXPECT_EQ(MakeTensorSurfaces(*plan).status().code(), absl::StatusCode::kUnimplemented);
}

TEST(TensorProductTest, TrimmedSurfacesMatchTheDefinition) {
  for (const Plan& plan : {Tube(), LargeTriangles()}) {
    ASSERT_NE(plan, nullptr);
    const auto surfaces = MakeTensorSurfaces(*plan);
    ASSERT_TRUE(surfaces.ok()) << surfaces.status();
    ASSERT_NE(surfaces->count() % kTensorGroup, 0u) << "the last group is to be a part of one";
    const std::vector<Vec3d> points = Jittered(*plan);

    const std::vector<TensorVertex> vertices = VerticesOnHost(*plan, *surfaces, points);

    const auto precision = CompareTensor(*plan, points, *surfaces, vertices, 1);
    ASSERT_TRUE(precision.ok()) << precision.status();
    EXPECT_TRUE(CheckTensor(*precision).ok()) << CheckTensor(*precision);
  }
}

// What the comparison must notice on a device that nobody looks at.
TEST(TensorProductTest, WrongVerticesAreNoticed) {
  const Plan plan = Tube();
  ASSERT_NE(plan, nullptr);
  const auto surfaces = MakeTensorSurfaces(*plan);
  ASSERT_TRUE(surfaces.ok()) << surfaces.status();
  const std::vector<Vec3d> points = Jittered(*plan);
  const std::vector<TensorVertex> vertices = VerticesOnHost(*plan, *surfaces, points);
  const auto status = [&](const std::vector<TensorVertex>& wrong) {
    const auto precision = CompareTensor(*plan, points, *surfaces, wrong, 1);
    return precision.ok() ? CheckTensor(*precision) : precision.status();
  };
  ASSERT_TRUE(status(vertices).ok()) << status(vertices);

  auto moved = vertices;
  moved.back().position.x += static_cast<float>(2e-6 * plan->mesh_bounds.diagonal());
  auto turned = vertices;
  for (TensorVertex& v : turned) v.normal = {-v.normal.x, -v.normal.y, -v.normal.z};
  auto unwritten = vertices;
  unwritten.back().normal.z = std::numeric_limits<float>::quiet_NaN();
  auto fewer = vertices;
  fewer.pop_back();

  for (const auto& wrong : {moved, turned, unwritten, fewer}) {
    EXPECT_EQ(status(wrong).code(), absl::StatusCode::kInternal);
  }
}

}  // namespace
}  // namespace latticed::bench
