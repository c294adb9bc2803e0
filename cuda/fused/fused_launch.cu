// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/fused/fused_launch.h"

#include <algorithm>

namespace latticed::kernels {

FusedBlocks DivideChunks(size_t chunk_count, int segments, LaneFormat format, int at_once) {
  const size_t row_pairs = static_cast<size_t>(segments) / 2 + 1;
  const size_t useful = (row_pairs + kFusedWarps - 1) / kFusedWarps;
  const auto room = static_cast<size_t>(at_once);
  const size_t left = format == LaneFormat::kFloat32 ? chunk_count % room : 0;
  const size_t divided = chunk_count <= room ? chunk_count : left;
  const size_t parts = divided == 0 ? 1 : std::clamp<size_t>(room / divided, 1, useful);
  return {static_cast<uint32_t>(chunk_count - divided), static_cast<uint32_t>(parts),
          static_cast<uint32_t>(at_once)};
}

KernelCall FusedCall(const FusedLaunch& launch) {
  const auto& degree = launch.tables.degree;
  const int sum = degree[0] + degree[1] + degree[2];
  if (launch.segments <= MostDirectSegments(sum, launch.normals)) return DirectCall(launch);
  const bool floats = launch.output.format == LaneFormat::kFloat32;
  if (launch.normals == Normals::kSmooth) {
    return floats ? FusedCallByDegree<true, true>(launch) : FusedCallByDegree<true, false>(launch);
  }
  return floats ? FusedCallByDegree<false, true>(launch) : FusedCallByDegree<false, false>(launch);
}

}  // namespace latticed::kernels
