// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/streams/device_stream_writer.h"

#include <algorithm>

#include "absl/cleanup/cleanup.h"
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

absl::Status CopyToHost(void* to, const void* from, size_t bytes, cudaStream_t stream) {
  return CudaStatus(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, stream), kWhat);
}

}  // namespace

absl::StatusOr<DeviceStreamWriter> DeviceStreamWriter::Create(std::unique_ptr<StreamCoder> coder,
                                                              std::shared_ptr<CudaContext> context,
                                                              std::shared_ptr<CudaLane> lane,
                                                              size_t part_bytes) {
  LATTICED_ASSIGN_OR_RETURN(auto ready, CudaEvent::Create());
  LATTICED_ASSIGN_OR_RETURN(auto placed, CudaEvent::Create());
  std::vector<Slot> slots;
  slots.push_back({std::move(lane), std::move(placed), {}});
  return DeviceStreamWriter(std::move(coder), std::move(context), std::move(slots),
                            std::move(ready), part_bytes);
}

DeviceStreamWriter::Layout::Layout(size_t count, size_t zeros, bool has_digests)
    : chunks(sizeof(StreamControl) + zeros),
      known(chunks + count * sizeof(StreamChunk)),
      found(known + (has_digests ? count * sizeof(VertexDigest) : 0)),
      places(found + (found - known)),
      end(places + count * sizeof(StreamPlace)) {}

size_t DeviceStreamWriter::PinnedBytesFor(size_t chunks) {
  const size_t batch = std::min(chunks, kMostStreamChunks);
  const auto bytes = [](size_t count) {
    return PinnedMemory::BlockBytes(Layout(count, StreamCoder::kMostZeros, true).end);
  };
  return bytes(batch) + (kMostParts - 1) * bytes((batch + 1) / 2);
}

absl::Status DeviceStreamWriter::MakeSlots(size_t count) {
  while (slots_.size() < count) {
    LATTICED_ASSIGN_OR_RETURN(auto lane, context_->lanes().Borrow(StreamPriority::kMiddle));
    LATTICED_ASSIGN_OR_RETURN(auto placed, CudaEvent::Create());
    slots_.push_back({std::move(lane), std::move(placed), {}});
  }
  return absl::OkStatus();
}

size_t DeviceStreamWriter::PinnedBytes() const {
  size_t bytes = 0;
  for (const Slot& slot : slots_) bytes += slot.exchanged.size();
  return bytes;
}

absl::StatusOr<uint64_t> DeviceStreamWriter::Stage(const Call& call,
                                                   std::span<const size_t> numbers,
                                                   const Layout& layout, Slot& slot) {
  if (slot.exchanged.size() < layout.end) {
    LATTICED_ASSIGN_OR_RETURN(slot.exchanged, context_->pinned().Borrow(layout.end));
  }
  uint8_t* const at = slot.exchanged.data();
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

absl::Status DeviceStreamWriter::Pack(kernels::StreamPlaces places, const Block& block,
                                      const Slot& slot) const {
  return CudaStatus(coder_->Pack(places, block.room(), slot.stream()), kWhat);
}

absl::Status DeviceStreamWriter::Code(const Layout& layout, const kernels::StreamWork& work,
                                      uint8_t* scratch, const Block& block,
                                      const Slot& slot) const {
  const cudaStream_t stream = slot.stream();
  uint8_t* const exchanged = slot.exchanged.data();
  // By a kernel: between kernels, a copy engine takes 20 us for this.
  auto send = kernels::UploadCall(exchanged, layout.found, work.control);
  LATTICED_RETURN_IF_ERROR(CudaStatus(send.Launch(stream), kWhat));
  LATTICED_RETURN_IF_ERROR(CudaStatus(kernels::LaunchStreamDigests(work, stream), kWhat));
  LATTICED_RETURN_IF_ERROR(CudaStatus(coder_->Code(work, scratch, stream), kWhat));
  LATTICED_RETURN_IF_ERROR(Pack(kernels::StreamPlaces::kFind, block, slot));
  LATTICED_RETURN_IF_ERROR(CopyToHost(exchanged + layout.found,
                                      reinterpret_cast<const uint8_t*>(work.control) + layout.found,
                                      layout.end - layout.found, stream));
  LATTICED_RETURN_IF_ERROR(slot.placed.Record(stream));
  return block.bytes == 0
             ? absl::OkStatus()
             : CopyToHost(block.pinned->data(), block.packed.data(), block.bytes, stream);
}

absl::StatusOr<DeviceStreamWriter::Block> DeviceStreamWriter::MakeBlock(size_t bytes,
                                                                        const Slot& slot) const {
  Block block{.bytes = bytes, .packed = {}, .pinned = nullptr};
  if (bytes == 0) return block;
  LATTICED_ASSIGN_OR_RETURN(
      block.packed,
      DeviceBuffer<uint8_t>::Create(context_->memory(), coder_->purpose(), bytes, slot.stream()));
  LATTICED_ASSIGN_OR_RETURN(auto pinned, context_->pinned().Borrow(bytes));
  block.pinned = std::make_shared<const PinnedBuffer>(std::move(pinned));
  return block;
}

void DeviceStreamWriter::Own(const Call& call, std::span<const size_t> numbers,
                             const Block& block) {
  for (const size_t i : numbers) call.results[i].owner = block.pinned;
}

size_t DeviceStreamWriter::GuessBytes(double points, const Slot& slot) const {
  constexpr double kMore = 1 + 1.0 / 16;
  // A slot of parts may not have been used for long.
  const double bytes =
      std::max(std::ranges::max(slot.bytes_per_point), std::ranges::max(slots_[0].bytes_per_point));
  return kernels::RoundUpTo16(static_cast<size_t>(kMore * bytes * points));
}

absl::StatusOr<DeviceStreamWriter::Round> DeviceStreamWriter::Begin(const Call& call,
                                                                    std::span<const size_t> numbers,
                                                                    Slot& slot) {
  const bool has_digests = !call.digests.empty();
  const Layout layout(numbers.size(), coder_->zeros(), has_digests);
  LATTICED_ASSIGN_OR_RETURN(const uint64_t points, Stage(call, numbers, layout, slot));
  const size_t scratch_at = kernels::RoundUpTo16(layout.end);
  const size_t scratch_bytes = coder_->Plan(
      {reinterpret_cast<StreamChunk*>(slot.exchanged.data() + layout.chunks), numbers.size()});
  LATTICED_ASSIGN_OR_RETURN(
      auto memory, DeviceBuffer<uint8_t>::Create(context_->memory(), coder_->purpose(),
                                                 scratch_at + scratch_bytes, slot.stream()));
  LATTICED_ASSIGN_OR_RETURN(Block block,
                            MakeBlock(GuessBytes(static_cast<double>(points), slot), slot));
  Round round{.slot = &slot,
              .numbers = numbers,
              .layout = layout,
              .points = static_cast<double>(points),
              .memory = std::move(memory),
              .block = std::move(block),
              .deferred = {}};
  round.deferred.reserve(numbers.size());
  uint8_t* const at = round.memory.data();
  const kernels::StreamWork work{
      .vertices = call.vertices.data,
      .chunks = reinterpret_cast<const StreamChunk*>(at + layout.chunks),
      .count = static_cast<uint32_t>(numbers.size()),
      .normal_bits = coder_->normal_bits(),
      .control = reinterpret_cast<StreamControl*>(at),
      .digests =
          has_digests ? reinterpret_cast<kernels::StreamDigest*>(at + layout.known) : nullptr,
      .places = reinterpret_cast<StreamPlace*>(at + layout.places)};
  LATTICED_RETURN_IF_ERROR(Code(layout, work, at + scratch_at, round.block, slot));
  return round;
}

absl::Status DeviceStreamWriter::Finish(const Call& call, Round& round, bool is_last_begun) {
  Slot& slot = *round.slot;
  const std::span<const size_t> numbers = round.numbers;
  Block& block = round.block;
  Own(call, numbers, block);
  LATTICED_RETURN_IF_ERROR(slot.placed.Synchronize());

  const uint8_t* const exchanged = slot.exchanged.data();
  const auto* const found = reinterpret_cast<const VertexDigest*>(exchanged + round.layout.found);
  const std::span places(reinterpret_cast<const StreamPlace*>(exchanged + round.layout.places),
                         numbers.size());
  size_t bytes = 0;
  for (const StreamPlace& place : places) {
    bytes = std::max(bytes, place.at + kernels::RoundUpTo16(place.size));
  }
  if (bytes > 0) {
    slot.bytes_per_point = {static_cast<double>(bytes) / round.points, slot.bytes_per_point[0]};
  }
  const bool fits = bytes <= block.bytes;
  if (!fits && is_last_begun) {
    LATTICED_RETURN_IF_ERROR(
        slot.lane->stream().Synchronize(kWhat));  // for the copy to the old block
    LATTICED_ASSIGN_OR_RETURN(block, MakeBlock(bytes, slot));
    LATTICED_RETURN_IF_ERROR(Pack(kernels::StreamPlaces::kKnown, block, slot));
    LATTICED_RETURN_IF_ERROR(
        CopyToHost(block.pinned->data(), block.packed.data(), block.bytes, slot.stream()));
    Own(call, numbers, block);
  }
  const bool has_digests = !call.digests.empty();
  for (size_t k = 0; k < numbers.size(); ++k) {
    const size_t i = numbers[k];
    SharedBytes& result = call.results[i];
    if (places[k].size > 0 && (fits || is_last_begun)) {
      result.data = block.pinned->data() + places[k].at;
      result.size = places[k].size;
      result.block_bytes = block.pinned->size();
    } else {
      result = {};
      if (!has_digests || found[k] != call.digests[i]) {
        round.deferred.push_back(i);
        continue;
      }
    }
    if (has_digests) found_[i] = found[k];
  }
  const size_t first = numbers.front();
  const bool is_range = numbers.back() - first + 1 == numbers.size();
  if (has_digests && is_range && round.deferred.empty()) {
    call.early(first, call.results.subspan(first, numbers.size()),
               std::span(found_).subspan(first, numbers.size()));
  }
  return slot.lane->stream().Synchronize(kWhat);
}

void DeviceStreamWriter::WaitForRounds() const {
  for (const Slot& slot : slots_) static_cast<void>(slot.lane->stream().Synchronize(kWhat));
}

size_t DeviceStreamWriter::PartsOf(const Call& call, std::span<const size_t> numbers) const {
  double points = 0;
  for (const size_t i : numbers) points += call.chunks[i].points;
  const size_t worth = GuessBytes(points, slots_[0]) / part_bytes_;
  return std::clamp<size_t>(worth, 1, std::min(kMostParts, numbers.size()));
}

absl::StatusOr<std::vector<size_t>> DeviceStreamWriter::InParts(const Call& call,
                                                                std::span<const size_t> numbers,
                                                                size_t parts) {
  LATTICED_RETURN_IF_ERROR(MakeSlots(parts));
  std::vector<Round> rounds;
  rounds.reserve(parts);
  absl::Cleanup wait = [this] { WaitForRounds(); };
  if (parts > 1) LATTICED_RETURN_IF_ERROR(ready_.Record(slots_[0].stream()));
  for (size_t k = 0, first = 0; k < parts; ++k) {
    const bool is_last = k + 1 == parts;
    Slot& slot = slots_[is_last ? 0 : k + 1];
    if (!is_last) LATTICED_RETURN_IF_ERROR(ready_.HoldBack(slot.stream()));
    const size_t last = numbers.size() * (k + 1) / parts;
    LATTICED_ASSIGN_OR_RETURN(auto round, Begin(call, numbers.subspan(first, last - first), slot));
    rounds.push_back(std::move(round));
    first = last;
  }
  std::vector<size_t> deferred;
  for (Round& round : rounds) {
    LATTICED_RETURN_IF_ERROR(Finish(call, round, /*is_last_begun=*/&round == &rounds.back()));
    deferred.insert(deferred.end(), round.deferred.begin(), round.deferred.end());
  }
  std::move(wait).Cancel();
  return deferred;
}

absl::Status DeviceStreamWriter::Encode(DeviceSpan<const uint8_t> vertices,
                                        std::span<const Chunk> chunks, double range,
                                        std::span<VertexDigest> digests,
                                        std::span<SharedBytes> results, TakeEarly early) {
  coder_->SetRange(range);
  const Call call{vertices, chunks, digests, results, early};
  for (size_t i = all_.size(); i < chunks.size(); ++i) all_.push_back(i);
  found_.resize(digests.size());
  std::span<const size_t> left = std::span(all_).first(chunks.size());
  bool stuck = false;  // the last turn of the loop encoded nothing
  for (std::vector<size_t> deferred; !left.empty(); left = deferred) {
    const size_t parts = stuck ? 1 : PartsOf(call, left);
    LATTICED_ASSIGN_OR_RETURN(auto again, InParts(call, left, parts));
    stuck = again.size() == left.size();
    if (stuck && parts == 1) {
      return absl::InternalError("a chunk's integers have more bits than its view");
    }
    deferred = std::move(again);
  }
  std::ranges::copy(found_, digests.begin());
  return absl::OkStatus();
}

}  // namespace latticed
