// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which of the schemes RAW and TAGGED is shorter for an attribute of a sparse chunk. The sizes of both are known when both
// are coded. But one is often shorter by so much that bounds of their sizes say so (coded_bounds.h), and the other need not
// be coded. Of the symbols
//
//   RAW     takes 3 bytes, their table, and the length of the states and the states of the symbols
//   TAGGED  takes 2 bytes, the table of tags, the same of the tags, and the symbols in as many bits as their tags say
//
// A table takes at least one byte, a byte for each symbol that occurs, and a byte for each gap before one of these.
#ifndef LATTICED_CUDA_DRACO_DRACO_CHOICE_CUH_
#define LATTICED_CUDA_DRACO_DRACO_CHOICE_CUH_

#include "cuda/draco/coded_bounds.h"
#include "cuda/draco/draco_symbols.cuh"

namespace latticed::kernels {

// What n log2(n) is for a count.
__device__ __forceinline__ float CountBits(uint32_t count) {
  const auto n = static_cast<float>(count);
  return count > 1 ? n * __log2f(n) : 0;
}

// At least the sum of log2(sum / count) over the symbols that `counts` counts. One that counts several symbols makes it
// less. Called by one warp.
__device__ inline float LeastBits(const uint32_t* counts, uint32_t size, uint32_t sum) {
  float bits = 0;
  for (uint32_t i = Lane(); i < size; i += kWarp) bits += CountBits(counts[i]);
  return CountBits(sum) - SumOfLanes(bits);
}

// The symbols of an attribute, of which each bit of `bits` says whether it occurs. Called by one warp.
struct Occurring {
  uint32_t distinct, gaps, largest;

  __device__ Occurring(const uint32_t* bits, uint32_t words) {
    uint32_t ones = 0, firsts = 0, last = 0;
    for (uint32_t i = Lane(); i < words; i += kWarp) {
      const uint32_t word = bits[i], before = i == 0 ? 1 : bits[i - 1] >> 31;
      ones += static_cast<uint32_t>(__popc(word));
      firsts += static_cast<uint32_t>(__popc(word & ~(word << 1 | before)));
      if (word != 0) last = kWarp * i + HighestBit(word);
    }
    distinct = __reduce_add_sync(kAllLanes, ones);
    gaps = __reduce_add_sync(kAllLanes, firsts);
    largest = __reduce_max_sync(kAllLanes, last);
  }
};

// A table that was made, and the bits of its symbols, no less.
struct MadeTable {
  DracoStream stream;
  float most_bits;
};

// Makes the table of the tags of `kind`'s symbols. Called by one warp.
__device__ inline MadeTable MakeTagTable(const DracoWork& work, DracoKind kind, TagCounts& tags,
                                         uint32_t first_entry) {
  const uint32_t place = kind == DracoKind::kPositions ? 0 : 1;
  uint32_t* const counts = tags.counts[place];
  const uint32_t bits = TaggedBits(kind, counts);
  const TableBuilder table(counts, kTags, work.Points(blockIdx.x), tags.lists[place].room());
  return {WriteTable(work, TagsOf(kind), table, {.first_entry = first_entry, .tagged_bits = bits}),
          table.MostBits()};
}

// What a table, and the length and the states of so many symbols take, at most.
__device__ __forceinline__ uint32_t MostBytes(const MadeTable& table, uint32_t symbols) {
  constexpr uint32_t kLength = 3;  // a varint of less than 2^21
  return table.stream.table_bytes + kLength + MostCodedBytes(table.most_bits, symbols);
}
// The same, at least. `bits`: no more than those of the symbols.
__device__ __forceinline__ uint32_t LeastBytes(uint32_t distinct, uint32_t gaps, float bits,
                                               uint32_t symbols) {
  constexpr uint32_t kTable = 1, kLength = 1;
  return kTable + distinct + gaps + kLength + LeastCodedBytes(bits, symbols);
}

// Whether TAGGED is shorter than RAW and than the plain symbols, for sure. `counts`: counts of the symbols, several of
// which may share one.
__device__ inline bool TaggedWins(const MadeTable& tags, uint32_t points, const Occurring& symbols,
                                  const uint32_t* counts, uint32_t size, uint32_t count) {
  const uint32_t tagged = 2 + MostBytes(tags, points) + (tags.stream.tagged_bits + 7) / 8;
  const uint32_t raw =
      3 + LeastBytes(symbols.distinct, symbols.gaps, LeastBits(counts, size, count), count);
  return tagged < raw && tagged < 2 + count * PlainSymbolBytes(symbols.largest);
}

// Whether RAW is shorter than the plain symbols, and TAGGED not shorter than RAW, for sure. `tags`: their counts.
__device__ inline bool RawWins(const MadeTable& table, uint32_t count, const uint32_t* tags,
                               uint32_t tagged_bits, uint32_t points) {
  const uint32_t raw = 3 + MostBytes(table, count);
  const auto distinct =
      static_cast<uint32_t>(__popc(__ballot_sync(kAllLanes, Lane() < kTags && tags[Lane()] > 0)));
  const uint32_t tagged =
      2 + LeastBytes(distinct, 0, LeastBits(tags, kTags, points), points) + (tagged_bits + 7) / 8;
  return raw <= tagged && !StorePlainly(raw, count, table.stream.largest);
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_DRACO_DRACO_CHOICE_CUH_
