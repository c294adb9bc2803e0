// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/spanned/shared_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/ffd/plan/plan_slice.h"
#include "tests/backend/conformance.h"

namespace latticed::testing {
namespace {

Plan TorusPlan() {
  PolygonMesh mesh = TorusMesh(16, 9);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {.scale = 0.8});
  return MakeTestPlan(std::move(mesh), structure);
}

TEST(SharedEdges, AreThoseOfPatchesInMoreThanOneSlice) {
  const Plan plan = TorusPlan();
  ASSERT_NE(plan, nullptr);
  const auto chunks = static_cast<uint32_t>(plan->chunk_count());
  ASSERT_GT(chunks, 9u);
  for (const std::vector<uint32_t>& cuts :
       {std::vector<uint32_t>{0}, {0, 5}, {0, 1, 2, chunks - 1}}) {
    SCOPED_TRACE(cuts.size());
    std::map<uint32_t, std::set<size_t>> users;  // by edge of the plan
    for (size_t p = 0; p < plan->patches.size(); ++p) {
      const auto chunk = static_cast<uint32_t>(p / limits::kPatchesPerChunk);
      const auto slice = std::ranges::upper_bound(cuts, chunk) - cuts.begin() - 1;
      for (const uint32_t edge : plan->patches[p].edge) {
        users[edge].insert(static_cast<size_t>(slice));
      }
    }
    std::vector<uint32_t> expected;
    for (const auto& [edge, slices] : users) {
      if (slices.size() > 1) expected.push_back(edge);
    }
    EXPECT_EQ(expected.empty(), cuts.size() == 1);

    const SharedEdges shared = SharedEdges::Find(*plan, cuts);

    ASSERT_EQ(shared.edges, expected);
    ASSERT_EQ(shared.slices.size(), cuts.size());
    for (size_t s = 0; s < cuts.size(); ++s) {
      const auto slice = SlicePlan(*plan, cuts[s], s + 1 < cuts.size() ? cuts[s + 1] : chunks);
      const auto& [edges, numbers] = shared.slices[s];
      std::set<uint32_t> of_slice;
      for (uint32_t i = 0; i < expected.size(); ++i) {
        if (users[expected[i]].contains(s)) of_slice.insert(i);
      }
      ASSERT_EQ(std::set(numbers.begin(), numbers.end()), of_slice) << "slice " << s;
      ASSERT_EQ(numbers.size(), of_slice.size());
      ASSERT_EQ(edges.size(), numbers.size());
      ASSERT_TRUE(std::ranges::is_sorted(edges));
      for (size_t i = 0; i < edges.size(); ++i) {
        for (size_t end = 0; end < 2; ++end) {
          const uint32_t got = slice->edges.at(edges[i]).vertex[end];
          const uint32_t want = plan->edges[expected[numbers[i]]].vertex[end];
          ASSERT_EQ(slice->vertices[got].world, plan->vertices[want].world);
        }
      }
    }
  }
}

}  // namespace
}  // namespace latticed::testing
