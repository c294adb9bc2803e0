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
// What it can do for the results before it knows the sizes, it does while the device encodes.
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
#include "cuda/draco/draco_scratch.h"

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

  // The most pinned bytes that a view of so many chunks takes, but for the results.
  static size_t PinnedBytesFor(size_t chunks);
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
  // Puts zeros for the control, the chunks and their known digests in exchanged_, as they lie on the device, and adds
  // the chunks to `sizes`. Behind them there is room for what comes back.
  absl::Status Stage(const Call& call, std::span<const size_t> numbers, DracoSizes& sizes);
  // Where packed streams go.
  struct Block {
    size_t bytes = 0;
    DeviceBuffer<uint8_t> packed;
    std::shared_ptr<const PinnedBuffer> pinned;
    kernels::DracoRoom room() const { return {packed.data(), bytes}; }
  };
  absl::StatusOr<Block> MakeBlock(size_t bytes) const;
  // Makes the block the owner of the named results.
  static void Own(const Call& call, std::span<const size_t> numbers, const Block& block);
  // The bytes of a block for so many points, a multiple of 16; 0 where there is nothing to go by.
  size_t GuessBytes(double points) const;
  // Enqueues all kernels, which pack those streams that fit in the block, and its copy to the host. When placed_ is reached,
  // exchanged_ holds the new digests, followed by the places, behind what was sent.
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
  std::vector<size_t> all_;     // 0, 1, 2, …
  double bytes_per_point_ = 0;  // of the last round that coded any
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DRACO_DEVICE_DRACO_WRITER_H_
