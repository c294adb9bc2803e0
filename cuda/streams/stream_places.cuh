// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds the place of a stream, for kernels that pack a chunk a block. All kThreads threads of the block call these
// functions together.
#ifndef LATTICED_CUDA_STREAMS_STREAM_PLACES_CUH_
#define LATTICED_CUDA_STREAMS_STREAM_PLACES_CUH_

#include <cstdint>

#include "cuda/streams/stream_kernels.h"

namespace latticed::kernels {

__device__ __forceinline__ size_t EndOf(const StreamPlace& place) {
  return place.at + RoundUpTo16(place.size);
}

template <unsigned kThreads>
__device__ void ZeroBytes(uint8_t* from, const uint8_t* end) {
  for (uint8_t* at = from + threadIdx.x; at < end; at += kThreads) *at = 0;
}

// The block that is the last to find a place also sets the room behind all streams to zero. They may fill it and more.
template <unsigned kThreads>
__device__ void ZeroRest(const StreamRoom& room, size_t end) {
  const uint4 zeros{};
  for (size_t at = end + threadIdx.x * sizeof(zeros); at + sizeof(zeros) <= room.size;
       at += kThreads * sizeof(zeros)) {
    *reinterpret_cast<uint4*>(room.bytes + at) = zeros;
  }
}

// `size_of()`: the bytes of the chunk's stream, 0 if it has none. Called by the first thread, unless the place is known.
template <unsigned kThreads, class SizeOf>
__device__ StreamPlace FindPlace(const StreamWork& work, StreamPlaces known, const StreamRoom& room,
                                 uint32_t chunk, const SizeOf& size_of) {
  if (known == StreamPlaces::kKnown) return work.places[chunk];
  __shared__ StreamPlace place;
  __shared__ bool is_last;
  if (threadIdx.x == 0) {
    constexpr auto kOne = StreamControl::kOnePlaced;
    const uint32_t size = size_of();
    const auto before =
        atomicAdd(&work.control->placed, kOne + static_cast<uint32_t>(RoundUpTo16(size)));
    work.places[chunk] = place = {static_cast<uint32_t>(before % kOne), size};
    is_last = before / kOne + 1 == work.count;
  }
  __syncthreads();
  if (is_last) ZeroRest<kThreads>(room, EndOf(place));
  return place;
}

// Whether there is a stream to write. Of a stream that the room does not wholly hold, the part in it becomes 0.
template <unsigned kThreads>
__device__ bool MustWrite(const StreamPlace& place, const StreamRoom& room) {
  if (place.size == 0) return false;
  if (EndOf(place) <= room.size) return true;
  ZeroBytes<kThreads>(room.bytes + min(size_t{place.at}, room.size), room.bytes + room.size);
  return false;
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_STREAMS_STREAM_PLACES_CUH_
