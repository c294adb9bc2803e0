// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the packed table of shared points with core/ffd/plan/shared_points.h. Needs no device.
#include "cuda/plan/pack_shared_points.h"

#include <gtest/gtest.h>

#include <array>
#include <set>
#include <tuple>
#include <vector>

#include "core/ffd/plan/shared_points.h"
#include "tests/backend/conformance.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

using kernels::PackedUse;

// from patch, from slot, to patch, to slot, reversed
using Copy = std::tuple<uint32_t, uint32_t, uint32_t, uint32_t, bool>;

Copy Unpack(PackedUse from, uint32_t to_patch, uint32_t to_slot) {
  return {from >> 4, from >> 1 & 7, to_patch, to_slot, (from & 1) != 0};
}

std::set<Copy> Expected(const DeformPlan& plan) {
  std::set<Copy> copies;
  const SharedPoints shared(plan);
  for (const SharedCopy& c : shared.always()) {
    copies.emplace(c.from_patch, c.from_slot, c.to_patch, c.to_slot, c.reversed);
  }
  EXPECT_EQ(copies.size(), shared.always().size());
  return copies;
}

// Reads the copies as the kernel does.
std::set<Copy> Unpacked(const DeformPlan& plan, const PackedSharedPoints& packed) {
  std::set<Copy> copies;
  for (uint32_t p = 0; p < plan.patches.size(); ++p) {
    for (uint32_t c = 0; c < 3; ++c) {
      const PackedUse from = packed.vertex_owners[plan.patches[p].vertex[c]];
      if (from == kernels::kNoUse || from == kernels::PackUse(p, c, false)) continue;
      copies.insert(Unpack(from, p, c));
    }
  }
  for (uint32_t r = 0; r + 1 < packed.edge_begins.size(); ++r) {
    for (uint32_t i = packed.edge_begins[r]; i < packed.edge_begins[r + 1]; ++i) {
      const uint32_t use = packed.edge_uses[i];
      copies.insert(Unpack(packed.edge_owners[i], r * 32 + use % 32, 3 + use / 32));
    }
  }
  return copies;
}

TEST(PackSharedPoints, HoldsTheCopiesOfThePlan) {
  for (const double scale : {0.7, 1.0, 1.1}) {
    for (PolygonMesh& mesh : std::vector<PolygonMesh>{TorusMesh(16, 9), CubeMesh(4)}) {
      const LatticeStructure structure =
          MakeStructure(mesh.ComputeBounds(), {.extra = {2, 3, 1}, .scale = scale});
      const Plan plan = MakeTestPlan(mesh, structure);
      ASSERT_NE(plan, nullptr);
      const PackedSharedPoints packed = PackSharedPoints(*plan);
      const std::set<Copy> expected = Expected(*plan);
      EXPECT_GT(expected.size(), 3 * plan->patches.size());
      EXPECT_EQ(Unpacked(*plan, packed), expected) << "scale " << scale;
      const SharedPoints shared(*plan);
      EXPECT_EQ(packed.on_seams.size(),
                shared.when_attached().size() + shared.when_detached().size());
      EXPECT_EQ(packed.orphans.size(), shared.orphans().size());
    }
  }
}

}  // namespace
}  // namespace latticed::testing
