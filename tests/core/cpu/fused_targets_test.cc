// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The fused kernel under each instruction set that this machine has, not only the one that dispatch
// would choose: all against the definition, and watertight by itself.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/cpu/cpu_backend.h"
#include "core/cpu/fused/cpu_fused.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"
#include "tests/support/instruction_sets.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kSeed = 20'261'121;

using Point = std::array<float, 6>;

// Of all patches, in order; empty after a failure.
std::vector<Point> Evaluate(const Plan& plan, std::span<const Vec3d> control_points,
                            const ViewSpec& spec) {
  const auto backend = MakeCpuBackend({.threads = 1});
  const auto view = MakeView(*backend, Pipeline::kFused, plan, spec);
  if (view == nullptr) return {};
  EXPECT_OK(view->Evaluate(control_points, BoxFor(*plan, control_points), AllChunks(*plan)));
  std::vector<Point> points;
  for (const std::vector<uint8_t>& chunk : ReadAll(*plan, *view)) {
    const size_t before = points.size();
    points.resize(before + chunk.size() / sizeof(Point));
    std::memcpy(&points[before], chunk.data(), chunk.size());
  }
  return points;
}

void ExpectDefinition(const Plan& plan, std::span<const Vec3d> control_points, const ViewSpec& spec,
                      const std::vector<Point>& points) {
  Bounds reach;
  for (const Vec3d& p : control_points) reach.Extend(p);
  const DirectFfd definition(*plan, control_points);
  const auto& pattern = TessellationPattern::Get(spec.segments).points;
  const auto kind =
      spec.normals == NormalMode::kSmooth ? DirectFfd::Normal::kSmooth : DirectFfd::Normal::kFacet;
  const double step = 1.0 / spec.segments;
  ASSERT_EQ(points.size(), plan->patches.size() * pattern.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const auto& [i0, i1, i2] = pattern[i % pattern.size()];
    const auto expected =
        definition.Evaluate(i / pattern.size(), {i0 * step, i1 * step, i2 * step}, kind);
    const Vec3d position{points[i][0], points[i][1], points[i][2]};
    const Vec3d normal{points[i][3], points[i][4], points[i][5]};
    ASSERT_LE(Norm(position + plan->local_origin - expected.position),
              kFusedPosition * reach.diagonal());
    ASSERT_NEAR(Norm(normal), 1.0, kUnitTolerance);
    if (expected.kappa > kMostKappa) continue;
    ASSERT_LE(Norm(normal - expected.normal), kFusedNormal * expected.kappa);
  }
}

// No seam of the plan is detached.
void ExpectNoCracks(const DeformPlan& plan, int segments, const std::vector<Point>& points) {
  const auto& pattern = TessellationPattern::Get(segments);
  std::map<std::pair<uint32_t, int>, Vec3f> corners, inner;  // by vertex, or edge, and its point
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    const Patch& patch = plan.patches[p];
    for (size_t e = 0; e < 3; ++e) {
      for (int k = 0; k < segments; ++k) {
        const Point& at =
            points[p * pattern.points.size() + pattern.edge_points[e][static_cast<size_t>(k)]];
        const Vec3f position{at[0], at[1], at[2]};
        const int along = patch.edge_reversed[e] ? segments - k : k;
        const auto [first, added] = k == 0 ? corners.try_emplace({patch.vertex[e], 0}, position)
                                           : inner.try_emplace({patch.edge[e], along}, position);
        ASSERT_TRUE(added || first->second == position) << "patch " << p << ", edge " << e;
      }
    }
  }
}

void Check(const Plan& plan, std::span<const Vec3d> control_points, NormalMode normals) {
  for (const int segments : {1, 2, 5, 6, 9}) {
    SCOPED_TRACE(fmt::format("{} segments", segments));
    const ViewSpec spec{.segments = segments, .normals = normals, .format = VertexFormat::kFloat32};
    const std::vector<Point> points = Evaluate(plan, control_points, spec);
    ExpectDefinition(plan, control_points, spec, points);
    if (::testing::Test::HasFailure()) return;
    ExpectNoCracks(*plan, segments, points);
  }
}

TEST(FusedTargets, EveryInstructionSetMatchesDefinition) {
  std::set<std::string> names;
  for (const int64_t target : Targets()) {
    const ChosenTarget chosen(target);
    names.insert(FusedTargetName());
    for (const std::array<int, 3> degree : {std::array{1, 1, 1}, {2, 2, 2}, {1, 3, 2}}) {
      for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
        SCOPED_TRACE(fmt::format("{}, degree {} {} {}, seed {}", FusedTargetName(), degree[0],
                                 degree[1], degree[2], kSeed));
        const PolygonMesh mesh = TorusMesh(11, 7);
        // Some pieces outside, so that seams take part.
        const LatticeStructure structure =
            MakeStructure(mesh.ComputeBounds(), {.degree = degree, .scale = 0.9});
        const Plan plan = MakeTestPlan(mesh, structure);
        ASSERT_NE(plan, nullptr);
        Check(plan, plan->identity_points, normals);
        const LatticeStructure around = MakeStructure(mesh.ComputeBounds(), {.degree = degree});
        const Plan inside = MakeTestPlan(mesh, around);
        ASSERT_NE(inside, nullptr);
        Check(inside, Jitter(around, 0.2, kSeed), normals);
      }
    }
  }
  EXPECT_EQ(names.size(), Targets().size()) << "each target must have been dispatched to";
}

}  // namespace
}  // namespace latticed::testing
