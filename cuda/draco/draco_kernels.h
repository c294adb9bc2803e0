// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Draco streams of quantised chunks, written on the device: the bytes of core/codec/draco_writer.h.
//
//   draco_digest_kernel.cu   a block a chunk     integers -> their digest; whether it is the known one
//   draco_symbols_kernel.cu  a block a chunk     integers -> symbols, their counts, probabilities,
//                                                the bytes of the tables
//   draco_rans_kernel.cu     a thread a stream   symbols -> the bytes that leave the state at each
//   draco_pack_kernel.cu     one block, then     sizes -> places, then the bytes of each chunk in
//                            a block a chunk     its place
//
// A stream is one attribute of a chunk: stream 2 i holds positions, stream 2 i + 1 normals. The tables of
// all streams share one store; a table takes as many entries as its stream has symbols. A chunk whose tables
// do not fit is deferred: its result is empty, and the caller encodes it again together with fewer chunks.
//
// Layout   chunks one after the other in wire layout; all have equally many points, except the last of a
//          plan
// Errors   cudaError_t of the launch
// Threads  no call waits; all pointers must stay valid until the stream has run the kernels
#ifndef LATTICED_CUDA_DRACO_DRACO_KERNELS_H_
#define LATTICED_CUDA_DRACO_DRACO_KERNELS_H_

#include <cuda_runtime_api.h>

#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"

namespace latticed::kernels {

inline constexpr uint32_t kPositionValues = 3, kNormalValues = 2;  // of a point

// The result of coding a stream.
struct DracoStream {
  uint32_t first_entry;  // of its table in DracoWork::entries, by symbol
  uint32_t table_bytes;
  uint32_t coded_bytes;  // with those of the last state
  uint32_t largest;      // symbol
  uint32_t last_word;    // the last state's bytes, the lowest first
  uint16_t least, most;  // of the chunk's coordinates; of positions only
  uint8_t bit_length;    // rans_model.h
  uint8_t fate;          // DracoFate, of the chunk
};
// kUnchanged: the integers have the digest that the caller gave, so the host has the bytes already.
enum class DracoFate : uint8_t { kCoded, kDeferred, kUnchanged };

LATTICED_HD inline bool IsCoded(const DracoStream& stream) {
  return stream.fate == static_cast<uint8_t>(DracoFate::kCoded);
}

// 128 bits of a chunk's integers, the device's own: VertexDigest of core/backend.h.
struct DracoDigest {
  unsigned long long low, high;
};

// At 12 bits, up to two bytes leave the state at each symbol. Both are stored, whether they leave or not,
// and two bits say how many do: a word has these bits for sixteen symbols. Streams of more bits are rare.
// Their bytes are stored one after the other, up to two for each symbol.
inline constexpr uint32_t kSymbolsAWord = 16;

// Arrays of counts for chunks whose coordinates span more than shared memory holds. A block takes a free
// one and gives it back.
inline constexpr uint32_t kWideSlots = 64;

// The host sets these to zero before the first kernel.
struct DracoControl {
  uint32_t entries_used;
  uint32_t wide_taken[kWideSlots];
};

// Chunks to encode, and the memory to do it in.
struct DracoWork {
  const uint8_t* vertices;             // chunk number k at k * points * BytesPerPoint()
  const uint32_t* numbers;             // of the chunks to encode; null: 0, 1, 2 …
  uint32_t count;                      // of them
  uint32_t points;                     // of a chunk
  uint32_t last_chunk, last_points;    // the chunk that may have fewer points, and its points
  int32_t position_bits, normal_bits;  // 0: no normals

  // By place in `numbers`, the parts that StreamAt says.
  uint16_t* symbols;
  uint16_t* leaving;        // the low two bytes of the state
  uint32_t* leaving_bytes;  // how many of them leave
  // By first_entry.
  uint2* entries;   // rans_entry.h
  uint8_t* tables;  // kTableBytes for each entry
  uint32_t entry_room;
  uint32_t* wide_counts;  // kWideSlots of 2^position_bits, where these are more than kSharedCounts
  DracoControl* control;
  DracoStream* streams;
  DracoDigest* digests;  // in: known ones; out: those found; null: all chunks are encoded

  LATTICED_HD uint32_t Number(uint32_t i) const { return numbers == nullptr ? i : numbers[i]; }
  LATTICED_HD bool IsLast(uint32_t i) const { return Number(i) == last_chunk; }
  LATTICED_HD uint32_t Points(uint32_t i) const { return IsLast(i) ? last_points : points; }
  LATTICED_HD uint32_t BytesPerPoint() const {
    return 6 + (normal_bits == 0 ? 0 : normal_bits <= 8 ? 2 : 4);
  }
  LATTICED_HD const uint8_t* Vertices(uint32_t i) const {
    return vertices + size_t{Number(i)} * points * BytesPerPoint();
  }
};

// Enough for coordinates of 12 bits, and for chunks whose coordinates span no more.
inline constexpr uint32_t kSharedCounts = 4096;

// A table takes at most three bytes a symbol and three more. Only a table with M = 4096 may have fewer
// than three symbols, and there both numbers are two.
inline constexpr uint32_t kTableBytes = 4;

LATTICED_HD constexpr size_t RoundUpTo16(size_t bytes) { return (bytes + 15) / 16 * 16; }

// The 16-bit words that one stream takes, a multiple of kSymbolsAWord.
LATTICED_HD constexpr size_t StreamWords(uint32_t points, uint32_t values) {
  return (size_t{points} * values + kSymbolsAWord - 1) / kSymbolsAWord * kSymbolsAWord;
}
// The 16-bit words that all streams of a chunk take.
LATTICED_HD constexpr size_t ChunkWords(uint32_t points, bool normals) {
  return StreamWords(points, kPositionValues) + (normals ? StreamWords(points, kNormalValues) : 0);
}
// The place of a stream's first word.
LATTICED_HD constexpr size_t StreamAt(const DracoWork& work, uint32_t chunk, bool normals) {
  return chunk * ChunkWords(work.points, work.normal_bits > 0) +
         (normals ? StreamWords(work.points, kPositionValues) : 0);
}

// Runs first, when there are digests.
cudaError_t LaunchDracoDigests(const DracoWork& work, cudaStream_t stream);
cudaError_t LaunchDracoSymbols(const DracoWork& work, cudaStream_t stream);
cudaError_t LaunchDracoRans(const DracoWork& work, cudaStream_t stream);

// The constant bytes of the streams. `head` comes before the symbols of positions; there is one for full
// chunks and one for the last chunk. `end` comes after the symbols of the last attribute.
struct DracoFrame {
  static constexpr size_t kEndBytes = 40;
  struct Head {
    const uint8_t* bytes;
    uint32_t size;
    uint32_t least_stream;  // shorter streams are padded to it with zeros
  };
  Head heads[2];
  uint8_t normal_prediction[2];
  uint8_t end[kEndBytes];
  uint32_t end_size;
};

struct DracoPlace {
  uint32_t at, size;  // bytes; size 0: deferred or unchanged
};
// Places of all streams, 16 bytes aligned, one after the other.
cudaError_t LaunchDracoPlaces(const DracoWork& work, const DracoFrame& frame, DracoPlace* places,
                              cudaStream_t stream);
cudaError_t LaunchDracoPack(const DracoWork& work, const DracoFrame& frame,
                            const DracoPlace* places, uint8_t* out, cudaStream_t stream);

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_DRACO_DRACO_KERNELS_H_
