// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Codes Draco streams on the device, for DeviceStreamWriter. The bytes are those of core/codec/draco_writer.h. Chunks may
// have any numbers of points.
//
// Errors   those of device_buffer.h. In DeviceStreamWriter::Encode, kInternal where a coordinate has more than
//          position_bits
// Threads  as stream_coder.h
#ifndef LATTICED_CUDA_DRACO_DRACO_CODER_H_
#define LATTICED_CUDA_DRACO_DRACO_CODER_H_

#include <array>
#include <cstdint>
#include <memory>
#include <utility>

#include "core/codec/chunk_connectivity.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/device_buffer.h"
#include "cuda/draco/draco_kernels.h"
#include "cuda/streams/stream_coder.h"

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

class DracoCoder final : public StreamCoder {
 public:
  // `entry_room`: for tests, the number of table entries; 0: what most chunks need. Enqueues a copy on `stream`.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<StreamCoder>> Create(
      const DracoShape& shape, const CudaContext& context, cudaStream_t stream,
      uint32_t entry_room = 0);

  std::string_view purpose() const override { return kPurpose; }
  int normal_bits() const override { return work_.normal_bits; }
  size_t zeros() const override { return sizeof(kernels::DracoControl); }
  size_t DeviceBytes() const override { return heads_.size_bytes(); }
  void SetRange(double range) override;
  size_t Plan(std::span<kernels::StreamChunk> chunks) override;
  cudaError_t Code(const kernels::StreamWork& work, uint8_t* scratch, cudaStream_t stream) override;
  cudaError_t Pack(kernels::StreamPlaces places, const kernels::StreamRoom& room,
                   cudaStream_t stream) const override;

 private:
  static constexpr std::string_view kPurpose = "draco";

  DracoCoder(const DracoShape& shape, uint32_t entry_room, DeviceBuffer<uint8_t> heads,
             std::array<uint32_t, 2> head_bytes);

  DracoShape shape_;
  uint32_t entry_room_;
  DeviceBuffer<uint8_t> heads_;  // as shape_.connectivity has them; of clouds, one
  std::array<uint32_t, 2> head_bytes_;
  kernels::DracoFrame frame_{};
  kernels::DracoWork work_{};  // of the last Plan
  size_t groups_ = 0;          // of its words
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DRACO_DRACO_CODER_H_
