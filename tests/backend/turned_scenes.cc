// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/backend/turned_scenes.h"

#include <utility>

namespace latticed::testing {
namespace {

constexpr double kTurnedNoise = 0.08;

void RestAtFaces(const LatticeStructure& s, std::span<const Vec3d> at_rest,
                 std::vector<Vec3d>& points) {
  for (int k = 0; k < s.size[2]; ++k) {
    for (int j = 0; j < s.size[1]; ++j) {
      for (int i = 0; i < s.size[0]; ++i) {
        const std::array<int, 3> place{i, j, k};
        bool inner = true;
        for (size_t a = 0; a < 3; ++a) {
          inner = inner && place[a] >= s.degree[a] && place[a] < s.size[a] - s.degree[a];
        }
        const auto index = static_cast<size_t>(s.Index(i, j, k));
        if (!inner) points[index] = at_rest[index];
      }
    }
  }
}

}  // namespace

MovedPlan MakeMovedPlan(PolygonMesh mesh, std::span<const MovedLattice> lattices,
                        VertexWeights weights) {
  MovedPlan result;
  std::vector<LatticeStructure> structures;
  for (const auto& [options, rests] : lattices) {
    structures.push_back(MakeStructure(mesh.ComputeBounds(), options));
    const auto seed = kTurnedSeed + static_cast<uint32_t>(structures.size());
    std::vector<Vec3d> points = Jitter(structures.back(), kTurnedNoise, seed);
    if (rests) RestAtFaces(structures.back(), IdentityControlPoints(structures.back()), points);
    result.points.insert(result.points.end(), points.begin(), points.end());
  }
  auto plan = MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), structures[0], {},
                       NeverStop, std::move(weights), std::span(structures).subspan(1));
  EXPECT_OK(plan);
  if (plan.ok()) result.plan = *plan;
  return result;
}

}  // namespace latticed::testing
