// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "core/base/limits.h"
#include "cuda/fused/fused_kernels.h"
#include "fmt/format.h"

namespace latticed::testing {
namespace {

using kernels::DivideChunks;
using kernels::FusedBlocks;
using kernels::FusedLaunch;
using kernels::LaneFormat;

constexpr int kBlocksAtOnce = 528;

FusedLaunch Launch(uint32_t chunks, int segments, LaneFormat format) {
  FusedLaunch launch{};
  launch.tables.degree[0] = launch.tables.degree[1] = launch.tables.degree[2] = 2;
  launch.chunk_count = chunks;
  launch.segments = segments;
  launch.normals = kernels::Normals::kFacet;
  launch.output.format = format;
  return launch;
}

TEST(DivideChunks, EveryPartOfEveryChunkIsOneBlock) {
  for (const uint32_t chunks : {1u, 3u, 128u, 535u, 700u, 2112u, 2113u, 3552u}) {
    for (int segments = 1; segments <= limits::kMaxSegments; ++segments) {
      for (const LaneFormat format : {LaneFormat::kFloat32, LaneFormat::kQuantised8}) {
        SCOPED_TRACE(fmt::format("{} chunks, {} segments, format {}", chunks, segments,
                                 static_cast<int>(format)));
        const FusedBlocks blocks = DivideChunks(Launch(chunks, segments, format), kBlocksAtOnce);

        std::set<std::pair<uint32_t, uint32_t>> seen;
        for (uint32_t block = 0; block < blocks.Count(chunks); ++block) {
          const FusedBlocks::Part part = blocks.PartOf(block);
          ASSERT_LT(part.index, chunks);
          ASSERT_LT(part.part, part.parts);
          ASSERT_EQ(part.parts, part.index < blocks.whole ? 1 : blocks.parts);
          ASSERT_TRUE(seen.emplace(part.index, part.part).second);
        }
        EXPECT_EQ(seen.size(), blocks.whole + (chunks - blocks.whole) * blocks.parts);
      }
    }
  }
}

}  // namespace
}  // namespace latticed::testing
