// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The fused kernel under each instruction set of this machine, not only the dispatched one. Each
// must match the definition and be watertight.
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/cpu/cpu_backend.h"
#include "core/cpu/fused/cpu_fused.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"
#include "tests/support/instruction_sets.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kSeed = 20'261'121;

void Check(const Plan& plan, std::span<const Vec3d> control_points, NormalMode normals) {
  ASSERT_NE(plan, nullptr);
  const auto backend = MakeCpuBackend({.threads = 1});
  std::vector<uint32_t> patches(plan->patches.size());
  std::iota(patches.begin(), patches.end(), 0u);
  for (const int segments : {1, 2, 5, 6, 9}) {
    SCOPED_TRACE(fmt::format("{} segments", segments));
    const ViewSpec spec{.segments = segments, .normals = normals, .format = VertexFormat::kFloat32};
    const auto points = EvaluateAll(*backend, Pipeline::kFused, plan, control_points, spec);
    ASSERT_OK(Definition(*plan, control_points, segments, normals, patches)
                  .Check(Pipeline::kFused, points));
    EXPECT_EQ(CountCracks(*plan, control_points, segments, points), 0u);
  }
}

// Weights of 0, 1/4 … 1 in turn.
Plan WeightedPlanOf(const PolygonMesh& mesh, const LatticeStructure& structure) {
  std::vector<float> weights;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    weights.push_back(0.25f * static_cast<float>(v % 5));
  }
  auto plan = MakePlan(std::make_shared<const PolygonMesh>(mesh), structure, {}, NeverStop,
                       std::make_shared<const std::vector<float>>(std::move(weights)));
  EXPECT_OK(plan);
  return plan.ok() ? *plan : nullptr;
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
        // Some pieces lie outside, so that seams take part.
        const LatticeStructure inside =
            MakeStructure(mesh.ComputeBounds(), {.degree = degree, .scale = 0.9});
        const Plan plan = MakeTestPlan(mesh, inside);
        Check(plan, plan->identity_points, normals);
        const LatticeStructure around = MakeStructure(mesh.ComputeBounds(), {.degree = degree});
        Check(MakeTestPlan(mesh, around), Jitter(around, 0.2, kSeed), normals);
        Check(WeightedPlanOf(mesh, inside), Jitter(inside, 0.08, kSeed), normals);
        Check(WeightedPlanOf(mesh, around), Jitter(around, 0.08, kSeed), normals);
      }
    }
  }
  EXPECT_EQ(names.size(), Targets().size()) << "each target must have been dispatched to";
}

}  // namespace
}  // namespace latticed::testing
