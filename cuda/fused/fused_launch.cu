// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/fused/fused_launch.h"

#include <algorithm>

#include "core/ffd/tessellation_pattern.h"

namespace latticed::kernels {
namespace {

// Whether direct_kernel.cuh evaluates. It must not depend on the chunks: points on their borders would
// otherwise differ in their last bits.
bool IsDirect(const FusedLaunch& launch) {
  const auto& degree = launch.tables.degree;
  const int sum = degree[0] + degree[1] + degree[2];
  return launch.segments <= MostDirectSegments(sum, launch.normals);
}

// The most parts of a chunk that all have work.
int MostParts(const FusedLaunch& launch) {
  const auto divided_up = [](int work, int share) { return (work + share - 1) / share; };
  return IsDirect(launch) ? divided_up(PointsPerPatch(launch.segments), 3)
                          : divided_up(launch.segments / 2 + 1, kFusedWarps);  // pairs of rows
}

template <bool kWeighted>
KernelCall ComposingCall(const FusedLaunch& launch) {
  const bool floats = launch.output.format == LaneFormat::kFloat32;
  if (launch.normals == Normals::kSmooth) {
    return floats ? FusedCallByDegree<true, true, kWeighted>(launch)
                  : FusedCallByDegree<true, false, kWeighted>(launch);
  }
  return floats ? FusedCallByDegree<false, true, kWeighted>(launch)
                : FusedCallByDegree<false, false, kWeighted>(launch);
}

}  // namespace

FusedBlocks DivideChunks(const FusedLaunch& launch, int blocks_at_once) {
  const bool direct = IsDirect(launch), floats = launch.output.format == LaneFormat::kFloat32;
  const uint32_t chunks = launch.chunk_count;
  const auto room = static_cast<uint32_t>(blocks_at_once * (direct ? kDirectWarps : 1));
  const uint32_t left = floats && !direct ? chunks % room : 0;
  const uint32_t divided = chunks <= room ? chunks : left;
  const auto most = static_cast<uint32_t>(MostParts(launch));
  const uint32_t parts = divided == 0 ? 1 : std::clamp(room / divided, 1u, most);
  return {chunks - divided, parts, room};
}

KernelCall FusedCall(const FusedLaunch& launch) {
  if (IsDirect(launch)) return DirectCall(launch);
  return launch.plan.weights.vertices != nullptr ? ComposingCall<true>(launch)
                                                 : ComposingCall<false>(launch);
}

}  // namespace latticed::kernels
