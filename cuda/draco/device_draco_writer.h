// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes Draco streams on the device, from vertices that are there. The bytes are those of
// core/codec/draco_writer.h. Only they cross the bus, in one copy for all chunks. Each result is a
// part of the copied block.
//
//   digests | symbols, tables | states | places --> host: sizes
//   pack    | copy                              --> host: bytes
//
// Errors   kResourceExhausted for device or pinned memory, of which fewer chunks take less; those
//          of cuda_status.h
// Threads  one at a time; works on the stream of the lane and waits for it before it returns
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

// The properties that all streams of a view share.
struct DracoShape {
  size_t points = 0;       // of a chunk
  size_t last_points = 0;  // of the last chunk of the plan
  int position_bits = 12;
  int normal_bits = 0;  // 0: no normals
  // For meshes, the connectivity of a full chunk and of the last chunk; else null.
  std::array<const ChunkConnectivity*, 2> connectivity{};
};

class DeviceDracoWriter {
 public:
  [[nodiscard]] static absl::StatusOr<DeviceDracoWriter> Create(
      const DracoShape& shape, std::shared_ptr<CudaContext> context,
      std::shared_ptr<CudaLane> lane);

  // Chunks in wire layout, one after the other. `last`: the number that the plan's last chunk has
  // here, or a number that is not used.
  struct Vertices {
    DeviceSpan<const uint8_t> bytes;
    uint32_t last = 0;
  };
  // Sets results[i] and digests[i] of chunk numbers[i], as DeformView::Encode says. `numbers` ascend.
  // `range`: that of the quantisation box. `entry_room`: for tests, the number of table entries; 0:
  // what most chunks need. kInternal where a coordinate has more than position_bits.
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

  // The input and the output of a round. `digests` is empty or has as many elements as `numbers`.
  struct Batch {
    std::vector<uint32_t> numbers;
    std::vector<VertexDigest> digests;  // those known before, then the new ones
    std::vector<SharedBytes> results;
    std::vector<bool> deferred;
  };
  kernels::DracoFrame Frame(double range) const;
  kernels::DracoWork Work(const Vertices& vertices, const Batch& batch) const;
  // Encodes the chunks whose tables fit in the store of entries, and defers the others.
  absl::Status Round(const Vertices& vertices, const kernels::DracoFrame& frame,
                     uint32_t entry_room, Batch& batch);
  // Runs the kernels up to PlacesKernel. exchanged_ then holds the new digests, followed by the places.
  absl::Status Code(const kernels::DracoWork& work, const kernels::DracoFrame& frame,
                    kernels::DracoPlace* places, const Batch& batch);
  // Packs the streams and copies them to the host. `places` says where each one is.
  absl::StatusOr<std::shared_ptr<const PinnedBuffer>> Pack(const kernels::DracoWork& work,
                                                           const kernels::DracoFrame& frame,
                                                           const kernels::DracoPlace* places,
                                                           size_t bytes);
  // Copies to the host and waits.
  absl::Status Fetch(void* to, const void* from, size_t bytes) const;

  DracoShape shape_;
  std::shared_ptr<CudaContext> context_;
  std::shared_ptr<CudaLane> lane_;
  DeviceBuffer<uint8_t> heads_;  // of full chunks, then of the last one
  std::array<uint32_t, 2> head_bytes_;
  PinnedBuffer exchanged_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DRACO_DEVICE_DRACO_WRITER_H_
