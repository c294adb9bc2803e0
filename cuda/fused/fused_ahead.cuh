// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Prefetches to the L2 cache what a later chunk needs of the plan. A block begins when an earlier one ends,
// and waits first for its patches and then for their vertices. Prefetching saves 1 to 5 % of the time at
// 113,663 patches and 10 segments.
#ifndef LATTICED_CUDA_FUSED_FUSED_AHEAD_CUH_
#define LATTICED_CUDA_FUSED_FUSED_AHEAD_CUH_

#include "cuda/fused/fused_geometry.cuh"

namespace latticed::kernels {

// For the chunk that begins about when the warp's own chunk ends. Called by one warp, one lane a patch.
class PlanAhead {
 public:
  // `index`: the place of the later chunk in the launch.
  __device__ PlanAhead(const FusedLaunch& launch, uint32_t index, unsigned lane)
      : launch_(launch), lane_(lane) {
    if (index >= launch.chunk_count) return;
    first_ = (launch.chunks != nullptr ? launch.chunks[index] : index) * kLanes;
    is_whole_ = first_ + kLanes <= launch.patch_count;
  }

  // The chunk's part of a table with one entry a patch; a lane prefetches one cache line.
  template <typename T>
  __device__ __forceinline__ void BringPartOf(const T* table) const {
    constexpr unsigned kLine = 128, kLines = kLanes * sizeof(T) / kLine;
    static_assert(kLines <= kLanes && kLanes * sizeof(T) % kLine == 0);
    if (!is_whole_ || lane_ >= kLines) return;
    Bring(reinterpret_cast<const char*>(table + first_) + lane_ * kLine);
  }
  __device__ __forceinline__ void BringPatches() {
    if (is_whole_) patch_ = launch_.plan.patches[first_ + lane_];
  }

  // Called later, so that it need not wait for the patches.
  __device__ __forceinline__ void BringVertices() const {
    if (!is_whole_) return;
#pragma unroll
    for (int corner = 0; corner < 3; ++corner) Bring(launch_.plan.vertices + patch_.Vertex(corner));
  }

 private:
  __device__ __forceinline__ static void Bring(const void* line) {
    asm volatile("prefetch.global.L2 [%0];" ::"l"(line));
  }

  const FusedLaunch& launch_;
  const unsigned lane_;
  uint32_t first_ = 0;  // patch
  bool is_whole_ = false;
  DevicePatch patch_;
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_AHEAD_CUH_
