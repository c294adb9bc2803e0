// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes the Draco streams of chunks whose vertices are on the device, there. The bytes are those
// of core/codec/draco_writer.h. Only they cross the bus, in one copy; each result is a part of the
// block that was copied.
//
//   digests | symbols, tables | states | places --> host: how many bytes
//   pack    | copy                              --> host: the bytes
//
// Errors   kResourceExhausted for memory of the device or pinned: fewer chunks take less; those of
//          cuda_status.h
// Threads  one at a time; works on the stream of the lane, and has waited for it when it returns
#ifndef LATTICED_CUDA_DRACO_DEVICE_DRACO_WRITER_H_
#define LATTICED_CUDA_DRACO_DEVICE_DRACO_WRITER_H_

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/backend.h"
#include "core/codec/chunk_connectivity.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/device_buffer.h"
#include "cuda/draco/draco_kernels.h"

namespace latticed {

// The numbers that all streams of a view share.
struct DracoShape {
  size_t points = 0;       // of a chunk
  size_t last_points = 0;  // of the last chunk of the plan
  int position_bits = 12;
  int normal_bits = 0;  // 0: no normals
  // For meshes: the connectivity of a chunk, and of the last chunk. Else null.
  std::array<const ChunkConnectivity*, 2> connectivity{};
};

class DeviceDracoWriter {
 public:
  [[nodiscard]] static absl::StatusOr<DeviceDracoWriter> Create(
      const DracoShape& shape, std::shared_ptr<CudaContext> context,
      std::shared_ptr<CudaLane> lane);

  // Chunks in wire layout, one after the other; number `last` is the last of the plan, if it is
  // there.
  struct Vertices {
    DeviceSpan<const uint8_t> bytes;
    uint32_t last = 0;
  };
  // results[i] and digests[i] of chunk numbers[i], as DeformView::Encode says; numbers ascend.
  // `range`: of the quantisation box. `entry_room`: for tests; 0: what most chunks need. kInternal
  // where a coordinate has more than position_bits.
  [[nodiscard]] absl::Status Encode(const Vertices& vertices, std::span<const uint32_t> numbers,
                                    double range, std::span<VertexDigest> digests,
                                    std::span<SharedBytes> results, uint32_t entry_room = 0);

  size_t DeviceBytes() const { return heads_.size_bytes(); }
  size_t PinnedBytes() const { return exchanged_.size(); }

 private:
  DeviceDracoWriter(const DracoShape& shape, std::shared_ptr<CudaContext> context,
                    std::shared_ptr<CudaLane> lane, DeviceBuffer<uint8_t> heads,
                    std::array<uint32_t, 2> head_bytes)
      : shape_(shape),
        context_(std::move(context)),
        lane_(std::move(lane)),
        heads_(std::move(heads)),
        head_bytes_(head_bytes) {}

  // The input and the output of a round. There are no digests, or as many as numbers.
  struct Batch {
    std::vector<uint32_t> numbers;
    std::vector<VertexDigest> digests;  // known, then found
    std::vector<SharedBytes> results;
    std::vector<bool> deferred;
  };
  kernels::DracoFrame Frame(double range) const;
  kernels::DracoWork Work(const Vertices& vertices, const Batch& batch) const;
  // Encodes the chunks that find room; defers the others.
  absl::Status Round(const Vertices& vertices, const kernels::DracoFrame& frame,
                     uint32_t entry_room, Batch& batch);
  // Runs all kernels up to the places. Then exchanged_ has the digests, and after them the places.
  absl::Status Code(const kernels::DracoWork& work, const kernels::DracoFrame& frame,
                    kernels::DracoPlace* places, const Batch& batch);
  // Copies the streams to the host. The size of each is in its place.
  absl::StatusOr<std::shared_ptr<const PinnedBuffer>> Pack(const kernels::DracoWork& work,
                                                           const kernels::DracoFrame& frame,
                                                           const kernels::DracoPlace* places,
                                                           size_t bytes);
  // Copies to the host, and waits.
  absl::Status Fetch(void* to, const void* from, size_t bytes) const;

  DracoShape shape_;
  std::shared_ptr<CudaContext> context_;
  std::shared_ptr<CudaLane> lane_;
  DeviceBuffer<uint8_t> heads_;  // of a chunk, then of the last one
  std::array<uint32_t, 2> head_bytes_;
  PinnedBuffer exchanged_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DRACO_DEVICE_DRACO_WRITER_H_
