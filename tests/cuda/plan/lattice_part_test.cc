// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What is brought to the device for some chunks of a large lattice, against what its kernels read:
// the boxes by the patches as the device has them. Needs no device.
#include "cuda/plan/lattice_part.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>

#include "cuda/plan/pack_patches.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kSeed = 1827;

// Inside, partly outside, on knot planes; with repeated knots too.
std::vector<Plan> Plans() {
  std::vector<Plan> plans;
  for (const LatticeOptions& options :
       {LatticeOptions{.extra = {14, 14, 14}},
        LatticeOptions{.degree = {3, 1, 2}, .extra = {21, 9, 16}, .scale = 0.7},
        LatticeOptions{.extra = {29, 29, 29}},
        LatticeOptions{.degree = {3, 3, 3}, .extra = {16, 16, 16}, .knots = KnotKind::kRepeated}}) {
    const PolygonMesh mesh = TorusMesh(24, 12);
    plans.push_back(MakeTestPlan(mesh, MakeStructure(mesh.ComputeBounds(), options)));
  }
  const PolygonMesh cube = CubeMesh(6);
  plans.push_back(MakeTestPlan(
      cube, MakeStructure(cube.ComputeBounds(), {.extra = {15, 15, 15}, .scale = 1.0})));
  return plans;
}

// By the steps that the fused kernel takes down from a patch's box to an owner.
std::set<uint32_t> BoxesReadBy(const DeformPlan& plan, const PackedPatches& packed,
                               uint32_t chunk) {
  const std::array<uint32_t, 3> strides = BoxStrides(plan.structure);
  std::set<uint32_t> boxes{plan.outside_box()};
  const auto [first, last] = plan.ChunkPatches(chunk);
  for (size_t p = first; p < last; ++p) {
    const kernels::DevicePatch& patch = packed.patches[p];
    boxes.insert(patch.Box());
    for (int slot = 0; slot < 3; ++slot) {
      for (const uint32_t steps : {patch.CornerSteps(slot), patch.EdgeSteps(slot)}) {
        uint32_t owner = patch.Box();
        for (size_t axis = 0; axis < 3; ++axis) owner -= (steps >> axis & 1) * strides[axis];
        boxes.insert(owner);
      }
    }
  }
  return boxes;
}

std::set<uint32_t> SeamsReadBy(const DeformPlan& plan, const PackedPatches& packed,
                               uint32_t chunk) {
  const auto [first, last] = plan.ChunkPatches(chunk);
  std::set<uint32_t> seams;
  for (const kernels::SeamUse& use : packed.seam_uses) {
    if (use.key / 8 >= first && use.key / 8 < last) seams.insert(use.seam);
  }
  return seams;
}

std::set<size_t> PagesOf(const DeformPlan& plan, const std::set<uint32_t>& boxes) {
  const LatticeStructure& s = plan.structure;
  std::set<size_t> pages;
  for (const uint32_t b : boxes) {
    if (b == plan.outside_box()) continue;
    const std::array<int, 3>& span = plan.boxes[b].span;
    for (int k = span[2] - s.degree[2]; k <= span[2]; ++k) {
      for (int j = span[1] - s.degree[1]; j <= span[1]; ++j) {
        for (int i = span[0] - s.degree[0]; i <= span[0]; ++i) {
          pages.insert(static_cast<size_t>(s.Index(i, j, k)) / LatticePart::kPagePoints);
        }
      }
    }
  }
  return pages;
}

template <typename T>
std::set<size_t> SetOf(std::span<const T> numbers) {
  std::set<size_t> set(numbers.begin(), numbers.end());
  EXPECT_EQ(set.size(), numbers.size()) << "each once";
  return set;
}

TEST(LatticePart, HasAllThatTheKernelsReadForItsChunksAndNoMore) {
  size_t most_seams = 0;
  std::mt19937 random(kSeed);
  for (const Plan& plan : Plans()) {
    ASSERT_NE(plan, nullptr);
    ASSERT_TRUE(LatticePart::IsWorthwhile(plan->structure));
    const auto packed = PackPatches(*plan);
    ASSERT_OK(packed);
    const auto count = static_cast<uint32_t>(plan->chunk_count());
    std::vector<std::set<uint32_t>> read, seams_read;
    read.reserve(count);
    seams_read.reserve(count);
    for (uint32_t chunk = 0; chunk < count; ++chunk) {
      read.push_back(BoxesReadBy(*plan, *packed, chunk));
      seams_read.push_back(SeamsReadBy(*plan, *packed, chunk));
    }
    LatticePart part(plan, std::make_shared<const ChunkNeeds>(*plan));
    // One after the other by the same object, from a chunk to all of them.
    for (uint32_t wanted = 1; wanted <= count; wanted = 2 * wanted + random() % 2) {
      SCOPED_TRACE(fmt::format("{} chunks of {}, seed {}", wanted, count, kSeed));
      std::vector<uint32_t> chunks = AllChunks(*plan);
      std::ranges::shuffle(chunks, random);
      chunks.resize(wanted);
      std::ranges::sort(chunks);
      std::set<uint32_t> boxes, seams;
      for (const uint32_t chunk : chunks) {
        boxes.insert(read[chunk].begin(), read[chunk].end());
        seams.insert(seams_read[chunk].begin(), seams_read[chunk].end());
      }
      const std::set<size_t> pages = PagesOf(*plan, boxes);

      const bool selected = part.Select(chunks);

      ASSERT_EQ(selected, pages.size() <= LatticePart::kMostPages) << pages.size() << " pages";
      if (!selected) continue;
      EXPECT_EQ(SetOf(part.boxes()), std::set<size_t>(boxes.begin(), boxes.end()));
      EXPECT_EQ(SetOf(part.pages()), pages);
      EXPECT_EQ(SetOf(part.seams()), std::set<size_t>(seams.begin(), seams.end()));
      most_seams = std::max(most_seams, seams.size());
      EXPECT_LE(part.boxes().size(), LatticePart::MostBoxes(*plan));
    }
  }
  EXPECT_GT(most_seams, 10u);
}

TEST(LatticePart, OfFewChunksIsSmallWhereTheLatticeIsLarge) {
  const Plan plan = std::move(Plans()[2]);
  ASSERT_NE(plan, nullptr);
  ASSERT_EQ(plan->structure.control_point_count(), 32 * 32 * 32);
  LatticePart part(plan, std::make_shared<const ChunkNeeds>(*plan));

  ASSERT_TRUE(part.Select(std::array{uint32_t{0}}));
  EXPECT_LT(part.boxes().size(), plan->boxes.size() / 100);
  EXPECT_LT(part.pages().size(), 64u);

  EXPECT_FALSE(part.Select(AllChunks(*plan))) << "too much of it";
  EXPECT_TRUE(part.boxes().empty());
  EXPECT_TRUE(part.Select(std::array{uint32_t{1}})) << "and once more";
}

TEST(LatticePart, IsNotOfUseWhereTheLatticeIsSmall) {
  const PolygonMesh mesh = TorusMesh(6, 5);
  EXPECT_FALSE(LatticePart::IsWorthwhile(
      MakeStructure(mesh.ComputeBounds(), {.extra = {13, 13, 13}})));  // 16 control points an axis
  EXPECT_TRUE(
      LatticePart::IsWorthwhile(MakeStructure(mesh.ComputeBounds(), {.extra = {14, 13, 13}})));
}

}  // namespace
}  // namespace latticed::testing
