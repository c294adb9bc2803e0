// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A block takes a chunk. All its threads find the span of the coordinates, the symbols of all points and
// their counts. Then one warp makes each of the two tables.
#include "core/codec/draco_symbols.h"
#include "cuda/draco/draco_table.cuh"

namespace latticed::kernels {
namespace {

constexpr unsigned kThreads = 256;

struct Span {
  uint32_t least, most;
  __device__ uint32_t size() const { return most - least + 1; }
};

// The span of `count` values, read two at a time; they begin at a multiple of 4 bytes.
__device__ Span SpanOf(const uint16_t* values, uint32_t count) {
  __shared__ Span span;
  if (threadIdx.x == 0) span = {0xffff, 0};
  __syncthreads();
  const auto* pairs = reinterpret_cast<const uint32_t*>(values);
  uint32_t least = 0xffffffff, most = 0;
  for (uint32_t i = threadIdx.x; i < count / 2; i += kThreads) {
    const uint32_t pair = pairs[i];
    least = __vminu2(least, pair);
    most = __vmaxu2(most, pair);
  }
  if (count % 2 != 0 && threadIdx.x == 0) {
    const uint32_t last = values[count - 1];
    least = __vminu2(least, last | last << 16);
    most = __vmaxu2(most, last | last << 16);
  }
  least = __reduce_min_sync(kAllLanes, min(least & 0xffff, least >> 16));
  most = __reduce_max_sync(kAllLanes, max(most & 0xffff, most >> 16));
  if (Lane() == 0) {
    atomicMin(&span.least, least);
    atomicMax(&span.most, most);
  }
  __syncthreads();
  return span;
}

__device__ void PositionSymbolsOf(const uint16_t* values, uint32_t points, Span span,
                                  uint16_t* symbols, uint32_t* counts) {
  const uint32_t wrap = span.size();
#pragma unroll 2
  for (uint32_t i = threadIdx.x; i < points; i += kThreads) {
    for (uint32_t axis = 0; axis < kPositionValues; ++axis) {
      const uint16_t* plane = values + axis * points;
      const uint32_t previous = i == 0 ? span.least : __ldg(plane + i - 1);
      const uint32_t symbol = PositionSymbol(__ldg(plane + i), previous, wrap);
      symbols[kPositionValues * i + axis] = static_cast<uint16_t>(symbol);
      atomicAdd(counts + symbol, 1u);
    }
  }
}

// T: how values are stored.
template <class T>
__device__ void NormalSymbolsOf(const uint8_t* normals, uint32_t points, int bits,
                                uint16_t* symbols, uint32_t* counts) {
  const T* s = reinterpret_cast<const T*>(normals);
  const T* t = s + points;
  const int32_t top = OctahedralMax(bits);
  const auto value = [top](const T* from) { return min(int32_t{__ldg(from)}, top); };
#pragma unroll 2
  for (uint32_t i = threadIdx.x; i < points; i += kThreads) {
    OctahedralNormal previous;
    if (i > 0) previous = {value(s + i - 1), value(t + i - 1)};
    const OctahedralNormal n = NormalSymbols({value(s + i), value(t + i)}, previous, bits);
    const auto symbol_s = static_cast<uint32_t>(n.s), symbol_t = static_cast<uint32_t>(n.t);
    reinterpret_cast<uint32_t*>(symbols)[i] = symbol_s | symbol_t << 16;
    atomicAdd(counts + symbol_s, 1u);
    atomicAdd(counts + symbol_t, 1u);
  }
}

// Sets the padding to zero that is read together with a stream's last symbols.
__device__ void ZeroPadding(uint16_t* symbols, uint32_t points, uint32_t values) {
  const uint32_t i = points * values + threadIdx.x;
  if (i < StreamWords(points, values)) symbols[i] = 0;
}

// Counts in shared memory or, for a chunk of a wide span, in a slot of global memory.
struct Counts {
  uint32_t* positions;
  uint32_t* normals;
  uint32_t slot;  // kWideSlots: none
};

__device__ uint32_t TakeSlot(uint32_t* taken) {
  uint32_t slot = blockIdx.x % kWideSlots;
  while (atomicCAS(taken + slot, 0u, 1u) != 0) slot = (slot + 1) % kWideSlots;
  __threadfence();
  return slot;
}

__device__ Counts ZeroCounts(const DracoWork& work, uint32_t* shared, uint32_t span) {
  __shared__ uint32_t slot;
  const uint32_t most = 1u << work.position_bits;
  const bool wide = span > kSharedCounts;
  if (wide && threadIdx.x == 0) slot = TakeSlot(work.control->wide_taken);
  __syncthreads();
  Counts counts{shared, shared + min(most, kSharedCounts), kWideSlots};
  if (wide) {
    counts.slot = slot;
    counts.positions = work.wide_counts + size_t{slot} * most;
  }
  for (uint32_t i = threadIdx.x; i < span; i += kThreads) counts.positions[i] = 0;
  const uint32_t normals = work.normal_bits == 0 ? 0 : 1u << work.normal_bits;
  for (uint32_t i = threadIdx.x; i < normals; i += kThreads) counts.normals[i] = 0;
  __syncthreads();
  return counts;
}

// One past the largest symbol of normals; 0 without normals.
__device__ uint32_t NormalEnd(const DracoWork& work) {
  return work.normal_bits == 0 ? 0 : static_cast<uint32_t>(OctahedralMax(work.normal_bits)) + 1;
}

// Room for both tables of the chunk. Without room the chunk is deferred.
struct Room {
  uint32_t first_entry;
  bool found;
};
__device__ Room TakeRoom(const DracoWork& work, Span span) {
  __shared__ uint32_t first_entry;
  const uint32_t entries = span.size() + NormalEnd(work);
  if (threadIdx.x == 0) {
    first_entry = atomicAdd(&work.control->entries_used, entries);
    if (first_entry + entries > work.entry_room) {
      constexpr auto kDeferred = static_cast<uint8_t>(DracoFate::kDeferred);
      work.streams[2 * blockIdx.x].fate = work.streams[2 * blockIdx.x + 1].fate = kDeferred;
    }
  }
  __syncthreads();
  return {first_entry, first_entry + entries <= work.entry_room};
}

// Called by one warp. `span`: of the coordinates of positions.
__device__ void WriteTable(const DracoWork& work, bool normals, uint32_t* counts, Span span,
                           uint32_t first_entry) {
  __shared__ uint32_t lists[2][kListedCounts];
  const uint32_t chunk = blockIdx.x, values = normals ? kNormalValues : kPositionValues;
  TableBuilder table(counts, normals ? NormalEnd(work) : span.size(), work.Points(chunk) * values,
                     lists[normals ? 1 : 0]);
  DracoStream stream{.first_entry = first_entry,
                     .largest = table.largest(),
                     .least = static_cast<uint16_t>(span.least),
                     .most = static_cast<uint16_t>(span.most),
                     .bit_length = static_cast<uint8_t>(table.bit_length())};
  stream.table_bytes =
      table.Write(work.entries + first_entry, work.tables + size_t{first_entry} * kTableBytes);
  if (Lane() == 0) work.streams[2 * chunk + (normals ? 1 : 0)] = stream;
}

__global__ void __launch_bounds__(kThreads) SymbolsKernel(const __grid_constant__ DracoWork work) {
  extern __shared__ uint32_t shared[];
  const uint32_t chunk = blockIdx.x, points = work.Points(chunk);
  if (work.digests != nullptr && !IsCoded(work.streams[2 * chunk])) return;
  const auto* values = reinterpret_cast<const uint16_t*>(work.Vertices(chunk));
  const Span span = SpanOf(values, kPositionValues * points);
  const Room room = TakeRoom(work, span);
  if (!room.found) return;
  const Counts counts = ZeroCounts(work, shared, span.size());
  uint16_t* symbols = work.symbols + StreamAt(work, chunk, false);
  PositionSymbolsOf(values, points, span, symbols, counts.positions);
  ZeroPadding(symbols, points, kPositionValues);
  const auto* normals = reinterpret_cast<const uint8_t*>(values + kPositionValues * points);
  uint16_t* normal_symbols = work.symbols + StreamAt(work, chunk, true);
  if (work.normal_bits > 8) {
    NormalSymbolsOf<uint16_t>(normals, points, work.normal_bits, normal_symbols, counts.normals);
  } else if (work.normal_bits > 0) {
    NormalSymbolsOf<uint8_t>(normals, points, work.normal_bits, normal_symbols, counts.normals);
  }
  if (work.normal_bits > 0) ZeroPadding(normal_symbols, points, kNormalValues);
  __syncthreads();
  const unsigned warp = threadIdx.x / kWarp;
  if (warp == 0) WriteTable(work, false, counts.positions, span, room.first_entry);
  if (warp == 1 && work.normal_bits > 0) {
    WriteTable(work, true, counts.normals, span, room.first_entry + span.size());
  }
  if (counts.slot == kWideSlots) return;
  __syncthreads();
  if (threadIdx.x == 0) {
    __threadfence();
    atomicExch(work.control->wide_taken + counts.slot, 0u);
  }
}

}  // namespace

cudaError_t LaunchDracoSymbols(const DracoWork& work, cudaStream_t stream) {
  if (work.count == 0) return cudaSuccess;
  const uint32_t positions = 1u << work.position_bits,
                 normals = work.normal_bits == 0 ? 0 : 1u << work.normal_bits;
  const size_t shared =
      ((positions < kSharedCounts ? positions : kSharedCounts) + normals) * sizeof(uint32_t);
  SymbolsKernel<<<work.count, kThreads, shared, stream>>>(work);
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
