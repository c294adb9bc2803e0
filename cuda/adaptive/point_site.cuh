// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which vertex of a view with a tolerance a thread has, and where that is in its patch.
#ifndef LATTICED_CUDA_ADAPTIVE_POINT_SITE_CUH_
#define LATTICED_CUDA_ADAPTIVE_POINT_SITE_CUH_

#include "cuda/adaptive/adaptive_kernels.h"

namespace latticed::kernels {

// The last of `count` ascending numbers that is at most `value`; the first one is.
template <typename T, typename V>
__device__ __forceinline__ uint32_t LastAtMost(const T* numbers, uint32_t count, V value) {
  uint32_t low = 0, high = count;
  while (high - low > 1) {
    const uint32_t middle = (low + high) / 2;
    (numbers[middle] <= value ? low : high) = middle;
  }
  return low;
}

// Where a vertex is: its patch, its place in the pattern, and its number among the points of its chunk.
struct PointSite {
  uint64_t chunk_first;
  uint32_t chunk_points, in_chunk, patch;
  PatternPlace place;
};
__device__ __forceinline__ PointSite SiteOf(const AdaptiveLaunch& launch, uint64_t point) {
  const AdaptiveState& state = launch.state;
  const uint32_t chunk = LastAtMost(state.chunk_first, launch.plan_chunks, point);
  PointSite site;
  site.chunk_first = state.chunk_first[chunk];
  site.chunk_points = static_cast<uint32_t>(state.chunk_first[chunk + 1] - site.chunk_first);
  site.in_chunk = static_cast<uint32_t>(point - site.chunk_first);
  const uint32_t first = chunk * kChunkPatches;
  const uint16_t* first_points = state.first_points + first;
  const uint32_t of_chunk =
      LastAtMost(first_points, min(kChunkPatches, launch.fused.patch_count - first), site.in_chunk);
  site.patch = first + of_chunk;
  const PatternHead head = launch.tables.heads[state.codes[site.patch]];
  site.place = launch.tables.places[head.first_place + site.in_chunk - first_points[of_chunk]];
  return site;
}

// A place between corners a, b and c of a patch.
struct Between {
  int a, b, c;
  float along, up;

  __device__ __forceinline__ explicit Between(PatternPlace place)
      : a(0), b(1), c(2), along(place.Along()), up(place.Up()) {
    const int kind = place.Kind();
    if (kind == PatternPlace::kInside) return;
    a = b = c = kind % 3;
    if (kind >= 3) b = a == 2 ? 0 : a + 1;
  }
  // An index that is not a constant would move the corners from registers to memory.
  __device__ __forceinline__ static float Pick(int corner, float c0, float c1, float c2) {
    return corner == 0 ? c0 : corner == 1 ? c1 : c2;
  }
  __device__ __forceinline__ static float OnLine(float from, float to, float along) {
    return fmaf(to - from, along, 0.5f * (from + to));
  }
  __device__ __forceinline__ float Of(float c0, float c1, float c2) const {
    const float from = Pick(a, c0, c1, c2), to = Pick(b, c0, c1, c2);
    const float on_line = OnLine(from, to, along);
    if (up == 0) return on_line;
    return fmaf(Pick(c, c0, c1, c2) - 0.5f * (from + to), up, on_line);
  }
  // They are exact in float.
  __device__ __forceinline__ Vec3d Barycentrics() const {
    return {Of(1, 0, 0), Of(0, 1, 0), Of(0, 0, 1)};
  }
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_ADAPTIVE_POINT_SITE_CUH_
