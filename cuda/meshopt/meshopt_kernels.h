// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Meshopt streams of quantised chunks, written on the device: the bytes of core/codec/meshopt/meshopt_writer.h.
//
//   meshopt_code_kernel.cu  a warp a block of 256 vertices   integers -> the bytes of the block
//   meshopt_pack_kernel.cu  a block of threads a chunk       the bytes of the stream, in the next place
//
// Layout, errors and threads: those of cuda/streams/stream_kernels.h.
#ifndef LATTICED_CUDA_MESHOPT_MESHOPT_KERNELS_H_
#define LATTICED_CUDA_MESHOPT_MESHOPT_KERNELS_H_

#include <cuda_runtime_api.h>

#include <cstdint>

#include "core/codec/meshopt/meshopt_format.h"
#include "cuda/streams/stream_kernels.h"

namespace latticed::kernels {

// Chunks to encode, and the memory to do it in. Those of a chunk are the blocks from StreamChunk::scratch_at on.
struct MeshoptWork : StreamWork {
  uint8_t* blocks;        // the bytes of each, in BlockRoom()
  uint32_t* block_bytes;  // how many there are
  uint32_t most_blocks;   // of a chunk

  // No byte of a vertex takes more than a plain one.
  LATTICED_HD uint32_t BlockRoom() const {
    return static_cast<uint32_t>(
        RoundUpTo16(meshopt_format::kChannels + meshopt_format::kBlockVertices * BytesPerPoint()));
  }
};

// The most of a chunk, which has 65,535 points at most.
inline constexpr uint32_t kMostMeshoptBlocks = 256;
LATTICED_HD constexpr uint32_t MeshoptBlocks(uint32_t points) {
  return (points + meshopt_format::kBlockVertices - 1) / meshopt_format::kBlockVertices;
}

cudaError_t LaunchMeshoptCode(const MeshoptWork& work, cudaStream_t stream);
cudaError_t LaunchMeshoptPack(const MeshoptWork& work, StreamPlaces known, const StreamRoom& room,
                              cudaStream_t stream);

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_MESHOPT_MESHOPT_KERNELS_H_
