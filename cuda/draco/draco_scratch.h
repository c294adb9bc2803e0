// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The device memory that encoding some chunks takes: one block, freed when they are encoded. It is about
// 21 bytes a point with normals, 44 of sparse chunks, and 12 bytes a table entry.
//
// Errors   those of device_buffer.h
// Threads  one at a time
#ifndef LATTICED_CUDA_DRACO_DRACO_SCRATCH_H_
#define LATTICED_CUDA_DRACO_DRACO_SCRATCH_H_

#include <span>

#include "absl/status/statusor.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/device_buffer.h"
#include "cuda/draco/draco_kernels.h"

namespace latticed {

struct DracoScratch {
  DeviceBuffer<uint8_t> block;
  // In the block, one a chunk. The found digests lie just before them.
  kernels::DracoPlace* places;
};

// For `chunks`, which get their first_group, and the chunks of `work`, whose pointers to working memory are set, that to
// digests where they are asked for. work.chunks lies just before the known digests; the caller copies both.
// `entry_room`: 0, what most chunks need; never less than one chunk may need.
[[nodiscard]] absl::StatusOr<DracoScratch> MakeDracoScratch(CudaContext& context,
                                                            cudaStream_t stream,
                                                            uint32_t entry_room, bool digests,
                                                            std::span<kernels::DracoChunk> chunks,
                                                            kernels::DracoWork& work);

}  // namespace latticed

#endif  // LATTICED_CUDA_DRACO_DRACO_SCRATCH_H_
