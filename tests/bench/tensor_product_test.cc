// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The comparator's steps on the host, in the order of its kernels, against the definition.
#include "tests/bench/tensor_product.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <random>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "core/view/view_layout.h"
#include "tests/bench/exact_mesh.h"
#include "tests/bench/tensor_tables.h"

namespace latticed::bench {
namespace {

constexpr size_t kPatches = 1'001;  // no multiple of a group
constexpr int kSegments = 10;

void RunControl(const TensorJob& job) {
  const auto group = std::make_unique<TensorControlGroup>();
  for (size_t first = 0; first < job.count; first += kTensorGroup) {
    for (int i = 0; i < kTensorControlSteps; ++i) ControlSample(job, first, i, *group);
    for (int i = 0; i < kTensorControlSteps; ++i) ControlRelative(job, first, i, *group);
    for (int i = 0; i < kTensorControlSteps; ++i) ControlHalf(job, first, i, *group);
    for (int i = 0; i < kTensorControlSteps; ++i) ControlWhole(job, first, i, *group);
  }
}

void RunTessellation(const TensorJob& job) {
  const auto group = std::make_unique<TensorTessellationGroup>();
  for (size_t first = 0; first < job.count; first += kTensorGroup) {
    for (int i = 0; i < kTensorLoadSteps; ++i) LoadControl(job, first, i, *group);
    for (int i = 0; i < TensorRowSteps(job.segments); ++i) CollapseRow(job, i, *group);
    const int points = kTensorGroup * PointsPerPatch(job.segments);
    for (int i = 0; i < points; ++i) TessellationPoint(job, first, i, *group);
  }
}

TEST(TensorProductTest, TrimmedSurfacesMatchTheDefinition) {
  const auto made = MakeExactPlan(kPatches, {2, 2, 2});
  ASSERT_TRUE(made.ok()) << made.status();
  const DeformPlan& plan = **made;
  std::vector<Vec3d> points = IdentityControlPoints(plan.structure);
  std::mt19937 random(20130101);
  std::uniform_real_distribution<double> jitter(-0.05, 0.05);
  for (Vec3d& p : points) p += Vec3d{jitter(random), jitter(random), jitter(random)};
  std::vector<Vec3d> relative = points;
  for (Vec3d& p : relative) p -= plan.local_origin;
  const ViewSpec spec{.segments = kSegments, .format = VertexFormat::kFloat32};
  const TensorTables tables = MakeTensorTables(kSegments);
  const std::vector<TensorPatch> patches = MakeTensorPatches(plan);
  std::vector<Vec3d> centres(kPatches);
  std::vector<float> control(kPatches * 3 * kTensorNet);
  std::vector<float> vertices(kPatches * PointsPerPatch(kSegments) * 6);
  TensorJob job{.patches = patches.data(),
                .count = kPatches,
                .volume = {.control_points = relative.data()},
                .tables = &tables,
                .segments = kSegments,
                .centres = centres.data(),
                .control = control.data(),
                .layout = MakeVertexLayout(plan, spec),
                .writer = MakeVertexWriter(plan, spec, {}),
                .vertices = reinterpret_cast<uint8_t*>(vertices.data())};
  for (size_t a = 0; a < 3; ++a) {
    job.volume.degree[a] = plan.structure.degree[a];
    job.volume.size[a] = plan.structure.size[a];
    job.volume.knots[a] = plan.structure.knots[a].data();
  }

  RunControl(job);
  RunTessellation(job);

  const DirectFfd direct(plan, points);
  const auto& pattern = TessellationPattern::Get(kSegments).points;
  const double diagonal = plan.mesh_bounds.diagonal();
  double worst = 0, worst_normal = 0;
  for (size_t i = 0; i < kPatches * pattern.size(); ++i) {
    const auto& p = pattern[i % pattern.size()];
    const double s = kSegments;
    const auto expected = direct.Evaluate(i / pattern.size(), {p[0] / s, p[1] / s, p[2] / s},
                                          DirectFfd::Normal::kFacet);
    const float* v = vertices.data() + 6 * i;
    const Vec3d got = plan.local_origin + ToDouble(Vec3f{v[0], v[1], v[2]});
    worst = std::max(worst, Norm(got - expected.position));
    // Slivers have no float normal: those of a sound shape, at least, point the same way.
    if (expected.kappa > 10 ||
        Norm(Cross(patches[i / pattern.size()].along, patches[i / pattern.size()].across)) < 1e-4) {
      continue;
    }
    worst_normal =
        std::max(worst_normal, Norm(ToDouble(Vec3f{v[3], v[4], v[5]}) - expected.normal));
  }
  EXPECT_LE(worst, 1e-6 * diagonal);  // as the GEMM pipelines
  EXPECT_LE(worst_normal, 1e-2);
}

}  // namespace
}  // namespace latticed::bench
