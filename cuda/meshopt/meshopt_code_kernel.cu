// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Codes blocks of 256 vertices, a warp a block. The warp puts the block together in shared memory, byte by byte, and copies
// it to working memory in whole sectors.
#include "cuda/meshopt/meshopt_block.cuh"
#include "cuda/meshopt/meshopt_kernels.h"
#include "cuda/meshopt/meshopt_numbers.cuh"

namespace latticed::kernels {
namespace {

using meshopt_format::kBlockVertices;

constexpr uint32_t kMostWarps = 4;  // of a block of threads

// A number of 16 bits, whose lower byte is the byte `byte` of a vertex.
__device__ __forceinline__ void PutNumber(uint32_t byte, const uint8_t* numbers, uint32_t first,
                                          uint32_t points, MeshoptBlock& writer) {
  const auto [words] = DifferencesAt<16>(reinterpret_cast<const uint16_t*>(numbers), first, points);
  constexpr uint32_t kLower = 0x6420, kUpper = 0x7531;
  writer.Put(byte,
             {__byte_perm(words[0], words[1], kLower), __byte_perm(words[2], words[3], kLower)});
  writer.Put(byte + 1,
             {__byte_perm(words[0], words[1], kUpper), __byte_perm(words[2], words[3], kUpper)});
}

// A number of 8 bits, which is the byte `byte` of a vertex.
__device__ __forceinline__ void PutByte(uint32_t byte, const uint8_t* numbers, uint32_t first,
                                        uint32_t points, MeshoptBlock& writer) {
  const auto [words] = DifferencesAt<8>(numbers, first, points);
  writer.Put(byte, {words[0], words[1]});
}

// All numbers of the vertices. In loops, because the code of a number is long.
__device__ __forceinline__ void PutVertices(const uint8_t* vertices, int32_t normal_bits,
                                            uint32_t first, uint32_t points, MeshoptBlock& writer) {
  constexpr uint32_t kAxes = 3, kNormals = 2, kNumberBytes = sizeof(uint16_t);
  const uint32_t plane = kNumberBytes * points;
  // In wire layout, wide normals are like two more axes. In a vertex, a number of zeros is between.
  const uint32_t wide = normal_bits > 8 ? kAxes + kNormals : kAxes;
#pragma unroll 1
  for (uint32_t i = 0; i < wide; ++i) {
    const uint32_t byte = kNumberBytes * (i < kAxes ? i : i + 1);
    PutNumber(byte, vertices + i * plane, first, points, writer);
  }
  for (uint32_t i = 0; i < kNumberBytes; ++i) writer.PutZeros(kNumberBytes * kAxes + i);
  if (normal_bits > 8) return;
#pragma unroll 1
  for (uint32_t i = 0; i < kNormals; ++i) {
    const uint32_t byte = kNumberBytes * (kAxes + 1 + i);
    if (normal_bits == 0) {
      writer.PutZeros(byte);
    } else {
      PutByte(byte, vertices + kAxes * plane + i * points, first, points, writer);
    }
    writer.PutZeros(byte + 1);
  }
}

__global__ void __launch_bounds__(kMostWarps* kWarp)
    CodeKernel(const __grid_constant__ MeshoptWork work) {
  extern __shared__ uint4 shared[];
  const uint32_t chunk = blockIdx.x, warp = threadIdx.x / kWarp;
  const uint32_t block = blockIdx.y * (blockDim.x / kWarp) + warp;
  const uint32_t first = block * kBlockVertices, points = work.Points(chunk);
  if (first >= points || work.IsUnchanged(chunk)) return;
  const uint32_t room = work.BlockRoom() / sizeof(uint4);
  uint4* const its = shared + warp * room;
  MeshoptBlock writer(reinterpret_cast<uint8_t*>(its), min(kBlockVertices, points - first));
  PutVertices(work.Vertices(chunk), work.normal_bits, first, points, writer);
  const uint32_t bytes = writer.Finish();
  __syncwarp();
  const uint32_t at = work.chunks[chunk].scratch_at + block;
  auto* const out = reinterpret_cast<uint4*>(work.blocks) + size_t{at} * room;
  for (uint32_t i = Lane(); i * sizeof(uint4) < bytes; i += kWarp) out[i] = its[i];
  if (Lane() == 0) work.block_bytes[at] = bytes;
}

}  // namespace

cudaError_t LaunchMeshoptCode(const MeshoptWork& work, cudaStream_t stream) {
  if (work.count == 0) return cudaSuccess;
  // As few as can be, with equally many warps each.
  const uint32_t blocks = (work.most_blocks + kMostWarps - 1) / kMostWarps;
  const uint32_t warps = (work.most_blocks + blocks - 1) / blocks;
  CodeKernel<<<dim3(work.count, blocks), warps * kWarp, warps * work.BlockRoom(), stream>>>(work);
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
