// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes the streams of chunks on the device, from vertices that are there. A StreamCoder knows the codec. Only the bytes
// cross the bus, in one copy for all chunks of a round. Each result is a part of a copied block. Chunks may have any numbers
// of points.
//
//   chunks, known digests        <-- host
//   digests | coding | packing   --> host: sizes and places, bytes
//
// Where many bytes are expected, chunks are encoded in parts, each on a stream of its own. The bytes of the first parts cross
// the bus, and the host names their results, while the last one is encoded. Where there are few, the host would take longer to
// launch more kernels.
//
// The host does not wait for the sizes before it asks for the bytes. It guesses their number from the last streams, asks
// for a sixteenth more, and names the results while they are copied. It takes the larger number of the last two rounds,
// because edits often alternate. Streams that need more are packed and copied again.
// What it can do for the results before it knows the sizes, it does while the device encodes.
//
// Errors   kResourceExhausted for device or pinned memory, of which fewer chunks take less; those
//          of cuda_status.h
// Threads  one at a time; works on the stream of the lane and, for parts, on others, and waits for all before it returns
#ifndef LATTICED_CUDA_STREAMS_DEVICE_STREAM_WRITER_H_
#define LATTICED_CUDA_STREAMS_DEVICE_STREAM_WRITER_H_

#include <array>
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
  // The fewest bytes of a part. To copy them, and to name their results, takes as long as to launch another part.
  static constexpr size_t kPartBytes = size_t{1} << 20;
  static constexpr size_t kMostParts = 4;

  [[nodiscard]] static absl::StatusOr<DeviceStreamWriter> Create(
      std::unique_ptr<StreamCoder> coder, std::shared_ptr<CudaContext> context,
      std::shared_ptr<CudaLane> lane, size_t part_bytes = kPartBytes);

  // A chunk in wire layout, among the points of all vertices.
  struct Chunk {
    uint64_t first_point = 0;
    uint32_t points = 0;  // 1 or more
  };
  // Sets results[i] and digests[i] of chunks[i], as DeformView::Encode says. After an error the digests are as they were.
  // `range`: that of the quantisation box. kInternal where the coder has no room even for one chunk.
  [[nodiscard]] absl::Status Encode(DeviceSpan<const uint8_t> vertices,
                                    std::span<const Chunk> chunks, double range,
                                    std::span<VertexDigest> digests, std::span<SharedBytes> results,
                                    TakeEarly early = TakeNothing);

  // The most pinned bytes that a view of so many chunks takes, but for the results.
  static size_t PinnedBytesFor(size_t chunks);
  std::string_view purpose() const { return coder_->purpose(); }
  size_t DeviceBytes() const { return coder_->DeviceBytes(); }
  size_t PinnedBytes() const;

 private:
  // What a round needs while it is on its way. The first slot has the lane of the writer. The others, which are made when
  // they are first needed, have lanes of higher priority. They take the first parts, so that their bytes are ready early.
  struct Slot {
    std::shared_ptr<CudaLane> lane;
    CudaEvent placed;
    PinnedBuffer exchanged;
    std::array<double, 2> bytes_per_point = {};  // of its last two rounds that coded any
    cudaStream_t stream() const { return lane->stream().get(); }
  };
  DeviceStreamWriter(std::unique_ptr<StreamCoder> coder, std::shared_ptr<CudaContext> context,
                     std::vector<Slot> slots, CudaEvent ready, size_t part_bytes)
      : context_(std::move(context)),
        coder_(std::move(coder)),
        slots_(std::move(slots)),
        ready_(std::move(ready)),
        part_bytes_(part_bytes) {}

  // The arguments of Encode.
  struct Call {
    DeviceSpan<const uint8_t> vertices;
    std::span<const Chunk> chunks;
    std::span<VertexDigest> digests;
    std::span<SharedBytes> results;
    TakeEarly early;
  };
  // Where the parts of a round begin, in Slot::exchanged and on the device. The control comes first. All that is before `found`
  // goes to the device, and the rest comes back.
  struct Layout {
    Layout(size_t count, size_t zeros, bool has_digests);
    size_t chunks, known, found, places, end;
  };
  // Where packed streams go.
  struct Block {
    size_t bytes = 0;
    DeviceBuffer<uint8_t> packed;
    std::shared_ptr<const PinnedBuffer> pinned;
    kernels::StreamRoom room() const { return {packed.data(), bytes}; }
  };
  // Chunks that are on their way. `numbers`: their places in call.chunks.
  struct Round {
    Slot* slot;
    std::span<const size_t> numbers;
    Layout layout;
    double points;
    DeviceBuffer<uint8_t> memory;
    Block block;
    std::vector<size_t> deferred;  // has room for all
  };
  // Enqueues a round.
  absl::StatusOr<Round> Begin(const Call& call, std::span<const size_t> numbers, Slot& slot);
  // Waits for it, names the results, and calls `early` while their bytes are on their way. Round::deferred then has the
  // chunks for which the coder has no room. Where the streams do not fit in the block, they are packed again if the coder
  // still describes this round, the one begun last; else deferred.
  absl::Status Finish(const Call& call, Round& round, bool is_last_begun);
  // Whatever fails, the memory of rounds must stay until what is on its way has ended.
  void WaitForRounds() const;
  absl::Status MakeSlots(size_t count);
  // How many parts they are worth; 1 where nothing says how many bytes there will be.
  size_t PartsOf(const Call& call, std::span<const size_t> numbers) const;
  // Encodes `numbers` in so many rounds at once. Returns those that are deferred.
  absl::StatusOr<std::vector<size_t>> InParts(const Call& call, std::span<const size_t> numbers,
                                              size_t parts);
  // Puts all that goes to the device in slot.exchanged, and returns the number of points. The coder has not seen the chunks.
  absl::StatusOr<uint64_t> Stage(const Call& call, std::span<const size_t> numbers,
                                 const Layout& layout, Slot& slot);
  absl::StatusOr<Block> MakeBlock(size_t bytes, const Slot& slot) const;
  // Makes the block the owner of the named results.
  static void Own(const Call& call, std::span<const size_t> numbers, const Block& block);
  // The bytes of a block for so many points, a multiple of 16; 0 where there is nothing to go by.
  size_t GuessBytes(double points, const Slot& slot) const;
  // Enqueues all kernels, which pack those streams that fit in the block, and its copy to the host. When slot.placed is
  // reached, slot.exchanged holds the new digests and the places.
  absl::Status Code(const Layout& layout, const kernels::StreamWork& work, uint8_t* scratch,
                    const Block& block, const Slot& slot) const;
  absl::Status Pack(kernels::StreamPlaces places, const Block& block, const Slot& slot) const;

  std::shared_ptr<CudaContext> context_;
  std::unique_ptr<StreamCoder> coder_;
  std::vector<Slot> slots_;  // kMostParts at most
  CudaEvent ready_;          // the vertices
  size_t part_bytes_;
  std::vector<size_t> all_;          // 0, 1, 2, …
  std::vector<VertexDigest> found_;  // of this call's chunks
};

}  // namespace latticed

#endif  // LATTICED_CUDA_STREAMS_DEVICE_STREAM_WRITER_H_
