// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A block takes a chunk. All its threads find the span of the coordinates, the symbols of all points and
// their counts. Then one warp makes each table.
#include "cuda/draco/draco_choice.cuh"

namespace latticed::kernels {
namespace {

constexpr unsigned kThreads = 256;
// That a multiprocessor must hold at once; the compiler limits the registers to that.
constexpr unsigned kBlocksAtOnce = 6;

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

__device__ Counts ZeroCounts(const DracoWork& work, uint32_t* shared, uint32_t span,
                             TagCounts& tags) {
  __shared__ uint32_t slot;
  const uint32_t most = 1u << work.position_bits;
  const bool wide = span > kSharedCounts;
  if (wide && threadIdx.x == 0) slot = TakeSlot(work.draco_control->wide_taken);
  __syncthreads();
  Counts counts{shared, shared + min(most, kSharedCounts), kWideSlots};
  if (wide) {
    counts.slot = slot;
    counts.positions = work.wide_counts + size_t{slot} * most;
  }
  for (uint32_t i = threadIdx.x; i < span; i += kThreads) counts.positions[i] = 0;
  const uint32_t normals = work.normal_bits == 0 ? 0 : 1u << work.normal_bits;
  for (uint32_t i = threadIdx.x; i < normals; i += kThreads) counts.normals[i] = 0;
  if (work.sparse) tags.Zero();
  __syncthreads();
  return counts;
}

// One past the largest symbol of normals; 0 without normals.
__device__ uint32_t NormalEnd(const DracoWork& work) {
  return work.normal_bits == 0 ? 0 : static_cast<uint32_t>(OctahedralMax(work.normal_bits)) + 1;
}

// Writes the symbols, and of sparse chunks the tags, and counts them. All counts are zero before.
template <bool kSparse>
__device__ __forceinline__ void WriteAndCount(const DracoWork& work, Span span,
                                              const Counts& counts, TagCounts& tags) {
  const auto count_in = [](uint32_t* its, const auto& symbols) {
    for (const uint32_t symbol : symbols) atomicAdd(its + symbol, 1u);
  };
  if constexpr (!kSparse) {
    WriteSymbols(
        work, span, [&](uint32_t, const auto& its) { count_in(counts.positions, its); },
        [&](uint32_t, const auto& its) { count_in(counts.normals, its); });
  } else {
    const TagSink position_tags(work, DracoKind::kPositions, tags.counts[0]);
    const TagSink normal_tags(work, DracoKind::kNormals, tags.counts[1]);
    WriteSymbols(
        work, span,
        [&](uint32_t i, const auto& its) {
          count_in(counts.positions, its);
          position_tags.Take(i, its);
        },
        [&](uint32_t i, const auto& its) {
          count_in(counts.normals, its);
          normal_tags.Take(i, its);
        });
  }
}

// kSparse: DracoWork::sparse.
template <bool kSparse>
__global__ void __launch_bounds__(kThreads, kBlocksAtOnce)
    SymbolsKernel(const __grid_constant__ DracoWork work) {
  extern __shared__ uint32_t shared[];
  __shared__ SymbolList<kListedSymbols> lists[2];
  __shared__ TagCounts tags;
  const uint32_t chunk = blockIdx.x, points = work.Points(chunk);
  if (IsRanked(work, points)) return;
  if (SkipUnchanged(work)) return;
  const Span span =
      SpanOf(reinterpret_cast<const uint16_t*>(work.Vertices(chunk)), kPositionValues * points);
  const uint32_t entries = span.size() + NormalEnd(work);
  const Room room = TakeRoom(work, entries + TagEntries(work));
  if (!room.found) return;
  const Counts counts = ZeroCounts(work, shared, span.size(), tags);
  WriteAndCount<kSparse>(work, span, counts, tags);
  __syncthreads();
  const uint32_t role = RoleOfWarp();
  if (role == 0) {
    const TableBuilder table(counts.positions, span.size(), points * kPositionValues,
                             lists[0].room());
    WriteTable(work, DracoKind::kPositions, table,
               {.first_entry = room.first_entry,
                .least = static_cast<uint16_t>(span.least),
                .most = static_cast<uint16_t>(span.most)});
  }
  if (role == 1 && work.has_normals()) {
    const TableBuilder table(counts.normals, NormalEnd(work), points * kNormalValues,
                             lists[1].room());
    WriteTable(work, DracoKind::kNormals, table, {.first_entry = room.first_entry + span.size()});
  }
  if constexpr (kSparse) {
    const uint32_t tags_at = room.first_entry + entries;
    if (role == 2) MakeTagTable(work, DracoKind::kPositions, tags, tags_at);
    if (role == 3 && work.has_normals()) {
      MakeTagTable(work, DracoKind::kNormals, tags, tags_at + kTags);
    }
  }
  if (counts.slot == kWideSlots) return;
  __syncthreads();
  if (threadIdx.x == 0) {
    __threadfence();
    atomicExch(work.draco_control->wide_taken + counts.slot, 0u);
  }
}

}  // namespace

cudaError_t LaunchDracoSymbols(const DracoWork& work, cudaStream_t stream) {
  if (work.count == 0 || work.all_ranked) return cudaSuccess;
  const uint32_t positions = 1u << work.position_bits,
                 normals = work.normal_bits == 0 ? 0 : 1u << work.normal_bits;
  const size_t shared =
      ((positions < kSharedCounts ? positions : kSharedCounts) + normals) * sizeof(uint32_t);
  if (work.sparse) {
    SymbolsKernel<true><<<work.count, kThreads, shared, stream>>>(work);
  } else {
    SymbolsKernel<false><<<work.count, kThreads, shared, stream>>>(work);
  }
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
