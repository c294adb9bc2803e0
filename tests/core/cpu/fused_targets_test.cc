// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The fused kernel under each instruction set that this machine has, not only the one that dispatch
// would choose: all against the definition, and watertight by itself.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "core/cpu/cpu_backend.h"
#include "core/cpu/cpu_fused.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"
#include "tests/support/instruction_sets.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kSeed = 20'261'121;

void ExpectMatchesDefinition(const Plan& plan, std::span<const Vec3d> control_points,
                             NormalMode normals) {
  constexpr int kSegments = 5;
  const auto backend = MakeCpuBackend({.threads = 1});
  const auto target = backend->Prepare(plan, Pipeline::kFused);
  ASSERT_OK(target);
  const ViewSpec spec{.segments = kSegments, .normals = normals, .format = VertexFormat::kFloat32};
  const auto view = (*target)->CreateView(spec);
  ASSERT_OK(view);
  const std::vector<uint32_t> chunks = AllChunks(*plan);
  ASSERT_OK((*view)->Evaluate(control_points, BoxFor(*plan, control_points), chunks));

  Bounds reach;
  for (const Vec3d& p : control_points) reach.Extend(p);
  const DirectFfd definition(*plan, control_points);
  const auto& pattern = TessellationPattern::Get(kSegments);
  const auto kind =
      normals == NormalMode::kSmooth ? DirectFfd::Normal::kSmooth : DirectFfd::Normal::kFacet;
  std::vector<std::array<float, 6>> points;
  for (const uint32_t chunk : chunks) {
    points.resize(ChunkPoints(*plan, chunk, kSegments));
    ASSERT_OK((*view)->Read(
        chunk, {reinterpret_cast<uint8_t*>(points.data()), points.size() * sizeof(points[0])}));
    const auto [first, last] = plan->ChunkPatches(chunk);
    for (size_t i = 0; i < points.size(); ++i) {
      const auto& [i0, i1, i2] = pattern.points[i % pattern.points.size()];
      const auto expected = definition.Evaluate(
          first + i / pattern.points.size(),
          {i0 / double{kSegments}, i1 / double{kSegments}, i2 / double{kSegments}}, kind);
      const Vec3d position{points[i][0], points[i][1], points[i][2]};
      const Vec3d normal{points[i][3], points[i][4], points[i][5]};
      ASSERT_LE(Norm(position + plan->local_origin - expected.position),
                kFusedPosition * reach.diagonal());
      ASSERT_NEAR(Norm(normal), 1.0, kUnitTolerance);
      if (expected.kappa > kMostKappa) continue;
      ASSERT_LE(Norm(normal - expected.normal), kFusedNormal * expected.kappa);
    }
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
        ExpectMatchesDefinition(plan, plan->identity_points, normals);
        const LatticeStructure around = MakeStructure(mesh.ComputeBounds(), {.degree = degree});
        const Plan inside = MakeTestPlan(mesh, around);
        ASSERT_NE(inside, nullptr);
        ExpectMatchesDefinition(inside, Jitter(around, 0.2, kSeed), normals);
      }
    }
  }
  EXPECT_EQ(names.size(), Targets().size()) << "each target must have been dispatched to";
}

}  // namespace
}  // namespace latticed::testing
