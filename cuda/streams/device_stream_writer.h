// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes the streams of chunks on the device, from vertices that are there. A StreamCoder knows the codec. Only the bytes
// cross the bus, in one copy for all chunks. Each result is a part of the copied block. Chunks may have any numbers of
// points.
//
//   chunks, known digests        <-- host
//   digests | coding | packing   --> host: sizes and places, bytes
//
// The host does not wait for the sizes before it asks for the bytes. It guesses their number from the last streams, asks
// for a sixteenth more, and names the results while they are copied. Streams that need more are packed and copied again.
// What it can do for the results before it knows the sizes, it does while the device encodes.
//
// Errors   kResourceExhausted for device or pinned memory, of which fewer chunks take less; those
//          of cuda_status.h
// Threads  one at a time; works on the stream of the lane and waits for it before it returns
#ifndef LATTICED_CUDA_STREAMS_DEVICE_STREAM_WRITER_H_
#define LATTICED_CUDA_STREAMS_DEVICE_STREAM_WRITER_H_

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/backend.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/device_buffer.h"
#include "cuda/streams/stream_coder.h"

namespace latticed {

class DeviceStreamWriter {
 public:
  [[nodiscard]] static absl::StatusOr<DeviceStreamWriter> Create(
      std::unique_ptr<StreamCoder> coder, std::shared_ptr<CudaContext> context,
      std::shared_ptr<CudaLane> lane);

  // A chunk in wire layout, among the points of all vertices.
  struct Chunk {
    uint64_t first_point = 0;
    uint32_t points = 0;  // 1 or more
  };
  // Sets results[i] and digests[i] of chunks[i], as DeformView::Encode says. `range`: that of the quantisation box.
  // kInternal where the coder has no room even for one chunk.
  [[nodiscard]] absl::Status Encode(DeviceSpan<const uint8_t> vertices,
                                    std::span<const Chunk> chunks, double range,
                                    std::span<VertexDigest> digests,
                                    std::span<SharedBytes> results);

  // The most pinned bytes that a view of so many chunks takes, but for the results.
  static size_t PinnedBytesFor(size_t chunks);
  std::string_view purpose() const { return coder_->purpose(); }
  size_t DeviceBytes() const { return coder_->DeviceBytes(); }
  size_t PinnedBytes() const { return exchanged_.size(); }

 private:
  DeviceStreamWriter(std::unique_ptr<StreamCoder> coder, std::shared_ptr<CudaContext> context,
                     std::shared_ptr<CudaLane> lane, CudaEvent placed)
      : context_(std::move(context)),
        lane_(std::move(lane)),
        coder_(std::move(coder)),
        placed_(std::move(placed)) {}

  // The arguments of Encode.
  struct Call {
    DeviceSpan<const uint8_t> vertices;
    std::span<const Chunk> chunks;
    std::span<VertexDigest> digests;
    std::span<SharedBytes> results;
  };
  // Where the parts of a round begin, in exchanged_ and on the device. The control comes first. All that is before `found`
  // goes to the device, and the rest comes back.
  struct Layout {
    Layout(size_t count, size_t zeros, bool has_digests);
    size_t chunks, known, found, places, end;
  };
  // Encodes those of `numbers`, places in call.chunks, for which the coder has room. Returns the others.
  absl::StatusOr<std::vector<size_t>> Round(const Call& call, std::span<const size_t> numbers);
  // Puts all that goes to the device in exchanged_, and returns the number of points. The coder has not seen the chunks.
  absl::StatusOr<uint64_t> Stage(const Call& call, std::span<const size_t> numbers,
                                 const Layout& layout);
  // Where packed streams go.
  struct Block {
    size_t bytes = 0;
    DeviceBuffer<uint8_t> packed;
    std::shared_ptr<const PinnedBuffer> pinned;
    kernels::StreamRoom room() const { return {packed.data(), bytes}; }
  };
  absl::StatusOr<Block> MakeBlock(size_t bytes) const;
  // Makes the block the owner of the named results.
  static void Own(const Call& call, std::span<const size_t> numbers, const Block& block);
  // The bytes of a block for so many points, a multiple of 16; 0 where there is nothing to go by.
  size_t GuessBytes(double points) const;
  // Enqueues all kernels, which pack those streams that fit in the block, and its copy to the host. When placed_ is reached,
  // exchanged_ holds the new digests and the places.
  absl::Status Code(const Layout& layout, const kernels::StreamWork& work, uint8_t* scratch,
                    const Block& block) const;
  absl::Status Pack(kernels::StreamPlaces places, const Block& block) const;
  absl::Status CopyToHost(const Block& block) const;
  absl::Status CopyToHost(void* to, const void* from, size_t bytes) const;

  std::shared_ptr<CudaContext> context_;
  std::shared_ptr<CudaLane> lane_;
  std::unique_ptr<StreamCoder> coder_;
  CudaEvent placed_;
  PinnedBuffer exchanged_;
  std::vector<size_t> all_;     // 0, 1, 2, …
  double bytes_per_point_ = 0;  // of the last round that coded any
};

}  // namespace latticed

#endif  // LATTICED_CUDA_STREAMS_DEVICE_STREAM_WRITER_H_
