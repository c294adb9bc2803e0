// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The steps of a block that takes a chunk, from its integers to symbols, and from counts of symbols to tables: for
// draco_symbols_kernel.cu and draco_ranked_kernel.cu. All threads of the block call them, unless they say otherwise.
#ifndef LATTICED_CUDA_DRACO_DRACO_SYMBOLS_CUH_
#define LATTICED_CUDA_DRACO_DRACO_SYMBOLS_CUH_

#include "core/codec/draco_symbols.h"
#include "cuda/draco/draco_table.cuh"

namespace latticed::kernels {

struct Span {
  uint32_t least, most;
  __device__ uint32_t size() const { return most - least + 1; }
};

// The span of `count` values, read two at a time.
__device__ inline Span SpanOf(const uint16_t* values, uint32_t count) {
  __shared__ Span span;
  if (threadIdx.x == 0) span = {0xffff, 0};
  __syncthreads();
  // Pairs begin at a multiple of 4 bytes. Of the values before and after them, there is one each at most.
  const uint32_t before = reinterpret_cast<uintptr_t>(values) / sizeof(uint16_t) % 2;
  const uint32_t pair_count = (count - before) / 2;
  const auto* pairs = reinterpret_cast<const uint32_t*>(values + before);
  uint32_t least = 0xffffffff, most = 0;
  const auto add = [&](uint32_t pair) {
    least = __vminu2(least, pair);
    most = __vmaxu2(most, pair);
  };
  // Eight loads are on their way at once.
#pragma unroll 8
  for (uint32_t i = threadIdx.x; i < pair_count; i += blockDim.x) add(__ldg(pairs + i));
  if (threadIdx.x == 0 && before > 0) add(values[0] * 0x10001u);
  if (threadIdx.x == 0 && before + 2 * pair_count < count) add(values[count - 1] * 0x10001u);
  least = __reduce_min_sync(kAllLanes, min(least & 0xffff, least >> 16));
  most = __reduce_max_sync(kAllLanes, max(most & 0xffff, most >> 16));
  if (Lane() == 0) {
    atomicMin(&span.least, least);
    atomicMax(&span.most, most);
  }
  __syncthreads();
  return span;
}

// Calls take(i, symbols) for each point.
template <class Take>
__device__ __forceinline__ void PositionSymbolsOf(const uint16_t* values, uint32_t points,
                                                  Span span, uint16_t* symbols, const Take& take) {
  const uint32_t wrap = span.size();
#pragma unroll 2
  for (uint32_t i = threadIdx.x; i < points; i += blockDim.x) {
    uint32_t its[kPositionValues];
#pragma unroll
    for (uint32_t axis = 0; axis < kPositionValues; ++axis) {
      const uint16_t* plane = values + axis * points;
      const uint32_t previous = i == 0 ? span.least : __ldg(plane + i - 1);
      its[axis] = PositionSymbol(__ldg(plane + i), previous, wrap);
      symbols[kPositionValues * i + axis] = static_cast<uint16_t>(its[axis]);
    }
    take(i, its);
  }
}

// T: how values are stored.
template <class T, class Take>
__device__ __forceinline__ void StoredNormalSymbolsOf(const uint8_t* normals, uint32_t points,
                                                      int bits, uint16_t* symbols,
                                                      const Take& take) {
  const T* s = reinterpret_cast<const T*>(normals);
  const T* t = s + points;
  const int32_t top = OctahedralMax(bits);
  const auto value = [top](const T* from) { return min(int32_t{__ldg(from)}, top); };
#pragma unroll 2
  for (uint32_t i = threadIdx.x; i < points; i += blockDim.x) {
    OctahedralNormal previous;
    if (i > 0) previous = {value(s + i - 1), value(t + i - 1)};
    const OctahedralNormal n = NormalSymbols({value(s + i), value(t + i)}, previous, bits);
    const uint32_t its[kNormalValues] = {static_cast<uint32_t>(n.s), static_cast<uint32_t>(n.t)};
    reinterpret_cast<uint32_t*>(symbols)[i] = its[0] | its[1] << 16;
    take(i, its);
  }
}
template <class Take>
__device__ __forceinline__ void NormalSymbolsOf(const uint8_t* normals, uint32_t points, int bits,
                                                uint16_t* symbols, const Take& take) {
  if (bits > 8) return StoredNormalSymbolsOf<uint16_t>(normals, points, bits, symbols, take);
  StoredNormalSymbolsOf<uint8_t>(normals, points, bits, symbols, take);
}

// Sets the padding to zero that is read together with a stream's last symbols.
__device__ inline void ZeroPadding(uint16_t* symbols, uint32_t points, DracoKind kind) {
  const uint32_t i = points * ValuesOf(kind) + threadIdx.x;
  if (i < StreamWords(points, kind)) symbols[i] = 0;
}

// Writes the symbols of a chunk. The calls take_position(i, symbols) and take_normal(i, symbols) get those of each point.
template <class TakePosition, class TakeNormal>
__device__ __forceinline__ void WriteSymbols(const DracoWork& work, Span span,
                                             const TakePosition& take_position,
                                             const TakeNormal& take_normal) {
  const uint32_t chunk = blockIdx.x, points = work.Points(chunk);
  const auto* values = reinterpret_cast<const uint16_t*>(work.Vertices(chunk));
  uint16_t* symbols = work.symbols + StreamAt(work, chunk, DracoKind::kPositions);
  PositionSymbolsOf(values, points, span, symbols, take_position);
  ZeroPadding(symbols, points, DracoKind::kPositions);
  if (!work.has_normals()) return;
  symbols = work.symbols + StreamAt(work, chunk, DracoKind::kNormals);
  const auto* normals = reinterpret_cast<const uint8_t*>(values + kPositionValues * points);
  NormalSymbolsOf(normals, points, work.normal_bits, symbols, take_normal);
  ZeroPadding(symbols, points, DracoKind::kNormals);
}

// The tag of a point (core/codec/tagged_symbols.h).
template <uint32_t kValues>
__device__ __forceinline__ uint32_t TagOf(const uint32_t (&symbols)[kValues]) {
  uint32_t any = 1;
  for (const uint32_t symbol : symbols) any |= symbol;
  return HighestBit(any) + 1;
}

// Writes and counts the tags of the points of a sparse chunk.
class TagSink {
 public:
  // `counts`: kTags zeros. All threads of the block construct it. Without normals it takes none of these.
  __device__ TagSink(const DracoWork& work, DracoKind kind, uint32_t* counts) : counts_(counts) {
    if (kind == DracoKind::kNormals && !work.has_normals()) return;
    tags_ = work.symbols + StreamAt(work, blockIdx.x, TagsOf(kind));
    ZeroPadding(tags_, work.Points(blockIdx.x), TagsOf(kind));
  }
  template <uint32_t kValues>
  __device__ __forceinline__ void Take(uint32_t i, const uint32_t (&symbols)[kValues]) const {
    const uint32_t tag = TagOf(symbols);
    tags_[i] = static_cast<uint16_t>(tag);
    atomicAdd(counts_ + tag, 1u);
  }

 private:
  uint16_t* tags_ = nullptr;
  uint32_t* counts_;
};

// Leaves the chunk out, or to a later round. Called by one thread.
__device__ inline void Skip(const DracoWork& work) {
  for (uint32_t k = 0; k < kDracoKinds; ++k) {
    work.streams[kDracoKinds * blockIdx.x + k].skipped = true;
  }
}
// Whether it did so.
__device__ inline bool SkipUnchanged(const DracoWork& work) {
  const bool unchanged = work.IsUnchanged(blockIdx.x);
  if (unchanged && threadIdx.x == 0) Skip(work);
  return unchanged;
}

// Room for the tables of the chunk. Without room the chunk is deferred.
struct Room {
  uint32_t first_entry;
  bool found;
};
__device__ inline Room TakeRoom(const DracoWork& work, uint32_t entries) {
  __shared__ uint32_t first_entry;
  if (threadIdx.x == 0) {
    first_entry = atomicAdd(&work.draco_control->entries_used, entries);
    if (first_entry + entries > work.entry_room) Skip(work);
  }
  __syncthreads();
  return {first_entry, first_entry + entries <= work.entry_room};
}

// Writes a table's entries and bytes, and what is known of its stream, which it returns. Called by one warp.
__device__ inline DracoStream WriteTable(const DracoWork& work, DracoKind kind,
                                         const TableBuilder& table, DracoStream stream) {
  stream.largest = table.largest();
  stream.bit_length = static_cast<uint8_t>(table.bit_length());
  stream.table_bytes = table.Write(work.entries + stream.first_entry,
                                   work.tables + size_t{stream.first_entry} * kTableBytes);
  if (Lane() == 0) work.Stream(blockIdx.x, kind) = stream;
  return stream;
}

// The bits of the symbols behind the tags of `kind`'s symbols. Called by one warp, before a table is made of the counts.
__device__ inline uint32_t TaggedBits(DracoKind kind, const uint32_t* counts) {
  const uint32_t bits = Lane() < kTags ? counts[Lane()] * Lane() * ValuesOf(kind) : 0;
  return __reduce_add_sync(kAllLanes, bits);
}

// A role for each warp of the block, from 0 on. The warp that makes the longest table should be on another scheduler in
// each block that a multiprocessor holds, whatever the distance of their numbers: their hashes are as good as random.
__device__ __forceinline__ uint32_t RoleOfWarp() {
  constexpr uint32_t kHash = 0x9e3779b1u;
  const uint32_t warps = blockDim.x / kWarp;
  return (threadIdx.x / kWarp + (blockIdx.x * kHash >> 24)) % warps;
}

// The counts of tags, and room for the lists of table builders: [0] of positions, [1] of normals.
struct TagCounts {
  uint32_t counts[2][kTags];
  SymbolList<kTags> lists[2];
  __device__ void Zero() {
    for (uint32_t i = threadIdx.x; i < 2 * kTags; i += blockDim.x) counts[i / kTags][i % kTags] = 0;
  }
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_DRACO_DRACO_SYMBOLS_CUH_
