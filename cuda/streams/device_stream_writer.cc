// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/streams/device_stream_writer.h"

#include <algorithm>

#include "core/base/status_macros.h"
#include "cuda/device/cuda_status.h"
#include "cuda/device/upload_kernel.h"
#include "cuda/streams/stream_batches.h"

namespace latticed {
namespace {

using kernels::StreamChunk;
using kernels::StreamControl;
using kernels::StreamPlace;

constexpr std::string_view kWhat = "the encoding";

static_assert(sizeof(StreamControl) % 16 == 0 && sizeof(StreamChunk) == 16 &&
                  sizeof(kernels::StreamDigest) == 16 && sizeof(VertexDigest) == 16,
              "parts lie one after the other, without gaps");

}  // namespace

absl::StatusOr<DeviceStreamWriter> DeviceStreamWriter::Create(std::unique_ptr<StreamCoder> coder,
                                                              std::shared_ptr<CudaContext> context,
                                                              std::shared_ptr<CudaLane> lane) {
  LATTICED_ASSIGN_OR_RETURN(auto placed, CudaEvent::Create());
  return DeviceStreamWriter(std::move(coder), std::move(context), std::move(lane),
                            std::move(placed));
}

DeviceStreamWriter::Layout::Layout(size_t count, size_t zeros, bool has_digests)
    : chunks(sizeof(StreamControl) + zeros),
      known(chunks + count * sizeof(StreamChunk)),
      found(known + (has_digests ? count * sizeof(VertexDigest) : 0)),
      places(found + (found - known)),
      end(places + count * sizeof(StreamPlace)) {}

absl::Status DeviceStreamWriter::CopyToHost(void* to, const void* from, size_t bytes) const {
  return CudaStatus(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, lane_->stream().get()),
                    kWhat);
}

absl::Status DeviceStreamWriter::CopyToHost(const Block& block) const {
  if (block.bytes == 0) return absl::OkStatus();
  return CopyToHost(block.pinned->data(), block.packed.data(), block.bytes);
}

size_t DeviceStreamWriter::PinnedBytesFor(size_t chunks) {
  const size_t batch = std::min(chunks, kMostStreamChunks);
  return PinnedMemory::BlockBytes(Layout(batch, StreamCoder::kMostZeros, true).end);
}

absl::StatusOr<uint64_t> DeviceStreamWriter::Stage(const Call& call,
                                                   std::span<const size_t> numbers,
                                                   const Layout& layout) {
  if (exchanged_.size() < layout.end) {
    LATTICED_ASSIGN_OR_RETURN(exchanged_, context_->pinned().Borrow(layout.end));
  }
  uint8_t* const at = exchanged_.data();
  std::fill_n(at, layout.chunks, uint8_t{0});
  auto* chunks = reinterpret_cast<StreamChunk*>(at + layout.chunks);
  uint64_t points = 0;
  for (const size_t i : numbers) {
    const Chunk& chunk = call.chunks[i];
    *chunks++ = {.first_point = chunk.first_point, .points = chunk.points, .scratch_at = 0};
    points += chunk.points;
  }
  if (call.digests.empty()) return points;
  auto* digests = reinterpret_cast<VertexDigest*>(at + layout.known);
  for (const size_t i : numbers) *digests++ = call.digests[i];
  return points;
}

absl::Status DeviceStreamWriter::Pack(kernels::StreamPlaces places, const Block& block) const {
  return CudaStatus(coder_->Pack(places, block.room(), lane_->stream().get()), kWhat);
}

absl::Status DeviceStreamWriter::Code(const Layout& layout, const kernels::StreamWork& work,
                                      uint8_t* scratch, const Block& block) const {
  const cudaStream_t stream = lane_->stream().get();
  // By a kernel: between kernels, a copy engine takes 20 us for this.
  auto send = kernels::UploadCall(exchanged_.data(), layout.found, work.control);
  LATTICED_RETURN_IF_ERROR(CudaStatus(send.Launch(stream), kWhat));
  LATTICED_RETURN_IF_ERROR(CudaStatus(kernels::LaunchStreamDigests(work, stream), kWhat));
  LATTICED_RETURN_IF_ERROR(CudaStatus(coder_->Code(work, scratch, stream), kWhat));
  LATTICED_RETURN_IF_ERROR(Pack(kernels::StreamPlaces::kFind, block));
  LATTICED_RETURN_IF_ERROR(CopyToHost(exchanged_.data() + layout.found,
                                      reinterpret_cast<const uint8_t*>(work.control) + layout.found,
                                      layout.end - layout.found));
  LATTICED_RETURN_IF_ERROR(placed_.Record(stream));
  return CopyToHost(block);
}

absl::StatusOr<DeviceStreamWriter::Block> DeviceStreamWriter::MakeBlock(size_t bytes) const {
  Block block{.bytes = bytes, .packed = {}, .pinned = nullptr};
  if (bytes == 0) return block;
  LATTICED_ASSIGN_OR_RETURN(
      block.packed, DeviceBuffer<uint8_t>::Create(context_->memory(), coder_->purpose(), bytes,
                                                  lane_->stream().get()));
  LATTICED_ASSIGN_OR_RETURN(auto pinned, context_->pinned().Borrow(bytes));
  block.pinned = std::make_shared<const PinnedBuffer>(std::move(pinned));
  return block;
}

void DeviceStreamWriter::Own(const Call& call, std::span<const size_t> numbers,
                             const Block& block) {
  for (const size_t i : numbers) call.results[i].owner = block.pinned;
}

size_t DeviceStreamWriter::GuessBytes(double points) const {
  constexpr double kMore = 1 + 1.0 / 16;
  return kernels::RoundUpTo16(static_cast<size_t>(kMore * bytes_per_point_ * points));
}

absl::StatusOr<std::vector<size_t>> DeviceStreamWriter::Round(const Call& call,
                                                              std::span<const size_t> numbers) {
  const bool has_digests = !call.digests.empty();
  const Layout layout(numbers.size(), coder_->zeros(), has_digests);
  LATTICED_ASSIGN_OR_RETURN(const uint64_t all_points, Stage(call, numbers, layout));
  const auto points = static_cast<double>(all_points);
  const size_t scratch_at = kernels::RoundUpTo16(layout.end);
  const size_t scratch_bytes = coder_->Plan(
      {reinterpret_cast<StreamChunk*>(exchanged_.data() + layout.chunks), numbers.size()});
  LATTICED_ASSIGN_OR_RETURN(
      const auto memory,
      DeviceBuffer<uint8_t>::Create(context_->memory(), coder_->purpose(),
                                    scratch_at + scratch_bytes, lane_->stream().get()));
  uint8_t* const at = memory.data();
  const kernels::StreamWork work{
      .vertices = call.vertices.data,
      .chunks = reinterpret_cast<const StreamChunk*>(at + layout.chunks),
      .count = static_cast<uint32_t>(numbers.size()),
      .normal_bits = coder_->normal_bits(),
      .control = reinterpret_cast<StreamControl*>(at),
      .digests =
          has_digests ? reinterpret_cast<kernels::StreamDigest*>(at + layout.known) : nullptr,
      .places = reinterpret_cast<StreamPlace*>(at + layout.places)};
  LATTICED_ASSIGN_OR_RETURN(Block block, MakeBlock(GuessBytes(points)));
  std::vector<size_t> deferred;
  // From here on nothing throws: the block must stay until the copy is done.
  deferred.reserve(numbers.size());
  LATTICED_RETURN_IF_ERROR(Code(layout, work, at + scratch_at, block));
  Own(call, numbers, block);
  LATTICED_RETURN_IF_ERROR(placed_.Synchronize());

  const auto* const found = reinterpret_cast<const VertexDigest*>(exchanged_.data() + layout.found);
  const std::span places(reinterpret_cast<const StreamPlace*>(exchanged_.data() + layout.places),
                         numbers.size());
  size_t bytes = 0;
  for (const StreamPlace& place : places) {
    bytes = std::max(bytes, place.at + kernels::RoundUpTo16(place.size));
  }
  if (bytes > 0) bytes_per_point_ = static_cast<double>(bytes) / points;
  if (bytes > block.bytes) {
    LATTICED_RETURN_IF_ERROR(lane_->stream().Synchronize(kWhat));  // for the copy to the old block
    LATTICED_ASSIGN_OR_RETURN(block, MakeBlock(bytes));
    LATTICED_RETURN_IF_ERROR(Pack(kernels::StreamPlaces::kKnown, block));
    LATTICED_RETURN_IF_ERROR(CopyToHost(block));
    Own(call, numbers, block);
  }
  for (size_t k = 0; k < numbers.size(); ++k) {
    const size_t i = numbers[k];
    SharedBytes& result = call.results[i];
    if (places[k].size > 0) {
      result.data = block.pinned->data() + places[k].at;
      result.size = places[k].size;
      result.block_bytes = block.pinned->size();
    } else {
      result = {};
      if (!has_digests || found[k] != call.digests[i]) {
        deferred.push_back(i);
        continue;
      }
    }
    if (has_digests) call.digests[i] = found[k];
  }
  // The results were named while the bytes were on their way.
  LATTICED_RETURN_IF_ERROR(lane_->stream().Synchronize(kWhat));
  return deferred;
}

absl::Status DeviceStreamWriter::Encode(DeviceSpan<const uint8_t> vertices,
                                        std::span<const Chunk> chunks, double range,
                                        std::span<VertexDigest> digests,
                                        std::span<SharedBytes> results) {
  coder_->SetRange(range);
  const Call call{vertices, chunks, digests, results};
  for (size_t i = all_.size(); i < chunks.size(); ++i) all_.push_back(i);
  std::span<const size_t> left = std::span(all_).first(chunks.size());
  for (std::vector<size_t> deferred; !left.empty(); left = deferred) {
    LATTICED_ASSIGN_OR_RETURN(auto again, Round(call, left));
    if (again.size() == left.size()) {
      return absl::InternalError("a chunk's integers have more bits than its view");
    }
    deferred = std::move(again);
  }
  return absl::OkStatus();
}

}  // namespace latticed
