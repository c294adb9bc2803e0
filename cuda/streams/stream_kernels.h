// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the kernels of all codecs share: the chunks of a round, their digests, and the places of their streams. A stream is
// the encoded bytes of one chunk.
//
//   stream_digest_kernel.cu   a block a chunk    integers -> their digest
//   stream_places.cuh         in a codec's kernel that packs: finds the next place for a stream
//
// Layout   chunks in wire layout, each with as many points as it has, at any place
// Errors   cudaError_t of the launch
// Threads  no call waits; all pointers must stay valid until the stream has run the kernels
#ifndef LATTICED_CUDA_STREAMS_STREAM_KERNELS_H_
#define LATTICED_CUDA_STREAMS_STREAM_KERNELS_H_

#include <cuda_runtime_api.h>

#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"

namespace latticed::kernels {

LATTICED_HD constexpr size_t RoundUpTo16(size_t bytes) { return (bytes + 15) / 16 * 16; }

// Zeros before the first kernel. Zeros of the codec lie just behind.
struct alignas(16) StreamControl {
  // Of streams: how many have a place, times kOnePlaced, and the bytes that these take.
  static constexpr unsigned long long kOnePlaced = 1ull << 40;
  unsigned long long placed;
};

// A chunk to encode.
struct StreamChunk {
  uint64_t first_point;  // at first_point * BytesPerPoint() of StreamWork::vertices
  uint32_t points;       // at least 1
  uint32_t
      scratch_at;  // where its part of the codec's working memory begins, in units of the codec
};

// 128 bits of a chunk's integers, the device's own: VertexDigest of core/backend.h.
struct StreamDigest {
  unsigned long long low, high;
};

struct StreamPlace {
  uint32_t at, size;  // bytes; size 0: deferred or unchanged
};

// The chunks of a round.
struct StreamWork {
  const uint8_t* vertices = nullptr;
  const StreamChunk* chunks = nullptr;
  uint32_t count = 0;       // of them
  int32_t normal_bits = 0;  // 0: no normals
  StreamControl* control = nullptr;
  StreamDigest* digests = nullptr;  // known ones, then those found; null: all chunks are encoded
  StreamPlace* places = nullptr;

  LATTICED_HD bool has_normals() const { return normal_bits > 0; }
  LATTICED_HD uint32_t Points(uint32_t i) const { return chunks[i].points; }
  LATTICED_HD uint32_t BytesPerPoint() const {
    return 6 + (normal_bits == 0 ? 0 : normal_bits <= 8 ? 2 : 4);
  }
  LATTICED_HD const uint8_t* Vertices(uint32_t i) const {
    return vertices + chunks[i].first_point * BytesPerPoint();
  }
  // The integers have the digest that the caller gave, so the host has the bytes already.
  LATTICED_HD bool IsUnchanged(uint32_t i) const {
    if (digests == nullptr) return false;
    const StreamDigest known = digests[i], found = digests[count + i];
    return known.low == found.low && known.high == found.high;
  }
};

// Runs first. Does nothing without digests.
cudaError_t LaunchStreamDigests(const StreamWork& work, cudaStream_t stream);

// Room for streams. Those that are not wholly in it are not written. Bytes of no stream become 0.
struct StreamRoom {
  uint8_t* bytes;
  size_t size;
};
// Finds places for all streams, 16 bytes aligned, one after the other in any order; or takes those of an earlier call.
enum class StreamPlaces { kFind, kKnown };

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_STREAMS_STREAM_KERNELS_H_
