// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device_draco_writer.h"

#include <algorithm>

#include "core/codec/byte_writer.h"
#include "core/codec/draco_container.h"
#include "cuda/cuda_status.h"
#include "cuda/draco_scratch.h"

namespace latticed {
namespace {

constexpr std::string_view kWhat = "the encoding";

// A stream up to the symbols of its positions.
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
  auto heads =
      DeviceBuffer<uint8_t>::Upload(context->memory(), "draco", both, lane->stream().get());
  if (!heads.ok()) return heads.status();
  return DeviceDracoWriter(
      shape, std::move(context), std::move(lane), *std::move(heads),
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
  if (auto s = CudaStatus(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, stream), kWhat);
      !s.ok()) {
    return s;
  }
  return lane_->stream().Synchronize(kWhat);
}

absl::Status DeviceDracoWriter::Round(const Vertices& vertices, std::span<const uint32_t> numbers,
                                      const kernels::DracoFrame& frame, uint32_t entry_room,
                                      std::span<SharedBytes> results) {
  const cudaStream_t stream = lane_->stream().get();
  const auto memory = context_->memory();
  kernels::DracoWork work{.vertices = vertices.bytes.data,
                          .count = static_cast<uint32_t>(numbers.size()),
                          .points = static_cast<uint32_t>(shape_.points),
                          .last_chunk = vertices.last,
                          .last_points = static_cast<uint32_t>(shape_.last_points),
                          .position_bits = shape_.position_bits,
                          .normal_bits = shape_.normal_bits};
  DeviceBuffer<uint32_t> list;
  if (!AreAll(numbers)) {
    auto uploaded = DeviceBuffer<uint32_t>::Upload(memory, "draco", numbers, stream);
    if (!uploaded.ok()) return uploaded.status();
    list = *std::move(uploaded);
    work.numbers = list.data();
  }
  const auto scratch = DracoScratch::Create(*context_, stream, entry_room, work);
  if (!scratch.ok()) return scratch.status();
  const size_t place_bytes = numbers.size() * sizeof(kernels::DracoPlace);
  if (places_.size() < place_bytes) {
    auto places = context_->pinned().Borrow(place_bytes);
    if (!places.ok()) return places.status();
    places_ = *std::move(places);
  }
  if (auto s = CudaStatus(kernels::LaunchDracoSymbols(work, stream), kWhat); !s.ok()) return s;
  if (auto s = CudaStatus(kernels::LaunchDracoRans(work, stream), kWhat); !s.ok()) return s;
  if (auto s =
          CudaStatus(kernels::LaunchDracoPlaces(work, frame, scratch->places(), stream), kWhat);
      !s.ok()) {
    return s;
  }
  if (auto s = Fetch(places_.data(), scratch->places(), place_bytes); !s.ok()) return s;

  const std::span places(reinterpret_cast<const kernels::DracoPlace*>(places_.data()),
                         numbers.size());
  const size_t bytes = places.back().at + kernels::RoundUpTo16(places.back().size);
  auto packed = DeviceBuffer<uint8_t>::Create(memory, "draco", bytes, stream);
  if (!packed.ok()) return packed.status();
  auto pinned = context_->pinned().Borrow(bytes);
  if (!pinned.ok()) return pinned.status();
  if (auto s = CudaStatus(
          kernels::LaunchDracoPack(work, frame, scratch->places(), packed->data(), stream), kWhat);
      !s.ok()) {
    return s;
  }
  if (auto s = Fetch(pinned->data(), packed->data(), bytes); !s.ok()) return s;
  const auto block = std::make_shared<const PinnedBuffer>(*std::move(pinned));
  for (size_t i = 0; i < places.size(); ++i) {
    if (places[i].size > 0) results[i] = {block, block->data() + places[i].at, places[i].size};
  }
  return absl::OkStatus();
}

absl::Status DeviceDracoWriter::Encode(const Vertices& vertices, std::span<const uint32_t> numbers,
                                       double range, std::span<SharedBytes> results,
                                       uint32_t entry_room) {
  if (numbers.empty()) return absl::OkStatus();
  const kernels::DracoFrame frame = Frame(range);
  if (auto s = Round(vertices, numbers, frame, entry_room, results); !s.ok()) return s;
  while (true) {
    std::vector<size_t> left;
    std::vector<uint32_t> left_numbers;
    for (size_t i = 0; i < numbers.size(); ++i) {
      if (results[i].data != nullptr) continue;
      left.push_back(i);
      left_numbers.push_back(numbers[i]);
    }
    if (left.empty()) return absl::OkStatus();
    std::vector<SharedBytes> found(left.size());
    if (auto s = Round(vertices, left_numbers, frame, entry_room, found); !s.ok()) return s;
    for (size_t i = 0; i < left.size(); ++i) results[left[i]] = std::move(found[i]);
  }
}

}  // namespace latticed
