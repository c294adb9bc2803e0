// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/fused/fused_launch.h"

#include <algorithm>

namespace latticed::kernels {

uint32_t BlocksPerChunk(size_t chunk_count, int segments, int multiprocessors) {
  const size_t row_pairs = static_cast<size_t>(segments) / 2 + 1;
  const size_t useful = (row_pairs + kFusedWarps - 1) / kFusedWarps;
  const size_t room = static_cast<size_t>(multiprocessors) * kFusedBlocks / chunk_count;
  return static_cast<uint32_t>(std::clamp<size_t>(room, 1, useful));
}

KernelCall FusedCall(const FusedLaunch& launch) {
  const bool floats = launch.output.format == LaneFormat::kFloat32;
  if (launch.normals == Normals::kSmooth) {
    return floats ? FusedCallByDegree<true, true>(launch) : FusedCallByDegree<true, false>(launch);
  }
  return floats ? FusedCallByDegree<false, true>(launch) : FusedCallByDegree<false, false>(launch);
}

}  // namespace latticed::kernels
