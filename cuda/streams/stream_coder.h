// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What DeviceStreamWriter asks of a codec. A round is a set of chunks that are encoded together:
//
//   Plan   the numbers of points -> the bytes of working memory
//   Code   integers -> parts of streams, in working memory
//   Pack   parts -> streams, once more if the room was too small
//
// Errors   cudaError_t of the launches
// Threads  one at a time; no call waits
#ifndef LATTICED_CUDA_STREAMS_STREAM_CODER_H_
#define LATTICED_CUDA_STREAMS_STREAM_CODER_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "cuda/streams/stream_kernels.h"

namespace latticed {

class StreamCoder {
 public:
  virtual ~StreamCoder() = default;

  // The purpose of the device memory that encoding takes, as in MemoryUse; a literal.
  virtual std::string_view purpose() const = 0;
  // Of all chunks. 0: no normals.
  virtual int normal_bits() const = 0;
  // Zeros behind StreamControl, at most kMostZeros, a multiple of 16.
  static constexpr size_t kMostZeros = 512;
  virtual size_t zeros() const { return 0; }
  // What it keeps on the device.
  virtual size_t DeviceBytes() const { return 0; }

  // That of the quantisation box, for the rounds that follow.
  virtual void SetRange(double /*range*/) {}

  // Begins a round. Sets StreamChunk::scratch_at, and returns the bytes of working memory. The device may wait for this,
  // so a chunk takes no more than a few operations.
  virtual size_t Plan(std::span<kernels::StreamChunk> chunks) = 0;
  // Codes the chunks of Plan, unless they are unchanged. `scratch`: working memory, 16 bytes aligned, until the stream has
  // run Pack. Meanwhile other rounds may begin, on other streams.
  virtual cudaError_t Code(const kernels::StreamWork& work, uint8_t* scratch,
                           cudaStream_t stream) = 0;
  // Writes the streams, and work.places if it finds them. Places that are known must be those of the round begun last. The
  // stream of a chunk that waits for memory has size 0: the caller encodes the chunk again, in a round of fewer chunks.
  virtual cudaError_t Pack(kernels::StreamPlaces places, const kernels::StreamRoom& room,
                           cudaStream_t stream) const = 0;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_STREAMS_STREAM_CODER_H_
