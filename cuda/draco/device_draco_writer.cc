// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/draco/device_draco_writer.h"

#include <algorithm>

#include "core/base/status_macros.h"
#include "core/codec/byte_writer.h"
#include "core/codec/draco_container.h"
#include "cuda/device/cuda_status.h"
#include "cuda/device/upload_kernel.h"
#include "cuda/draco/draco_batches.h"

namespace latticed {
namespace {

constexpr std::string_view kWhat = "the encoding";

// The bytes of a stream before the symbols of its positions. Those of a cloud have no number of points yet.
std::vector<uint8_t> HeadBytes(int normal_bits, const ChunkConnectivity* triangles) {
  std::vector<uint8_t> bytes(kMostContainerBytes +
                             (triangles == nullptr ? 0 : triangles->bytes().size()));
  ByteWriter out(bytes.data());
  if (triangles == nullptr) {
    WriteCloudHead(0, normal_bits, out);
  } else {
    WriteMeshHead(triangles->bytes(), normal_bits, out);
  }
  WritePrediction(DracoAttribute::kPosition, out);
  bytes.resize(static_cast<size_t>(out.at() - bytes.data()));
  return bytes;
}

// The control, chunks, and their known digests if there are any.
size_t SentBytes(size_t chunks, bool has_digests) {
  return sizeof(kernels::DracoControl) +
         chunks * (sizeof(kernels::DracoChunk) + (has_digests ? sizeof(VertexDigest) : 0));
}
// The digests that were found, if they were looked for, and the places.
size_t FoundBytes(size_t chunks, bool has_digests) {
  return chunks * ((has_digests ? sizeof(VertexDigest) : 0) + sizeof(kernels::DracoPlace));
}

}  // namespace

absl::StatusOr<DeviceDracoWriter> DeviceDracoWriter::Create(const DracoShape& shape,
                                                            std::shared_ptr<CudaContext> context,
                                                            std::shared_ptr<CudaLane> lane) {
  std::vector<uint8_t> both = HeadBytes(shape.normal_bits, shape.connectivity[0]);
  std::array<uint32_t, 2> sizes{static_cast<uint32_t>(both.size()), 0};
  if (shape.connectivity[1] != nullptr) {
    const auto others = HeadBytes(shape.normal_bits, shape.connectivity[1]);
    both.insert(both.end(), others.begin(), others.end());
    sizes[1] = static_cast<uint32_t>(others.size());
  }
  LATTICED_ASSIGN_OR_RETURN(auto heads, DeviceBuffer<uint8_t>::Upload(
                                            context->memory(), "draco",
                                            std::span<const uint8_t>(both), lane->stream().get()));
  LATTICED_ASSIGN_OR_RETURN(auto placed, CudaEvent::Create());
  return DeviceDracoWriter(shape, std::move(context), std::move(lane), std::move(heads), sizes,
                           std::move(placed));
}

kernels::DracoFrame DeviceDracoWriter::Frame(double range) const {
  kernels::DracoFrame frame{};
  const bool is_mesh = shape_.connectivity[0] != nullptr;
  for (size_t i = 0; i < 2; ++i) {
    const size_t head = is_mesh ? i : 0;
    const ChunkConnectivity* triangles = shape_.connectivity[i];
    frame.heads[i] = {
        .bytes = heads_.data() + (head == 0 ? 0 : head_bytes_[0]),
        .size = head_bytes_[head],
        .least_stream = is_mesh ? static_cast<uint32_t>(triangles->LeastStreamBytes()) : 0};
  }
  frame.head_points = static_cast<uint32_t>(shape_.mesh_points);
  frame.points_at = is_mesh ? 0 : static_cast<uint32_t>(kDracoHeaderBytes);
  ByteWriter prediction(frame.normal_prediction);
  WritePrediction(DracoAttribute::kNormal, prediction);
  ByteWriter end(frame.end);
  if (shape_.normal_bits > 0) WriteNormalBounds(shape_.normal_bits, end);
  WriteDequantisation(shape_.position_bits, shape_.normal_bits, static_cast<float>(range), end);
  frame.end_size = static_cast<uint32_t>(end.at() - frame.end);
  return frame;
}

absl::Status DeviceDracoWriter::CopyToHost(void* to, const void* from, size_t bytes) const {
  return CudaStatus(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, lane_->stream().get()),
                    kWhat);
}

absl::Status DeviceDracoWriter::CopyToHost(const Block& block) const {
  if (block.bytes == 0) return absl::OkStatus();
  return CopyToHost(block.pinned->data(), block.packed.data(), block.bytes);
}

size_t DeviceDracoWriter::PinnedBytesFor(size_t chunks) {
  const size_t batch = std::min(chunks, kMostDracoChunks);
  return PinnedMemory::BlockBytes(SentBytes(batch, true) + FoundBytes(batch, true));
}

absl::Status DeviceDracoWriter::Stage(const Call& call, std::span<const size_t> numbers,
                                      DracoSizes& sizes) {
  const bool has_digests = !call.digests.empty();
  const size_t bytes =
      SentBytes(numbers.size(), has_digests) + FoundBytes(numbers.size(), has_digests);
  if (exchanged_.size() < bytes) {
    LATTICED_ASSIGN_OR_RETURN(exchanged_, context_->pinned().Borrow(bytes));
  }
  uint8_t* const at = exchanged_.data();
  std::fill_n(at, sizeof(kernels::DracoControl), uint8_t{0});
  auto* chunks = reinterpret_cast<kernels::DracoChunk*>(at + sizeof(kernels::DracoControl));
  DracoSizes sum = sizes;  // in registers
  for (const size_t i : numbers) {
    const Chunk& chunk = call.chunks[i];
    *chunks++ = {.first_point = chunk.first_point,
                 .points = chunk.points,
                 .first_group = sum.Add(chunk.points)};
  }
  sizes = sum;
  if (!has_digests) return absl::OkStatus();
  auto* digests = reinterpret_cast<VertexDigest*>(chunks);
  for (const size_t i : numbers) *digests++ = call.digests[i];
  return absl::OkStatus();
}

absl::Status DeviceDracoWriter::Code(const kernels::DracoWork& work,
                                     const kernels::DracoFrame& frame, kernels::DracoPlace* places,
                                     const Block& block) const {
  const cudaStream_t stream = lane_->stream().get();
  const bool has_digests = work.digests != nullptr;
  const size_t sent = SentBytes(work.count, has_digests);
  // By a kernel: between kernels, a copy engine takes 20 us for this.
  auto send = kernels::UploadCall(exchanged_.data(), sent, work.control);
  LATTICED_RETURN_IF_ERROR(CudaStatus(send.Launch(stream), kWhat));
  for (const auto launch : {kernels::LaunchDracoDigests, kernels::LaunchDracoRanked,
                            kernels::LaunchDracoSymbols, kernels::LaunchDracoRans}) {
    LATTICED_RETURN_IF_ERROR(CudaStatus(launch(work, stream), kWhat));
  }
  LATTICED_RETURN_IF_ERROR(
      CudaStatus(kernels::LaunchDracoPack(work, frame, kernels::DracoPlaces::kFind, places,
                                          block.room(), stream),
                 kWhat));
  // The digests that were found lie before the places.
  const size_t digest_bytes = has_digests ? work.count * sizeof(VertexDigest) : 0;
  LATTICED_RETURN_IF_ERROR(CopyToHost(exchanged_.data() + sent,
                                      reinterpret_cast<const uint8_t*>(places) - digest_bytes,
                                      FoundBytes(work.count, has_digests)));
  LATTICED_RETURN_IF_ERROR(placed_.Record(stream));
  return CopyToHost(block);
}

absl::StatusOr<DeviceDracoWriter::Block> DeviceDracoWriter::MakeBlock(size_t bytes) const {
  Block block{.bytes = bytes, .packed = {}, .pinned = nullptr};
  if (bytes == 0) return block;
  LATTICED_ASSIGN_OR_RETURN(
      block.packed,
      DeviceBuffer<uint8_t>::Create(context_->memory(), "draco", bytes, lane_->stream().get()));
  LATTICED_ASSIGN_OR_RETURN(auto pinned, context_->pinned().Borrow(bytes));
  block.pinned = std::make_shared<const PinnedBuffer>(std::move(pinned));
  return block;
}

void DeviceDracoWriter::Own(const Call& call, std::span<const size_t> numbers, const Block& block) {
  for (const size_t i : numbers) call.results[i].owner = block.pinned;
}

size_t DeviceDracoWriter::GuessBytes(double points) const {
  constexpr double kMore = 1 + 1.0 / 16;
  return kernels::RoundUpTo16(static_cast<size_t>(kMore * bytes_per_point_ * points));
}

absl::StatusOr<std::vector<size_t>> DeviceDracoWriter::Round(const Call& call,
                                                             std::span<const size_t> numbers) {
  const bool has_digests = !call.digests.empty();
  kernels::DracoWork work{.vertices = call.vertices.data,
                          .position_bits = shape_.position_bits,
                          .normal_bits = shape_.normal_bits,
                          .sparse = shape_.is_sparse};
  DracoSizes sizes(work);
  LATTICED_RETURN_IF_ERROR(Stage(call, numbers, sizes));
  LATTICED_ASSIGN_OR_RETURN(const auto scratch,
                            MakeDracoScratch(*context_, lane_->stream().get(), call.entry_room,
                                             has_digests, sizes, work));
  const auto points = static_cast<double>(sizes.points());
  LATTICED_ASSIGN_OR_RETURN(Block block, MakeBlock(GuessBytes(points)));
  std::vector<size_t> deferred;
  // From here on nothing throws: the block must stay until the copy is done.
  deferred.reserve(numbers.size());
  LATTICED_RETURN_IF_ERROR(Code(work, call.frame, scratch.places, block));
  Own(call, numbers, block);
  LATTICED_RETURN_IF_ERROR(placed_.Synchronize());

  const auto* const found = reinterpret_cast<const VertexDigest*>(
      exchanged_.data() + SentBytes(numbers.size(), has_digests));
  const std::span places(
      reinterpret_cast<const kernels::DracoPlace*>(found + (has_digests ? numbers.size() : 0)),
      numbers.size());
  size_t bytes = 0;
  for (const kernels::DracoPlace& place : places) {
    bytes = std::max(bytes, place.at + kernels::RoundUpTo16(place.size));
  }
  if (bytes > 0) bytes_per_point_ = static_cast<double>(bytes) / points;
  if (bytes > block.bytes) {
    LATTICED_RETURN_IF_ERROR(lane_->stream().Synchronize(kWhat));  // for the copy to the old block
    LATTICED_ASSIGN_OR_RETURN(block, MakeBlock(bytes));
    LATTICED_RETURN_IF_ERROR(
        CudaStatus(kernels::LaunchDracoPack(work, call.frame, kernels::DracoPlaces::kKnown,
                                            scratch.places, block.room(), lane_->stream().get()),
                   kWhat));
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

absl::Status DeviceDracoWriter::Encode(DeviceSpan<const uint8_t> vertices,
                                       std::span<const Chunk> chunks, double range,
                                       std::span<VertexDigest> digests,
                                       std::span<SharedBytes> results, uint32_t entry_room) {
  const Call call{vertices, chunks, Frame(range), digests, results, entry_room};
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
