// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the comparator's steps, run on the host in the order of its kernels, with the definition.
#include "tests/bench/paper/tensor/tensor_product.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "tests/bench/exact_mesh.h"
#include "tests/bench/paper/tensor/tensor_surfaces.h"
#include "tests/bench/paper/tensor/tensor_verify.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::bench {
namespace {

using Plan = std::shared_ptr<const DeformPlan>;

constexpr size_t kPatches = 1'003;
constexpr uint32_t kLargeTriangles = 104;

// A tube of small triangles: most polygons are whole triangles, as in the paper's models.
Plan Tube() {
  const auto plan = MakeExactPlan(kPatches, {2, 2, 2});
  EXPECT_OK(plan);
  return plan.ok() ? *plan : nullptr;
}

// Triangles across many knot boxes, whose planes leave polygons of up to nine corners.
Plan LargeTriangles() {
  PolygonMesh mesh = testing::TriangleSoup(kLargeTriangles, 20130103);
  for (size_t i = 0; i < mesh.positions.size(); i += 3) {
    for (size_t c = 1; c < 3; ++c) {
      mesh.positions[i + c] = mesh.positions[i] + 5 * (mesh.positions[i + c] - mesh.positions[i]);
    }
  }
  const auto structure = testing::MakeStructure(mesh.ComputeBounds(), {.extra = {3, 3, 3}});
  const auto plan = MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), structure);
  EXPECT_OK(plan);
  return plan.ok() ? *plan : nullptr;
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

TEST(TensorProductTest, TrimmedSurfacesMatchTheDefinition) {
  for (const Plan& plan : {Tube(), LargeTriangles()}) {
    ASSERT_NE(plan, nullptr);
    ASSERT_OK_AND_ASSIGN(const auto surfaces, MakeTensorSurfaces(*plan));
    ASSERT_NE(surfaces.count() % kTensorGroup, 0u)
        << surfaces.count() << ": the last group is to be a part of one";
    const std::vector<Vec3d> points = testing::Jitter(plan->structure, 0.02, 20130101);

    const std::vector<TensorVertex> vertices = VerticesOnHost(*plan, surfaces, points);

    ASSERT_OK_AND_ASSIGN(const auto precision, CompareTensor(*plan, points, surfaces, vertices, 1));
    EXPECT_OK(precision.Check(kTensorNormalError));
  }
}

// The comparison must notice these errors on a device, where nobody looks at the vertices.
TEST(TensorProductTest, WrongVerticesAreNoticed) {
  const Plan plan = Tube();
  ASSERT_NE(plan, nullptr);
  ASSERT_OK_AND_ASSIGN(const auto surfaces, MakeTensorSurfaces(*plan));
  const std::vector<Vec3d> points = testing::Jitter(plan->structure, 0.02, 20130101);
  const std::vector<TensorVertex> vertices = VerticesOnHost(*plan, surfaces, points);
  const auto status = [&](const std::vector<TensorVertex>& wrong) {
    const auto precision = CompareTensor(*plan, points, surfaces, wrong, 1);
    return precision.ok() ? precision->Check(kTensorNormalError) : precision.status();
  };
  ASSERT_OK(status(vertices));

  auto moved = vertices;
  moved.back().position.x += static_cast<float>(2e-6 * plan->mesh_bounds.diagonal());
  auto turned = vertices;
  for (TensorVertex& v : turned) v.normal = {-v.normal.x, -v.normal.y, -v.normal.z};
  auto unwritten = vertices;
  unwritten.back().normal.z = std::numeric_limits<float>::quiet_NaN();
  auto fewer = vertices;
  fewer.pop_back();

  for (const auto& wrong : {moved, turned, unwritten, fewer}) {
    EXPECT_THAT(status(wrong), testing::StatusIs(absl::StatusCode::kInternal));
  }
}

}  // namespace
}  // namespace latticed::bench
