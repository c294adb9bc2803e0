// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The dirty chunks of each control point, and of all together, compared with a search of all boxes.
// Covers knots of every kind, including empty spans, and pieces outside.
#include "core/ffd/plan/dirty_set.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "fmt/format.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

struct Expected {
  std::set<uint32_t> patches, chunks;
  uint64_t boxes = 0;
};

// By definition: the boxes that the control point's basis functions reach.
void AddEffectOf(const DeformPlan& plan, uint32_t index, Expected& effect,
                 std::set<uint32_t>& seen) {
  const LatticeStructure& s = plan.structure;
  for (uint32_t b = 0; b < plan.outside_box(); ++b) {
    const std::array<int, 3>& span = plan.boxes[b].span;
    bool reached = false;
    for (int k = span[2] - s.degree[2]; k <= span[2]; ++k) {
      for (int j = span[1] - s.degree[1]; j <= span[1]; ++j) {
        for (int i = span[0] - s.degree[0]; i <= span[0]; ++i) {
          reached |= static_cast<uint32_t>(s.Index(i, j, k)) == index;
        }
      }
    }
    if (!reached || !seen.insert(b).second) continue;
    ++effect.boxes;
    for (uint32_t p = plan.box_patches[b]; p < plan.box_patches[b + 1]; ++p)
      effect.patches.insert(p);
    effect.patches.insert(plan.box_borrowers[b].begin(), plan.box_borrowers[b].end());
  }
}

void ExpectEffect(const std::shared_ptr<const DeformPlan>& plan,
                  const std::vector<uint32_t>& indices) {
  Expected expected;
  std::set<uint32_t> seen;
  for (const uint32_t index : indices) AddEffectOf(*plan, index, expected, seen);
  for (const uint32_t patch : expected.patches) expected.chunks.insert(patch / 32);

  const DirtySet dirty = DirtyByControlPoints(*plan, indices);

  ASSERT_EQ(std::vector<uint32_t>(expected.chunks.begin(), expected.chunks.end()), dirty.chunks);
  ASSERT_EQ(dirty.patches, expected.patches.size());
  ASSERT_EQ(dirty.boxes, expected.boxes);
}

TEST(DirtySetOfEveryControlPoint, IsWhatASearchOfAllBoxesFinds) {
  const PolygonMesh mesh = TorusMesh(9, 7);
  for (const KnotKind knots :
       {KnotKind::kUniform, KnotKind::kNonUniform, KnotKind::kUnclamped, KnotKind::kRepeated}) {
    for (const std::array<int, 3> degree : {std::array{2, 2, 2}, std::array{3, 1, 2}}) {
      SCOPED_TRACE(fmt::format("knots {}, degree {}{}{}", static_cast<int>(knots), degree[0],
                               degree[1], degree[2]));
      const LatticeStructure structure =
          MakeStructure(mesh.ComputeBounds(),
                        {.degree = degree, .extra = {3, 2, 4}, .knots = knots, .scale = 0.9});
      ASSERT_OK_AND_ASSIGN(const auto plan,
                           MakePlan(std::make_shared<const PolygonMesh>(mesh), structure));
      std::vector<uint32_t> all(static_cast<size_t>(structure.control_point_count()));
      std::iota(all.begin(), all.end(), 0u);
      for (const uint32_t index : all) {
        ExpectEffect(plan, {index});
        if (HasFatalFailure()) return;
      }
      ExpectEffect(plan, {all.front(), all.back(), all.front()});
      ExpectEffect(plan, all);
      // Ranges across the ends of rows, and with gaps.
      const auto row = static_cast<uint32_t>(structure.size[0]);
      ExpectEffect(plan, {row - 2, row - 1, row, row + 1, row + 3, 3 * row, 3 * row - 1});
      for (uint32_t gap = 1; gap < row; ++gap) ExpectEffect(plan, {2 * row, 2 * row + gap});
    }
  }
}

}  // namespace
}  // namespace latticed::testing
