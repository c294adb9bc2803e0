// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The numbers of edges are those that a client finds from the corners of patches alone.
#include "core/patches/edge_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <utility>

#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

void ExpectOrderOfFirstUse(const PolygonMesh& mesh, const LatticeOptions& options) {
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), options);
  const auto plan = MakePlan(std::make_shared<const PolygonMesh>(mesh), structure);
  ASSERT_OK(plan.status());
  const std::vector<uint32_t> first = FirstEdges(**plan);
  ASSERT_EQ(first.size(), (*plan)->chunk_count() + 1);
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> numbers;
  for (size_t p = 0; p < (*plan)->patches.size(); ++p) {
    const Patch& patch = (*plan)->patches[p];
    for (size_t e = 0; e < 3; ++e) {
      const std::pair ends = std::minmax(patch.vertex[e], patch.vertex[(e + 1) % 3]);
      const auto next = static_cast<uint32_t>(numbers.size());
      const auto [it, is_new] = numbers.try_emplace(ends, next);
      ASSERT_EQ(patch.edge[e], it->second) << "patch " << p;
      if (!is_new) continue;
      ASSERT_GE(next, first[p / 32]);
      ASSERT_LT(next, first[p / 32 + 1]);
    }
  }
  EXPECT_EQ(numbers.size(), (*plan)->edges.size());
  EXPECT_EQ(first.back(), (*plan)->edges.size());
}

TEST(EdgeOrder, IsThatOfFirstUse) {
  ExpectOrderOfFirstUse(TorusMesh(16, 9), {});
  ExpectOrderOfFirstUse(TorusMesh(16, 9), {.scale = 0.7});     // patches outside, seams
  ExpectOrderOfFirstUse(TriangleSoup(50, 5), {.scale = 0.9});  // no neighbours but by splitting
  ExpectOrderOfFirstUse(FlatGrid(9, 0.5), {.knots = KnotKind::kRepeated});
  ExpectOrderOfFirstUse(OneTriangle(), {});
}

TEST(EdgeOrder, CountsTheEdgesOfASquare) {
  const PolygonMesh mesh = FlatGrid(1, 0);
  const LatticeStructure structure =
      MakeStructure({{-1, -1, -1}, {2, 2, 1}}, {.degree = {1, 1, 1}, .extra = {0, 0, 0}});
  const auto plan = MakePlan(std::make_shared<const PolygonMesh>(mesh), structure);
  ASSERT_OK(plan.status());
  EXPECT_EQ(FirstEdges(**plan), (std::vector<uint32_t>{0, 5}));
}

}  // namespace
}  // namespace latticed::testing
