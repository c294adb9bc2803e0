// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Draco streams of quantised chunks, written on the device: the bytes of core/codec/draco_writer.h.
//
//   draco_symbols_kernel.cu  a block a chunk     integers -> symbols, their counts, probabilities,
//   draco_ranked_kernel.cu                       the bytes of the tables
//   draco_rans_kernel.cu     a lane a stream     symbols -> the bytes that leave the state at each
//   draco_pack_kernel.cu     a block a chunk     the bytes of the stream, in the next place
//
// A stream is the symbols of one attribute of a chunk, or, of sparse chunks, the tags of these symbols
// (core/codec/tagged_symbols.h). The tables of all streams share one store. A chunk whose tables do not fit is
// deferred: its result is empty, and the caller encodes it again together with fewer chunks.
//
// A table has an entry for each symbol up to the largest. A sparse chunk has few symbols, but its coordinates may span
// all values: unless it has many points, symbols of more than 9 bits are ranked, and their table has an entry for each
// symbol that occurs. Mostly there is no such table: the tags are shorter for sure (draco_choice.cuh).
//
// Layout, errors and threads: those of cuda/streams/stream_kernels.h.
#ifndef LATTICED_CUDA_DRACO_DRACO_KERNELS_H_
#define LATTICED_CUDA_DRACO_DRACO_KERNELS_H_

#include <cuda_runtime_api.h>

#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"
#include "cuda/streams/stream_kernels.h"

namespace latticed::kernels {

enum class DracoKind : uint32_t { kPositions, kNormals, kPositionTags, kNormalTags };
inline constexpr uint32_t kDracoKinds = 4;
inline constexpr uint32_t kPositionValues = 3, kNormalValues = 2;  // of a point

LATTICED_HD constexpr uint32_t ValuesOf(DracoKind kind) {
  return kind == DracoKind::kPositions ? kPositionValues
         : kind == DracoKind::kNormals ? kNormalValues
                                       : 1;
}
LATTICED_HD constexpr DracoKind TagsOf(DracoKind kind) {
  return kind == DracoKind::kPositions ? DracoKind::kPositionTags : DracoKind::kNormalTags;
}

// The result of coding a stream.
struct DracoStream {
  uint32_t first_entry;  // of its table in DracoWork::entries, by symbol or by rank
  uint32_t table_bytes;
  uint32_t coded_bytes;  // with those of the last state
  uint32_t largest;      // symbol
  uint32_t last_word;    // the last state's bytes, the lowest first
  uint32_t tagged_bits;  // of tags only: the bits of the symbols behind them
  uint16_t least, most;  // of the chunk's coordinates; of positions only
  uint8_t bit_length;    // rans_model.h
  bool skipped;          // the chunk is unchanged or deferred: there is nothing to code
  bool ranked;           // DracoWork::ranks has its symbols' places in the table
  bool left_out;  // another scheme is shorter for sure: there is no table, and nothing to code
};
LATTICED_HD inline bool HasTable(const DracoStream& stream) {
  return !stream.skipped && !stream.left_out;
}

// At 12 bits, up to two bytes leave the state at each symbol. Both are stored, whether they leave or not,
// and two bits say how many do: a word has these bits for sixteen symbols (draco_leaving.cuh). Streams of more bits are rare.
// Their bytes are stored one after the other, up to two for each symbol.
inline constexpr uint32_t kSymbolsAWord = 16;

// Arrays of counts for chunks whose coordinates span more than shared memory holds. A block takes a free
// one and gives it back.
inline constexpr uint32_t kWideSlots = 64;

// Zeros before the first kernel.
struct alignas(16) DracoControl {
  uint32_t entries_used;
  uint32_t wide_taken[kWideSlots];
};

// Chunks to encode, and the memory to do it in. A chunk's streams begin at the group StreamChunk::scratch_at of
// kSymbolsAWord words.
struct DracoWork : StreamWork {
  int32_t position_bits;
  bool sparse;           // QuantisedVertices::is_sparse, of all chunks
  uint32_t most_ranked;  // the most points of a chunk that IsRanked; 0: there is none
  bool all_ranked;

  // By group, the parts that StreamAt says.
  uint16_t* symbols;
  uint16_t* ranks;          // as `symbols`, but of sparse chunks only
  uint16_t* leaving;        // the low two bytes of the state
  uint32_t* leaving_bytes;  // how many of them leave
  // By first_entry.
  uint2* entries;   // rans_entry.h
  uint8_t* tables;  // kTableBytes for each entry
  uint32_t entry_room;
  uint32_t* wide_counts;  // kWideSlots of 2^position_bits, where these are more than kSharedCounts
  DracoControl* draco_control;
  DracoStream* streams;  // kDracoKinds a chunk

  LATTICED_HD DracoStream& Stream(uint32_t i, DracoKind kind) const {
    return streams[kDracoKinds * i + static_cast<uint32_t>(kind)];
  }
  // Of each chunk; the k-th one is KindOf(k).
  LATTICED_HD uint32_t Kinds() const { return (has_normals() ? 2u : 1u) * (sparse ? 2u : 1u); }
  LATTICED_HD DracoKind KindOf(uint32_t k) const {
    return static_cast<DracoKind>(has_normals() ? k : 2 * k);
  }
};

// Chunks of more points have more distinct symbols than a ranking in shared memory has room for.
inline constexpr uint32_t kMostRankedPoints = 1024;
LATTICED_HD inline bool IsRanked(const DracoWork& work, uint32_t points) {
  return work.sparse && points <= kMostRankedPoints;
}

// Enough for coordinates of 12 bits, and for chunks whose coordinates span no more.
inline constexpr uint32_t kSharedCounts = 4096;

// A table takes at most three bytes a symbol and three more. Only a table with M = 4096 may have fewer
// than three symbols, and there both numbers are two.
inline constexpr uint32_t kTableBytes = 4;

// Tags are bit lengths of 16-bit symbols.
inline constexpr uint32_t kTags = 17;
// The most table entries of a chunk's tags.
LATTICED_HD inline uint32_t TagEntries(const DracoWork& work) {
  return work.sparse ? (work.has_normals() ? 2 : 1) * kTags : 0;
}
// Symbols of so few bits are never ranked.
inline constexpr int32_t kUnrankedBits = 9;
// The most entries of an attribute's table in a chunk that IsRanked: where they are ranked, its symbols, and the bytes that
// skip those of no probability, one for 64.
LATTICED_HD inline uint32_t RankedEntries(uint32_t symbols, int32_t bits) {
  const uint32_t values = 1u << bits, skips = values / 64 / kTableBytes + 1;
  return bits <= kUnrankedBits || symbols >= values ? values + skips : symbols + skips;
}
LATTICED_HD inline uint32_t RankedEntries(const DracoWork& work, uint32_t points) {
  return RankedEntries(kPositionValues * points, work.position_bits) + TagEntries(work) +
         (work.has_normals() ? RankedEntries(kNormalValues * points, work.normal_bits) : 0);
}

// Groups of kSymbolsAWord 16-bit words, of so many symbols.
LATTICED_HD constexpr uint32_t GroupsOf(uint32_t symbols) {
  return (symbols + kSymbolsAWord - 1) / kSymbolsAWord;
}
// The 16-bit words that one stream takes, a multiple of kSymbolsAWord.
LATTICED_HD constexpr size_t StreamWords(uint32_t points, DracoKind kind) {
  return size_t{GroupsOf(points * ValuesOf(kind))} * kSymbolsAWord;
}
// The place of a stream's first word. The streams of a chunk lie one after the other.
LATTICED_HD inline size_t StreamAt(const DracoWork& work, uint32_t i, DracoKind kind) {
  const StreamChunk& chunk = work.chunks[i];
  size_t at = size_t{chunk.scratch_at} * kSymbolsAWord;
  for (uint32_t k = 0; work.KindOf(k) != kind; ++k) at += StreamWords(chunk.points, work.KindOf(k));
  return at;
}

// The first takes chunks that IsRanked, and the second all others. A chunk for which one finds no room is deferred.
cudaError_t LaunchDracoRanked(const DracoWork& work, cudaStream_t stream);
cudaError_t LaunchDracoSymbols(const DracoWork& work, cudaStream_t stream);
cudaError_t LaunchDracoRans(const DracoWork& work, cudaStream_t stream);

// The constant bytes of the streams. `head` comes before the symbols of positions. `end` comes after the symbols of the
// last attribute.
struct DracoFrame {
  static constexpr size_t kEndBytes = 40;
  struct Head {
    const uint8_t* bytes;
    uint32_t size;
    uint32_t least_stream;  // shorter streams are padded to it with zeros
  };
  // Of clouds both are one. Meshes whose chunks have head_points points take the first, and those of other chunks the
  // second.
  Head heads[2];
  uint32_t head_points;
  uint32_t
      points_at;  // clouds have their number of points, in four bytes, at this byte of the head; 0: they are meshes
  uint8_t normal_prediction[2];
  uint8_t end[kEndBytes];
  uint32_t end_size;
};

cudaError_t LaunchDracoPack(const DracoWork& work, const DracoFrame& frame, StreamPlaces known,
                            const StreamRoom& room, cudaStream_t stream);

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_DRACO_DRACO_KERNELS_H_
