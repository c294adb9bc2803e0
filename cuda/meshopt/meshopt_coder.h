// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Codes meshopt streams on the device, for DeviceStreamWriter. The bytes are those of
// core/codec/meshopt/meshopt_writer.h. Working memory is that of the integers, in whole blocks of 256 vertices.
//
// Threads  as stream_coder.h
#ifndef LATTICED_CUDA_MESHOPT_MESHOPT_CODER_H_
#define LATTICED_CUDA_MESHOPT_MESHOPT_CODER_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "cuda/meshopt/meshopt_kernels.h"
#include "cuda/streams/stream_coder.h"

namespace latticed {

class MeshoptCoder final : public StreamCoder {
 public:
  explicit MeshoptCoder(int normal_bits) { work_.normal_bits = normal_bits; }

  std::string_view purpose() const override { return "meshopt"; }
  int normal_bits() const override { return work_.normal_bits; }
  size_t Plan(std::span<kernels::StreamChunk> chunks) override;
  cudaError_t Code(const kernels::StreamWork& work, uint8_t* scratch, cudaStream_t stream) override;
  cudaError_t Pack(kernels::StreamPlaces places, const kernels::StreamRoom& room,
                   cudaStream_t stream) const override;

 private:
  kernels::MeshoptWork work_{};  // of the last Plan
  size_t blocks_ = 0;            // of all its chunks
};

}  // namespace latticed

#endif  // LATTICED_CUDA_MESHOPT_MESHOPT_CODER_H_
