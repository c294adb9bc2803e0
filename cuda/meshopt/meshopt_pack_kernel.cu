// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds the next place for each chunk's stream, and copies its blocks there, a warp a block.
#include "cuda/meshopt/meshopt_kernels.h"
#include "cuda/streams/stream_places.cuh"
#include "cuda/streams/warp.cuh"

namespace latticed::kernels {
namespace {

using meshopt_format::kHeader;
using meshopt_format::kShortDifferences;
using meshopt_format::kTailBytes;
using meshopt_format::kTailPadding;
using meshopt_format::kVertexBytes;
using meshopt_format::NormalDifferences;

// Threads that pack a chunk.
constexpr unsigned kThreads = 128;

struct Arguments {
  MeshoptWork work;
  StreamPlaces known;
  StreamRoom room;
};

// Sets where each block of a chunk begins, and where the last one ends. Called by one warp.
__device__ void FindBegins(const uint32_t* block_bytes, uint32_t blocks, uint32_t* begins) {
  uint32_t at = 1;  // behind the header
  for (uint32_t first = 0; first < blocks; first += kWarp) {
    const uint32_t block = first + Lane();
    const uint32_t bytes = block < blocks ? block_bytes[block] : 0;
    const uint32_t up_to = at + SumUpTo(bytes);
    if (block < blocks) begins[block] = up_to - bytes;
    at = __shfl_sync(kAllLanes, up_to, kWarp - 1);
  }
  if (Lane() == 0) begins[blocks] = at;
}

// A byte of the first vertex.
__device__ uint8_t FirstVertexByte(const MeshoptWork& work, uint32_t chunk, uint32_t byte) {
  const uint8_t* const vertices = work.Vertices(chunk);
  const uint32_t points = work.Points(chunk);
  const uint32_t number = byte / sizeof(uint16_t), upper = byte % sizeof(uint16_t);
  if (number < 3) return vertices[number * sizeof(uint16_t) * points + upper];
  if (number == 3 || !work.has_normals()) return 0;
  const uint8_t* const normals = vertices + 3 * sizeof(uint16_t) * points;
  if (work.normal_bits > 8) return normals[(number - 4) * sizeof(uint16_t) * points + upper];
  return upper == 0 ? normals[(number - 4) * points] : 0;
}

// A byte of what comes behind the blocks.
__device__ uint8_t TailByte(const MeshoptWork& work, uint32_t chunk, uint32_t byte) {
  if (byte < kTailPadding) return 0;
  if (byte < kTailPadding + kVertexBytes) return FirstVertexByte(work, chunk, byte - kTailPadding);
  return byte + 1 < kTailBytes ? kShortDifferences : NormalDifferences(work.normal_bits);
}

__global__ void __launch_bounds__(kThreads)
    PackKernel(const __grid_constant__ Arguments arguments) {
  __shared__ uint32_t begins[kMostMeshoptBlocks + 1];
  const MeshoptWork& work = arguments.work;
  const StreamRoom& room = arguments.room;
  const uint32_t chunk = blockIdx.x, blocks = MeshoptBlocks(work.Points(chunk));
  const uint32_t first = work.chunks[chunk].scratch_at;
  const bool unchanged = work.IsUnchanged(chunk);
  if (!unchanged && threadIdx.x < kWarp) FindBegins(work.block_bytes + first, blocks, begins);
  __syncthreads();
  const StreamPlace place = FindPlace<kThreads>(work, arguments.known, room, chunk, [&] {
    return unchanged ? 0 : begins[blocks] + kTailBytes;
  });
  if (!MustWrite<kThreads>(place, room)) return;
  uint8_t* const out = room.bytes + place.at;
  if (threadIdx.x == 0) out[0] = kHeader;
  for (uint32_t block = threadIdx.x / kWarp; block < blocks; block += kThreads / kWarp) {
    const uint8_t* const from = work.blocks + size_t{first + block} * work.BlockRoom();
    uint8_t* const to = out + begins[block];
    const uint32_t bytes = begins[block + 1] - begins[block];
#pragma unroll 4
    for (uint32_t i = Lane(); i < bytes; i += kWarp) to[i] = from[i];
  }
  uint8_t* const tail = out + begins[blocks];
  if (threadIdx.x < kTailBytes) tail[threadIdx.x] = TailByte(work, chunk, threadIdx.x);
  ZeroBytes<kThreads>(tail + kTailBytes, room.bytes + EndOf(place));
}

}  // namespace

cudaError_t LaunchMeshoptPack(const MeshoptWork& work, StreamPlaces known, const StreamRoom& room,
                              cudaStream_t stream) {
  if (work.count == 0) return cudaSuccess;
  PackKernel<<<work.count, kThreads, 0, stream>>>(Arguments{work, known, room});
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
