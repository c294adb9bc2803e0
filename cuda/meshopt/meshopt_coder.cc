// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/meshopt/meshopt_coder.h"

#include <algorithm>

namespace latticed {

size_t MeshoptCoder::Plan(std::span<kernels::StreamChunk> chunks) {
  uint32_t all = 0, most = 0;
  for (kernels::StreamChunk& chunk : chunks) {
    const uint32_t blocks = kernels::MeshoptBlocks(chunk.points);
    chunk.scratch_at = all;
    all += blocks;
    most = std::max(most, blocks);
  }
  work_.most_blocks = most;
  blocks_ = all;
  return blocks_ * (work_.BlockRoom() + sizeof(*work_.block_bytes));
}

cudaError_t MeshoptCoder::Code(const kernels::StreamWork& work, uint8_t* scratch,
                               cudaStream_t stream) {
  static_cast<kernels::StreamWork&>(work_) = work;
  work_.blocks = scratch;
  work_.block_bytes = reinterpret_cast<uint32_t*>(scratch + blocks_ * work_.BlockRoom());
  return kernels::LaunchMeshoptCode(work_, stream);
}

cudaError_t MeshoptCoder::Pack(kernels::StreamPlaces places, const kernels::StreamRoom& room,
                               cudaStream_t stream) const {
  return kernels::LaunchMeshoptPack(work_, places, room, stream);
}

}  // namespace latticed
