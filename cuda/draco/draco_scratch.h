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

#include <algorithm>
#include <cstdint>

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

// Counts what the chunks of an encoding need. The device may wait for this, so a chunk takes no more than a few operations.
class DracoSizes {
 public:
  // Of `work`, only the properties of the view.
  explicit DracoSizes(const kernels::DracoWork& work);

  // Adds a chunk, and returns DracoChunk::first_group.
  uint32_t Add(uint32_t points) {
    const uint32_t first_group = groups_;
    // No less than what its streams take, each rounded up: a sum of floor((n + 15) / 16) is at most floor of the sum.
    groups_ += (points * values_ + room_) / kernels::kSymbolsAWord;
    ++chunks_;
    points_ += points;
    if (points > kernels::kMostRankedPoints) {
      ++large_;
      large_points_ += points;
    } else {
      most_of_others_ = std::max(most_of_others_, points);
    }
    return first_group;
  }
  uint64_t points() const { return points_; }

 private:
  friend absl::StatusOr<DracoScratch> MakeDracoScratch(CudaContext&, cudaStream_t, uint32_t, bool,
                                                       const DracoSizes&, kernels::DracoWork&);

  uint32_t values_ = 0,
           room_ = 0;  // symbols of a point in all streams; what rounding a chunk's up may take
  uint32_t groups_ = 0, chunks_ = 0, large_ = 0, most_of_others_ = 0;
  uint64_t points_ = 0, large_points_ = 0;
};

// For the chunks of `sizes`. Sets their number in `work`, whether they are ranked, and the pointers to working memory, that
// to digests where they are asked for. work.control, work.chunks and the known digests lie one after the other, and the
// caller copies them. `entry_room`: 0, what most chunks need; never less than one chunk may need.
[[nodiscard]] absl::StatusOr<DracoScratch> MakeDracoScratch(CudaContext& context,
                                                            cudaStream_t stream,
                                                            uint32_t entry_room, bool digests,
                                                            const DracoSizes& sizes,
                                                            kernels::DracoWork& work);

}  // namespace latticed

#endif  // LATTICED_CUDA_DRACO_DRACO_SCRATCH_H_
