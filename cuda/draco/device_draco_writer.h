// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes Draco streams on the device, from vertices that are there. The bytes are those of
// core/codec/draco_writer.h. Only they cross the bus, in one copy for all chunks. Each result is a
// part of the copied block. Chunks may have any numbers of points.
//
//   chunks, known digests                        <-- host
//   digests | symbols, tables | states | packing --> host: sizes and places, bytes
//
// The host does not wait for the sizes before it asks for the bytes. It guesses their number from the last streams, asks
// for a sixteenth more, and names the results while they are copied. Streams that need more are packed and copied again.
//
// Errors   kResourceExhausted for device or pinned memory, of which fewer chunks take less; those
//          of cuda_status.h
// Threads  one at a time; works on the stream of the lane and waits for it before it returns
#ifndef LATTICED_CUDA_DRACO_DEVICE_DRACO_WRITER_H_
#define LATTICED_CUDA_DRACO_DEVICE_DRACO_WRITER_H_

#include <array>
#include <cstdint>
#include <memory>
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
  int position_bits = 12;
  int normal_bits = 0;     // 0: no normals
  bool is_sparse = false;  // QuantisedVertices::is_sparse
  // For meshes, the connectivity of chunks of `mesh_points` points, and that of all other chunks; else null.
  std::array<const ChunkConnectivity*, 2> connectivity{};
  size_t mesh_points = 0;
};

class DeviceDracoWriter {
 public:
  [[nodiscard]] static absl::StatusOr<DeviceDracoWriter> Create(
      const DracoShape& shape, std::shared_ptr<CudaContext> context,
      std::shared_ptr<CudaLane> lane);

  // A chunk in wire layout, among the points of all vertices.
  struct Chunk {
    uint64_t first_point = 0;
    uint32_t points = 0;  // 1 or more
  };
  // Sets results[i] and digests[i] of chunks[i], as DeformView::Encode says. `range`: that of the quantisation box.
  // `entry_room`: for tests, the number of table entries; 0: what most chunks need. kInternal where a coordinate has
  // more than position_bits.
  [[nodiscard]] absl::Status Encode(DeviceSpan<const uint8_t> vertices,
                                    std::span<const Chunk> chunks, double range,
                                    std::span<VertexDigest> digests, std::span<SharedBytes> results,
                                    uint32_t entry_room = 0);

  size_t DeviceBytes() const { return heads_.size_bytes(); }
  size_t PinnedBytes() const { return exchanged_.size(); }

 private:
  DeviceDracoWriter(const DracoShape& shape, std::shared_ptr<CudaContext> context,
                    std::shared_ptr<CudaLane> lane, DeviceBuffer<uint8_t> heads,
                    std::array<uint32_t, 2> head_bytes, CudaEvent placed)
      : shape_(shape),
        context_(std::move(context)),
        lane_(std::move(lane)),
        heads_(std::move(heads)),
        head_bytes_(head_bytes),
        placed_(std::move(placed)) {}

  // The arguments of Encode.
  struct Call {
    DeviceSpan<const uint8_t> vertices;
    std::span<const Chunk> chunks;
    kernels::DracoFrame frame;
    std::span<VertexDigest> digests;
    std::span<SharedBytes> results;
    uint32_t entry_room;
  };
  kernels::DracoFrame Frame(double range) const;
  // Encodes those of `numbers`, places in call.chunks, whose tables fit in the store of entries. Returns the others.
  absl::StatusOr<std::vector<size_t>> Round(const Call& call, std::span<const size_t> numbers);
  // Puts the chunks, and behind them their known digests, in exchanged_. Returns the chunks.
  absl::StatusOr<std::span<kernels::DracoChunk>> Stage(const Call& call,
                                                       std::span<const size_t> numbers);
  // Where packed streams go.
  struct Block {
    size_t bytes = 0;
    DeviceBuffer<uint8_t> packed;
    std::shared_ptr<const PinnedBuffer> pinned;
    kernels::DracoRoom room() const { return {packed.data(), bytes}; }
  };
  absl::StatusOr<Block> MakeBlock(size_t bytes) const;
  // The bytes of a block for so many points, a multiple of 16; 0 where there is nothing to go by.
  size_t GuessBytes(uint64_t points) const;
  // Enqueues all kernels, which pack those streams that fit in the block, and its copy to the host. When placed_ is reached,
  // exchanged_ holds the new digests, followed by the places.
  absl::Status Code(const kernels::DracoWork& work, const kernels::DracoFrame& frame,
                    kernels::DracoPlace* places, const Block& block) const;
  absl::Status CopyToHost(const Block& block) const;
  absl::Status CopyToHost(void* to, const void* from, size_t bytes) const;

  DracoShape shape_;
  std::shared_ptr<CudaContext> context_;
  std::shared_ptr<CudaLane> lane_;
  DeviceBuffer<uint8_t> heads_;  // as shape_.connectivity has them; of clouds, one
  std::array<uint32_t, 2> head_bytes_;
  CudaEvent placed_;
  PinnedBuffer exchanged_;
  double bytes_per_point_ = 0;  // of the last streams
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DRACO_DEVICE_DRACO_WRITER_H_
