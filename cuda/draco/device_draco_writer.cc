// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/draco/device_draco_writer.h"

#include <cstring>
#include <numeric>

#include "core/base/status_macros.h"
#include "core/codec/byte_writer.h"
#include "core/codec/draco_container.h"
#include "cuda/device/cuda_status.h"
#include "cuda/draco/draco_scratch.h"

namespace latticed {
namespace {

constexpr std::string_view kWhat = "the encoding";

// The bytes of a stream before the symbols of its positions.
std::vector<uint8_t> HeadBytes(size_t points, int normal_bits, const ChunkConnectivity* triangles) {
  std::vector<uint8_t> bytes(kMostContainerBytes +
                             (triangles == nullptr ? 0 : triangles->bytes().size()));
  ByteWriter out(bytes.data());
  if (triangles == nullptr) {
    WriteCloudHead(points, normal_bits, out);
  } else {
    WriteMeshHead(triangles->bytes(), normal_bits, out);
  }
  WritePrediction(DracoAttribute::kPosition, out);
  bytes.resize(static_cast<size_t>(out.at() - bytes.data()));
  return bytes;
}

bool AreAll(std::span<const uint32_t> numbers) {
  return numbers.front() == 0 && numbers.back() + size_t{1} == numbers.size();
}

}  // namespace

absl::StatusOr<DeviceDracoWriter> DeviceDracoWriter::Create(const DracoShape& shape,
                                                            std::shared_ptr<CudaContext> context,
                                                            std::shared_ptr<CudaLane> lane) {
  const auto head = HeadBytes(shape.points, shape.normal_bits, shape.connectivity[0]);
  const auto last = HeadBytes(shape.last_points, shape.normal_bits, shape.connectivity[1]);
  std::vector<uint8_t> both = head;
  both.insert(both.end(), last.begin(), last.end());
  LATTICED_ASSIGN_OR_RETURN(auto heads, DeviceBuffer<uint8_t>::Upload(context->memory(), "draco",
                                                                      both, lane->stream().get()));
  return DeviceDracoWriter(
      shape, std::move(context), std::move(lane), std::move(heads),
      {static_cast<uint32_t>(head.size()), static_cast<uint32_t>(last.size())});
}

kernels::DracoFrame DeviceDracoWriter::Frame(double range) const {
  kernels::DracoFrame frame{};
  for (size_t i = 0; i < 2; ++i) {
    const ChunkConnectivity* triangles = shape_.connectivity[i];
    frame.heads[i] = {.bytes = heads_.data() + (i == 0 ? 0 : head_bytes_[0]),
                      .size = head_bytes_[i],
                      .least_stream = triangles == nullptr
                                          ? 0
                                          : static_cast<uint32_t>(triangles->LeastStreamBytes())};
  }
  ByteWriter prediction(frame.normal_prediction);
  WritePrediction(DracoAttribute::kNormal, prediction);
  ByteWriter end(frame.end);
  if (shape_.normal_bits > 0) WriteNormalBounds(shape_.normal_bits, end);
  WriteDequantisation(shape_.position_bits, shape_.normal_bits, static_cast<float>(range), end);
  frame.end_size = static_cast<uint32_t>(end.at() - frame.end);
  return frame;
}

absl::Status DeviceDracoWriter::Fetch(void* to, const void* from, size_t bytes) const {
  const cudaStream_t stream = lane_->stream().get();
  LATTICED_RETURN_IF_ERROR(
      CudaStatus(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, stream), kWhat));
  return lane_->stream().Synchronize(kWhat);
}

kernels::DracoWork DeviceDracoWriter::Work(const Vertices& vertices, const Batch& batch) const {
  return {.vertices = vertices.bytes.data,
          .count = static_cast<uint32_t>(batch.numbers.size()),
          .points = static_cast<uint32_t>(shape_.points),
          .last_chunk = vertices.last,
          .last_points = static_cast<uint32_t>(shape_.last_points),
          .position_bits = shape_.position_bits,
          .normal_bits = shape_.normal_bits};
}

absl::Status DeviceDracoWriter::Code(const kernels::DracoWork& work,
                                     const kernels::DracoFrame& frame, kernels::DracoPlace* places,
                                     const Batch& batch) {
  const cudaStream_t stream = lane_->stream().get();
  const size_t digest_bytes = batch.digests.size() * sizeof(VertexDigest),
               place_bytes = work.count * sizeof(kernels::DracoPlace);
  if (exchanged_.size() < digest_bytes + place_bytes) {
    LATTICED_ASSIGN_OR_RETURN(exchanged_, context_->pinned().Borrow(digest_bytes + place_bytes));
  }
  if (digest_bytes > 0) {
    std::memcpy(exchanged_.data(), batch.digests.data(), digest_bytes);
    LATTICED_RETURN_IF_ERROR(
        CudaStatus(cudaMemcpyAsync(work.digests, exchanged_.data(), digest_bytes,
                                   cudaMemcpyHostToDevice, stream),
                   kWhat));
  }
  for (const auto launch :
       {kernels::LaunchDracoDigests, kernels::LaunchDracoSymbols, kernels::LaunchDracoRans}) {
    LATTICED_RETURN_IF_ERROR(CudaStatus(launch(work, stream), kWhat));
  }
  LATTICED_RETURN_IF_ERROR(
      CudaStatus(kernels::LaunchDracoPlaces(work, frame, places, stream), kWhat));
  // The digests that were found lie before the places.
  const auto* from = reinterpret_cast<const uint8_t*>(places) - digest_bytes;
  return Fetch(exchanged_.data(), from, digest_bytes + place_bytes);
}

absl::StatusOr<std::shared_ptr<const PinnedBuffer>> DeviceDracoWriter::Pack(
    const kernels::DracoWork& work, const kernels::DracoFrame& frame,
    const kernels::DracoPlace* places, size_t bytes) {
  const cudaStream_t stream = lane_->stream().get();
  LATTICED_ASSIGN_OR_RETURN(
      const auto packed, DeviceBuffer<uint8_t>::Create(context_->memory(), "draco", bytes, stream));
  LATTICED_ASSIGN_OR_RETURN(auto pinned, context_->pinned().Borrow(bytes));
  LATTICED_RETURN_IF_ERROR(
      CudaStatus(kernels::LaunchDracoPack(work, frame, places, packed.data(), stream), kWhat));
  LATTICED_RETURN_IF_ERROR(Fetch(pinned.data(), packed.data(), bytes));
  return std::make_shared<const PinnedBuffer>(std::move(pinned));
}

absl::Status DeviceDracoWriter::Round(const Vertices& vertices, const kernels::DracoFrame& frame,
                                      uint32_t entry_room, Batch& batch) {
  const cudaStream_t stream = lane_->stream().get();
  kernels::DracoWork work = Work(vertices, batch);
  DeviceBuffer<uint32_t> list;
  if (!AreAll(batch.numbers)) {
    LATTICED_ASSIGN_OR_RETURN(
        list, DeviceBuffer<uint32_t>::Upload(context_->memory(), "draco",
                                             std::span<const uint32_t>(batch.numbers), stream));
    work.numbers = list.data();
  }
  LATTICED_ASSIGN_OR_RETURN(const auto scratch, MakeDracoScratch(*context_, stream, entry_room,
                                                                 !batch.digests.empty(), work));
  LATTICED_RETURN_IF_ERROR(Code(work, frame, scratch.places, batch));

  const size_t digest_bytes = batch.digests.size() * sizeof(VertexDigest);
  std::vector<VertexDigest> found(batch.digests.size());
  if (digest_bytes > 0) std::memcpy(found.data(), exchanged_.data(), digest_bytes);
  const std::span places(
      reinterpret_cast<const kernels::DracoPlace*>(exchanged_.data() + digest_bytes), work.count);
  const size_t bytes = places.back().at + kernels::RoundUpTo16(places.back().size);
  std::shared_ptr<const PinnedBuffer> block;
  if (bytes > 0) {
    LATTICED_ASSIGN_OR_RETURN(block, Pack(work, frame, scratch.places, bytes));
  }
  for (size_t i = 0; i < places.size(); ++i) {
    if (places[i].size > 0) {
      batch.results[i] = {block, block->data() + places[i].at, places[i].size, block->size()};
    } else {
      batch.deferred[i] = found.empty() || found[i] != batch.digests[i];
    }
  }
  batch.digests = std::move(found);
  return absl::OkStatus();
}

absl::Status DeviceDracoWriter::Encode(const Vertices& vertices, std::span<const uint32_t> numbers,
                                       double range, std::span<VertexDigest> digests,
                                       std::span<SharedBytes> results, uint32_t entry_room) {
  const kernels::DracoFrame frame = Frame(range);
  std::vector<size_t> left(numbers.size());  // places in `numbers`
  std::iota(left.begin(), left.end(), size_t{0});
  while (!left.empty()) {
    Batch batch;
    for (const size_t i : left) {
      batch.numbers.push_back(numbers[i]);
      if (!digests.empty()) batch.digests.push_back(digests[i]);
    }
    batch.results.resize(left.size());
    batch.deferred.resize(left.size());
    LATTICED_RETURN_IF_ERROR(Round(vertices, frame, entry_room, batch));
    std::vector<size_t> deferred;
    for (size_t k = 0; k < left.size(); ++k) {
      if (batch.deferred[k]) {
        deferred.push_back(left[k]);
        continue;
      }
      results[left[k]] = std::move(batch.results[k]);
      if (!digests.empty()) digests[left[k]] = batch.digests[k];
    }
    if (deferred.size() == left.size()) {
      return absl::InternalError("a chunk's integers have more bits than its view");
    }
    left = std::move(deferred);
  }
  return absl::OkStatus();
}

}  // namespace latticed
