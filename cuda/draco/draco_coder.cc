// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/draco/draco_coder.h"

#include <vector>

#include "core/base/status_macros.h"
#include "core/codec/byte_writer.h"
#include "core/codec/draco_container.h"
#include "cuda/draco/draco_scratch.h"

namespace latticed {
namespace {

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

static_assert(sizeof(kernels::DracoControl) % 16 == 0 &&
              sizeof(kernels::DracoControl) <= StreamCoder::kMostZeros);

}  // namespace

absl::StatusOr<std::unique_ptr<StreamCoder>> DracoCoder::Create(const DracoShape& shape,
                                                                const CudaContext& context,
                                                                cudaStream_t stream,
                                                                uint32_t entry_room) {
  std::vector<uint8_t> both = HeadBytes(shape.normal_bits, shape.connectivity[0]);
  std::array<uint32_t, 2> sizes{static_cast<uint32_t>(both.size()), 0};
  if (shape.connectivity[1] != nullptr) {
    const auto others = HeadBytes(shape.normal_bits, shape.connectivity[1]);
    both.insert(both.end(), others.begin(), others.end());
    sizes[1] = static_cast<uint32_t>(others.size());
  }
  LATTICED_ASSIGN_OR_RETURN(auto heads,
                            DeviceBuffer<uint8_t>::Upload(context.memory(), kPurpose,
                                                          std::span<const uint8_t>(both), stream));
  return std::unique_ptr<StreamCoder>(new DracoCoder(shape, entry_room, std::move(heads), sizes));
}

DracoCoder::DracoCoder(const DracoShape& shape, uint32_t entry_room, DeviceBuffer<uint8_t> heads,
                       std::array<uint32_t, 2> head_bytes)
    : shape_(shape), entry_room_(entry_room), heads_(std::move(heads)), head_bytes_(head_bytes) {
  work_.position_bits = shape.position_bits;
  work_.normal_bits = shape.normal_bits;
  work_.sparse = shape.is_sparse;
}

void DracoCoder::SetRange(double range) {
  frame_ = {};
  const bool is_mesh = shape_.connectivity[0] != nullptr;
  for (size_t i = 0; i < 2; ++i) {
    const size_t head = is_mesh ? i : 0;
    const ChunkConnectivity* triangles = shape_.connectivity[i];
    frame_.heads[i] = {
        .bytes = heads_.data() + (head == 0 ? 0 : head_bytes_[0]),
        .size = head_bytes_[head],
        .least_stream = is_mesh ? static_cast<uint32_t>(triangles->LeastStreamBytes()) : 0};
  }
  frame_.head_points = static_cast<uint32_t>(shape_.mesh_points);
  frame_.points_at = is_mesh ? 0 : static_cast<uint32_t>(kDracoHeaderBytes);
  ByteWriter prediction(frame_.normal_prediction);
  WritePrediction(DracoAttribute::kNormal, prediction);
  ByteWriter end(frame_.end);
  if (shape_.normal_bits > 0) WriteNormalBounds(shape_.normal_bits, end);
  WriteDequantisation(shape_.position_bits, shape_.normal_bits, static_cast<float>(range), end);
  frame_.end_size = static_cast<uint32_t>(end.at() - frame_.end);
}

size_t DracoCoder::Plan(std::span<kernels::StreamChunk> chunks) {
  DracoSizes sizes(work_);
  for (kernels::StreamChunk& chunk : chunks) chunk.scratch_at = sizes.Add(chunk.points);
  sizes.SetSizes(entry_room_, work_);
  groups_ = sizes.groups();
  return DivideDracoScratch(nullptr, groups_, work_);
}

cudaError_t DracoCoder::Code(const kernels::StreamWork& work, uint8_t* scratch,
                             cudaStream_t stream) {
  static_cast<kernels::StreamWork&>(work_) = work;
  work_.draco_control = reinterpret_cast<kernels::DracoControl*>(work.control + 1);
  DivideDracoScratch(scratch, groups_, work_);
  for (const auto launch :
       {kernels::LaunchDracoRanked, kernels::LaunchDracoSymbols, kernels::LaunchDracoRans}) {
    if (const cudaError_t error = launch(work_, stream); error != cudaSuccess) return error;
  }
  return cudaSuccess;
}

cudaError_t DracoCoder::Pack(kernels::StreamPlaces places, const kernels::StreamRoom& room,
                             cudaStream_t stream) const {
  return kernels::LaunchDracoPack(work_, frame_, places, room, stream);
}

}  // namespace latticed
