// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Copies chunks from the fused kernel's lane order to wire order. Both sides are whole cache lines, through shared memory.
// Of floats, a block takes 32 points of a chunk; of integers, as many patches of it as fit.
#include "cuda/fused/fused_kernels.h"

namespace latticed::kernels {
namespace {

constexpr int kTile = 32;  // points of floats, and lanes
constexpr int kRowsAtOnce = 8;
constexpr unsigned kIntegerThreads = 256;

struct Place {
  uint32_t chunk;
  int lanes;     // patches of the chunk
  int points;    // a patch
  uint8_t* out;  // first byte of the chunk
};

__device__ Place PlaceOf(const WireOrder& order) {
  const WireChunk chunk = order.chunks != nullptr ? order.chunks[blockIdx.x]
                                                  : WireChunk{blockIdx.x * order.chunk_bytes,
                                                              order.first_chunk + blockIdx.x};
  const uint32_t left = order.patch_count - chunk.chunk * kTile;
  return {chunk.chunk, left < kTile ? static_cast<int>(left) : kTile, order.points_per_patch,
          order.out + chunk.offset};
}

// Calls store(lane, point, word) with consecutive points in consecutive threads.
template <class T, class Load, class Store>
__device__ void Transpose(const Place& place, const Load& load, const Store& store) {
  __shared__ T tile[kTile][kTile + 1];
  const int first = static_cast<int>(blockIdx.y) * kTile;
  const int x = static_cast<int>(threadIdx.x);
  __syncthreads();  // until an earlier call has read the tile
  for (int y = static_cast<int>(threadIdx.y); y < kTile; y += kRowsAtOnce) {
    if (first + y < place.points) tile[y][x] = load(first + y, x);
  }
  __syncthreads();
  for (int y = static_cast<int>(threadIdx.y); y < place.lanes; y += kRowsAtOnce) {
    if (first + x < place.points) store(y, first + x, tile[x][y]);
  }
}

__global__ void FloatsKernel(const __grid_constant__ WireOrder order) {
  const Place place = PlaceOf(order);
  const int numbers = order.normals ? 6 : 3;
  const float* from = reinterpret_cast<const float*>(order.vertices) +
                      size_t{place.chunk} * static_cast<size_t>(place.points * numbers) * kTile;
  auto* to = reinterpret_cast<float*>(place.out);
  for (int i = 0; i < numbers; ++i) {
    Transpose<float>(
        place, [&](int point, int lane) { return from[(point * numbers + i) * kTile + lane]; },
        [&](int lane, int point, float value) {
          to[(lane * place.points + point) * numbers + i] = value;
        });
  }
}

// Copies what threads of the block wrote to shared memory; the last chunk's planes may begin anywhere.
__device__ void CopyPlane(uint8_t* to, const uint8_t* from, uint32_t bytes) {
  const auto both = reinterpret_cast<uintptr_t>(to) | reinterpret_cast<uintptr_t>(from) | bytes;
  if (both % sizeof(uint4) == 0) {
    for (uint32_t i = threadIdx.x; i < bytes / sizeof(uint4); i += blockDim.x) {
      reinterpret_cast<uint4*>(to)[i] = reinterpret_cast<const uint4*>(from)[i];
    }
  } else {
    for (uint32_t i = threadIdx.x; i < bytes; i += blockDim.x) to[i] = from[i];
  }
}

// The planes of integers: x, y and z of two bytes, then s and t of normal_bytes, or none.
struct Planes {
  uint32_t normal_bytes;
  __device__ uint32_t count() const { return normal_bytes == 0 ? 3 : 5; }
  // The bytes of a value, and of the values of a point before it.
  __device__ uint32_t BytesOf(uint32_t plane) const { return plane < 3 ? 2 : normal_bytes; }
  __device__ uint32_t BytesBefore(uint32_t plane) const {
    return plane < 3 ? 2 * plane : 6 + (plane - 3) * normal_bytes;
  }
};

// A block takes the patches from blockIdx.y * kPatches on.
template <uint32_t kPatches>
__global__ void __launch_bounds__(kIntegerThreads)
    IntegersKernel(const __grid_constant__ WireOrder order) {
  extern __shared__ uint4 shared[];
  auto* const staged = reinterpret_cast<uint8_t*>(shared);
  const Place place = PlaceOf(order);
  const uint32_t lanes = static_cast<uint32_t>(place.lanes),
                 points = static_cast<uint32_t>(place.points);
  const uint32_t first_lane = blockIdx.y * kPatches;
  if (first_lane >= lanes) return;
  const uint32_t patches = min(kPatches, lanes - first_lane), values = patches * points;
  const Planes planes{!order.normals ? 0u : order.format == LaneFormat::kQuantised8 ? 1u : 2u};
  const auto plane16 = [&](uint32_t plane) {
    return reinterpret_cast<uint16_t*>(staged + planes.BytesBefore(plane) * values);
  };
  const size_t first = size_t{place.chunk} * points * kTile + first_lane;
  const auto* words = reinterpret_cast<const uint2*>(order.vertices) + first;
  const auto* normals = reinterpret_cast<const uint32_t*>(order.second_plane) + first;
  for (uint32_t i = threadIdx.x; i < points * kPatches; i += kIntegerThreads) {
    const uint32_t lane = i % kPatches, point = i / kPatches;
    if (lane >= patches) continue;
    const uint2 v = __ldg(words + point * kTile + lane);
    const uint32_t at = lane * points + point;
    plane16(0)[at] = static_cast<uint16_t>(v.x);
    plane16(1)[at] = static_cast<uint16_t>(v.x >> 16);
    plane16(2)[at] = static_cast<uint16_t>(v.y);
    if (planes.normal_bytes == 1) {
      staged[6 * values + at] = static_cast<uint8_t>(v.y >> 16);
      staged[7 * values + at] = static_cast<uint8_t>(v.y >> 24);
    } else if (planes.normal_bytes == 2) {
      const uint32_t st = __ldg(normals + point * kTile + lane);
      plane16(3)[at] = static_cast<uint16_t>(st);
      plane16(4)[at] = static_cast<uint16_t>(st >> 16);
    }
  }
  __syncthreads();
  for (uint32_t plane = 0; plane < planes.count(); ++plane) {
    const uint32_t before = planes.BytesBefore(plane), bytes = planes.BytesOf(plane);
    CopyPlane(place.out + before * lanes * points + bytes * first_lane * points,
              staged + before * values, bytes * values);
  }
}

// Takes all patches of a chunk, or half of them and so on, as many as shared memory has room for.
template <uint32_t kPatches = kTile>
void LaunchIntegers(const WireOrder& order, cudaStream_t stream) {
  constexpr size_t kMostSharedBytes = 40 << 10;
  const size_t shared = size_t{kPatches} * static_cast<size_t>(order.points_per_patch) *
                        (order.format == LaneFormat::kQuantised8 ? 8 : 10);
  if constexpr (kPatches > 1) {
    if (shared > kMostSharedBytes) return LaunchIntegers<kPatches / 2>(order, stream);
  }
  const dim3 grid(order.chunk_count, kTile / kPatches);
  IntegersKernel<kPatches><<<grid, kIntegerThreads, shared, stream>>>(order);
}

}  // namespace

cudaError_t LaunchWireOrder(const WireOrder& order, cudaStream_t stream) {
  if (order.chunk_count == 0) return cudaSuccess;
  if (order.format == LaneFormat::kFloat32) {
    const auto points = static_cast<unsigned>(order.points_per_patch);
    const dim3 grid(order.chunk_count, (points + kTile - 1) / kTile), block(kTile, kRowsAtOnce);
    FloatsKernel<<<grid, block, 0, stream>>>(order);
  } else {
    LaunchIntegers(order, stream);
  }
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
