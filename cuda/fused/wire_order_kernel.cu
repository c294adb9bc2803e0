// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Copies chunks from the fused kernel's lane order to wire order. A block takes 32 points of a chunk. It
// reads them point by point, in whole cache lines, and writes them patch by patch, through shared memory.
#include "cuda/fused/fused_kernels.h"

namespace latticed::kernels {
namespace {

constexpr int kTile = 32;  // points, and lanes
constexpr int kRowsAtOnce = 8;

struct Place {
  uint32_t chunk;
  int lanes;     // patches of the chunk
  int points;    // a patch
  uint8_t* out;  // first byte of the chunk
};

__device__ Place PlaceOf(const WireOrder& order) {
  const WireChunk chunk = order.chunks[blockIdx.x];
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

// The planes x, y and z of 16 bits come first, then s and t as T.
template <class T>
__device__ void StoreNormal(const Place& place, int at, uint32_t s, uint32_t t) {
  const int points = place.lanes * place.points;
  T* plane = reinterpret_cast<T*>(place.out + 6 * points);
  plane[at] = static_cast<T>(s);
  plane[points + at] = static_cast<T>(t);
}

__global__ void QuantisedKernel(const __grid_constant__ WireOrder order) {
  const Place place = PlaceOf(order);
  const bool small = order.format == LaneFormat::kQuantised8;
  const size_t first = size_t{place.chunk} * static_cast<size_t>(place.points) * kTile;
  const auto* words = reinterpret_cast<const uint2*>(order.vertices) + first;
  auto* to = reinterpret_cast<uint16_t*>(place.out);
  const int points = place.lanes * place.points;
  Transpose<uint2>(
      place, [&](int point, int lane) { return words[point * kTile + lane]; },
      [&](int lane, int point, uint2 v) {
        const int at = lane * place.points + point;
        to[at] = static_cast<uint16_t>(v.x);
        to[points + at] = static_cast<uint16_t>(v.x >> 16);
        to[2 * points + at] = static_cast<uint16_t>(v.y);
        if (order.normals && small) StoreNormal<uint8_t>(place, at, v.y >> 16 & 255, v.y >> 24);
      });
  if (!order.normals || small) return;
  const auto* normals = reinterpret_cast<const uint32_t*>(order.second_plane) + first;
  Transpose<uint32_t>(
      place, [&](int point, int lane) { return normals[point * kTile + lane]; },
      [&](int lane, int point, uint32_t st) {
        StoreNormal<uint16_t>(place, lane * place.points + point, st & 0xffff, st >> 16);
      });
}

}  // namespace

cudaError_t LaunchWireOrder(const WireOrder& order, cudaStream_t stream) {
  if (order.chunk_count == 0) return cudaSuccess;
  const auto points = static_cast<unsigned>(order.points_per_patch);
  const dim3 grid(order.chunk_count, (points + kTile - 1) / kTile), block(kTile, kRowsAtOnce);
  if (order.format == LaneFormat::kFloat32) {
    FloatsKernel<<<grid, block, 0, stream>>>(order);
  } else {
    QuantisedKernel<<<grid, block, 0, stream>>>(order);
  }
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
