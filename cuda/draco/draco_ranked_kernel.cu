// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A block takes a sparse chunk. It has few symbols, among many values: a bit for each value says whether it occurs, and
// the number of bits before it is its rank. Symbols are counted by rank, and tables are made of the ranks that there are.
#include "cuda/draco/draco_symbols.cuh"

namespace latticed::kernels {
namespace {

constexpr unsigned kWarps = 4, kThreads = kWarps * kWarp;

// The symbols of one attribute that occur, in shared memory.
struct Ranking {
  uint32_t* bits;    // of the values
  uint32_t* counts;  // by rank
  uint16_t* before;  // by word of `bits`: the rank of its first symbol
  uint16_t* names;   // by rank: the symbol
  uint32_t words;    // of `bits`
  uint32_t room;     // ranks

  __device__ void Zero() const {
    for (uint32_t i = threadIdx.x; i < words; i += kThreads) bits[i] = 0;
    for (uint32_t i = threadIdx.x; i < room; i += kThreads) counts[i] = 0;
  }
  __device__ void Mark(uint32_t symbol) const { atomicOr(bits + symbol / 32, 1u << symbol % 32); }
  __device__ uint32_t RankOf(uint32_t symbol) const {
    const uint32_t below = bits[symbol / 32] & ((1u << symbol % 32) - 1);
    return before[symbol / 32] + static_cast<uint32_t>(__popc(below));
  }
  // Sets `before` and `names` when all symbols are marked, and returns how many occur.
  __device__ uint32_t Name() const;
};

// Of a word that is not 0.
__device__ __forceinline__ uint32_t LowestBit(uint32_t word) {
  return static_cast<uint32_t>(__ffs(static_cast<int>(word))) - 1;
}

// Each warp takes a quarter of the words.
__device__ uint32_t Ranking::Name() const {
  __shared__ uint32_t sums[kWarps];
  const uint32_t warp = threadIdx.x / kWarp;
  const uint32_t share = (words + kThreads - 1) / kThreads * kWarp;
  const uint32_t first = warp * share, end = min(first + share, words);
  uint32_t sum = 0;
  for (uint32_t base = first; base < end; base += kWarp) {
    const uint32_t i = base + Lane();
    const uint32_t count = i < end ? static_cast<uint32_t>(__popc(bits[i])) : 0;
    const uint32_t up_to = sum + SumUpTo(count);
    if (i < end) before[i] = static_cast<uint16_t>(up_to - count);
    sum = __shfl_sync(kAllLanes, up_to, kWarp - 1);
  }
  if (Lane() == 0) sums[warp] = sum;
  __syncthreads();
  uint32_t earlier = 0, all = 0;
  for (uint32_t w = 0; w < kWarps; ++w) {
    if (w < warp) earlier += sums[w];
    all += sums[w];
  }
  for (uint32_t i = first + Lane(); i < end; i += kWarp) {
    uint32_t rank = before[i] + earlier;
    before[i] = static_cast<uint16_t>(rank);
    for (uint32_t left = bits[i]; left != 0; left &= left - 1) {
      names[rank++] = static_cast<uint16_t>(32 * i + LowestBit(left));
    }
  }
  __syncthreads();
  return all;
}

LATTICED_HD uint32_t WordsOf(int32_t bits) { return (1u << bits) / 32; }

// The bytes of a ranking in shared memory.
uint32_t RankingBytes(uint32_t room, int32_t bits) {
  return (room + WordsOf(bits)) * (sizeof(uint32_t) + sizeof(uint16_t));
}

// Takes the rankings of positions and of normals from shared memory.
struct Rankings {
  Ranking positions, normals;

  __device__ Rankings(const DracoWork& work, uint32_t* shared) {
    positions.room = kPositionValues * work.most_ranked;
    positions.words = WordsOf(work.position_bits);
    normals.room = work.has_normals() ? kNormalValues * work.most_ranked : 0;
    normals.words = work.has_normals() ? WordsOf(work.normal_bits) : 0;
    positions.bits = shared;
    positions.counts = positions.bits + positions.words;
    normals.bits = positions.counts + positions.room;
    normals.counts = normals.bits + normals.words;
    positions.before = reinterpret_cast<uint16_t*>(normals.counts + normals.room);
    positions.names = positions.before + positions.words;
    normals.before = positions.names + positions.room;
    normals.names = normals.before + normals.words;
  }
};

// Writes the rank of each symbol, and counts it.
__device__ void WriteRanks(const DracoWork& work, DracoKind kind, const Ranking& ranking) {
  const uint32_t chunk = blockIdx.x, points = work.Points(chunk);
  const size_t at = StreamAt(work, chunk, kind);
  for (uint32_t i = threadIdx.x; i < points * ValuesOf(kind); i += kThreads) {
    const uint32_t rank = ranking.RankOf(work.symbols[at + i]);
    work.ranks[at + i] = static_cast<uint16_t>(rank);
    atomicAdd(ranking.counts + rank, 1u);
  }
  ZeroPadding(work.ranks + at, points, kind);
}

// Called by one warp. `symbols`: how many occur.
__device__ void WriteRankedTable(const DracoWork& work, DracoKind kind, const Ranking& ranking,
                                 uint32_t symbols, DracoStream stream) {
  __shared__ uint32_t lists[2][kListedCounts];
  const TableBuilder table(ranking.counts, symbols, work.Points(blockIdx.x) * ValuesOf(kind),
                           lists[kind == DracoKind::kPositions ? 0 : 1], ranking.names);
  stream.ranked = true;
  WriteTable(work, kind, table, stream);
}

__global__ void __launch_bounds__(kThreads) RankedKernel(const __grid_constant__ DracoWork work) {
  extern __shared__ uint32_t shared[];
  __shared__ TagCounts tags;
  const uint32_t chunk = blockIdx.x, points = work.Points(chunk);
  if (!IsRanked(work, points)) return;
  if (work.digests != nullptr && !IsCoded(work.Stream(chunk, DracoKind::kPositions))) return;
  const Span span =
      SpanOf(reinterpret_cast<const uint16_t*>(work.Vertices(chunk)), kPositionValues * points);
  if (span.size() > 1u << work.position_bits) {  // no encoder has bits for them
    if (threadIdx.x == 0) Defer(work);
    return;
  }
  const Room room = TakeRoom(work, RankedEntries(work, points));
  if (!room.found) return;
  const Rankings rankings(work, shared);
  const Ranking &positions = rankings.positions, &normals = rankings.normals;
  positions.Zero();
  normals.Zero();
  tags.Zero();
  __syncthreads();
  WriteSymbols(
      work, span, [&](uint32_t symbol) { positions.Mark(symbol); },
      [&](uint32_t symbol) { normals.Mark(symbol); });
  __syncthreads();
  const uint32_t position_symbols = positions.Name(), normal_symbols = normals.Name();
  WriteRanks(work, DracoKind::kPositions, positions);
  WriteTags(work, DracoKind::kPositions, tags.counts[0]);
  if (work.has_normals()) {
    WriteRanks(work, DracoKind::kNormals, normals);
    WriteTags(work, DracoKind::kNormals, tags.counts[1]);
  }
  __syncthreads();
  const unsigned warp = threadIdx.x / kWarp;
  if (warp == 0) {
    WriteRankedTable(work, DracoKind::kPositions, positions, position_symbols,
                     {.first_entry = room.first_entry,
                      .least = static_cast<uint16_t>(span.least),
                      .most = static_cast<uint16_t>(span.most)});
  }
  uint32_t next = room.first_entry + RankedEntries(kPositionValues * points, work.position_bits);
  if (work.has_normals()) {
    if (warp == 1) {
      WriteRankedTable(work, DracoKind::kNormals, normals, normal_symbols, {.first_entry = next});
    }
    next += RankedEntries(kNormalValues * points, work.normal_bits);
  }
  WriteTagTables(work, tags, next);
}

}  // namespace

cudaError_t LaunchDracoRanked(const DracoWork& work, cudaStream_t stream) {
  if (work.count == 0 || work.most_ranked == 0) return cudaSuccess;
  uint32_t shared = RankingBytes(kPositionValues * work.most_ranked, work.position_bits);
  if (work.has_normals()) {
    shared += RankingBytes(kNormalValues * work.most_ranked, work.normal_bits);
  }
  RankedKernel<<<work.count, kThreads, shared, stream>>>(work);
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
