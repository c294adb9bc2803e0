// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A block takes a sparse chunk. A warp for each attribute chooses between RAW and TAGGED by bounds (draco_choice.cuh), and
// makes the tables that may be needed. Of few bits, symbols are counted one by one. Of more, they share counts, which
// suffices for the bounds, and a bit for each value says whether it occurs. Where these symbols need a table after all, the
// number of bits before one is its rank, and they are counted by rank.
#include "cuda/draco/draco_choice.cuh"

namespace latticed::kernels {
namespace {

// One for each attribute: while they make tables, more would wait.
constexpr unsigned kWarps = 2, kThreads = kWarps * kWarp;
// That a multiprocessor must hold at once; the compiler limits the registers to that.
constexpr unsigned kBlocksAtOnce = 16;

// Of symbols of more than kUnrankedBits bits. Those that are equal in their low bits share a count.
constexpr uint32_t kSharedCountsOfBounds = 1u << kUnrankedBits;

// The symbols of one attribute that occur, in shared memory.
struct Ranking {
  uint32_t* bits;    // of the values; null where they are not ranked
  uint32_t* counts;  // shared ones, or by rank
  uint16_t* before;  // by word of `bits`: the rank of its first symbol
  uint16_t* names;   // by rank: the symbol
  uint32_t words;    // of `bits`
  uint32_t room;     // of `counts`

  __device__ bool MayRank() const { return words > 0; }
  __device__ void ZeroBits() const {
    for (uint32_t i = threadIdx.x; i < words; i += kThreads) bits[i] = 0;
  }
  __device__ void ZeroCounts() const {
    for (uint32_t i = threadIdx.x; i < room; i += kThreads) counts[i] = 0;
  }
  template <uint32_t kValues>
  __device__ __forceinline__ void Take(const uint32_t (&symbols)[kValues]) const {
    for (const uint32_t symbol : symbols) {
      if (MayRank()) atomicOr(bits + symbol / 32, 1u << symbol % 32);
      atomicAdd(counts + symbol % kSharedCountsOfBounds, 1u);
    }
  }
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

// Each warp takes its share of the words.
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

// What a ranking of up to `symbols` symbols takes in shared memory.
struct RankingSize {
  uint32_t words, counts, names;

  LATTICED_HD RankingSize(uint32_t symbols, int32_t bits)
      : words(bits > kUnrankedBits ? (1u << bits) / 32 : 0),
        counts(words > 0 && symbols > kSharedCountsOfBounds ? symbols : kSharedCountsOfBounds),
        names(words > 0 ? symbols : 0) {}
  LATTICED_HD RankingSize() : words(0), counts(0), names(0) {}
  LATTICED_HD uint32_t Bytes() const {
    return static_cast<uint32_t>((words + counts) * sizeof(uint32_t) +
                                 (words + names) * sizeof(uint16_t));
  }
};
struct RankingSizes {
  RankingSize positions, normals;
  LATTICED_HD explicit RankingSizes(const DracoWork& work)
      : positions(kPositionValues * work.most_ranked, work.position_bits) {
    if (work.has_normals()) normals = {kNormalValues * work.most_ranked, work.normal_bits};
  }
};

// Takes the rankings of positions and of normals from shared memory.
struct Rankings {
  Ranking positions, normals;

  __device__ Rankings(const DracoWork& work, uint32_t* shared) {
    const RankingSizes sizes(work);
    uint32_t* words = shared;
    for (const bool is_normals : {false, true}) {
      const RankingSize& size = is_normals ? sizes.normals : sizes.positions;
      Ranking& ranking = is_normals ? normals : positions;
      ranking.bits = words;
      ranking.counts = words + size.words;
      ranking.words = size.words;
      ranking.room = size.counts;
      words += size.words + size.counts;
    }
    positions.before = reinterpret_cast<uint16_t*>(words);
    positions.names = positions.before + sizes.positions.words;
    normals.before = positions.names + sizes.positions.names;
    normals.names = normals.before + sizes.normals.words;
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

// An attribute of the block's chunk.
struct Attribute {
  DracoKind kind;
  Ranking ranking;
  int32_t bits;
  uint32_t symbols;    // how many
  DracoStream stream;  // what is known of it before there is a table
  uint32_t first_tag_entry;
  uint32_t place;  // 0: positions, 1: normals

  // By one warp. `size`: of the counts; `names`: of those by rank.
  __device__ MadeTable MakeTable(const DracoWork& work, uint32_t size,
                                 const uint16_t* names) const {
    __shared__ SymbolList<kListedSymbols> lists[2];
    const TableBuilder table(ranking.counts, size, symbols, lists[place].room(), names);
    DracoStream made = stream;
    made.ranked = names != nullptr;
    return {WriteTable(work, kind, table, made), table.MostBits()};
  }
  // By one warp: makes those tables that may be needed and need no ranks. Returns whether one by ranks is needed.
  __device__ bool Choose(const DracoWork& work, TagCounts& tags) const;
};

// The tables of a chunk lie one after the other: of positions, of normals, of the tags of both.
__device__ uint32_t TagsAt(const DracoWork& work, uint32_t first_entry) {
  return first_entry + RankedEntries(work, work.Points(blockIdx.x)) - TagEntries(work);
}
__device__ Attribute PositionsOf(const DracoWork& work, const Ranking& ranking,
                                 uint32_t first_entry, Span span) {
  return {.kind = DracoKind::kPositions,
          .ranking = ranking,
          .bits = work.position_bits,
          .symbols = kPositionValues * work.Points(blockIdx.x),
          .stream = {.first_entry = first_entry,
                     .least = static_cast<uint16_t>(span.least),
                     .most = static_cast<uint16_t>(span.most)},
          .first_tag_entry = TagsAt(work, first_entry),
          .place = 0};
}
__device__ Attribute NormalsOf(const DracoWork& work, const Ranking& ranking,
                               uint32_t first_entry) {
  const uint32_t points = work.Points(blockIdx.x);
  const uint32_t of_positions = RankedEntries(kPositionValues * points, work.position_bits);
  return {.kind = DracoKind::kNormals,
          .ranking = ranking,
          .bits = work.normal_bits,
          .symbols = kNormalValues * points,
          .stream = {.first_entry = first_entry + of_positions},
          .first_tag_entry = TagsAt(work, first_entry) + kTags,
          .place = 1};
}

__device__ void LeaveOut(const DracoWork& work, DracoKind kind, DracoStream stream) {
  stream.left_out = true;
  if (Lane() == 0) work.Stream(blockIdx.x, kind) = stream;
}

__device__ bool Attribute::Choose(const DracoWork& work, TagCounts& tags) const {
  const uint32_t points = work.Points(blockIdx.x);
  uint32_t* const tag_counts = tags.counts[place];
  if (ranking.MayRank()) {
    const MadeTable table = MakeTagTable(work, kind, tags, first_tag_entry);
    const Occurring occurring(ranking.bits, ranking.words);
    if (!TaggedWins(table, points, occurring, ranking.counts, kSharedCountsOfBounds, symbols)) {
      return true;
    }
    DracoStream known = stream;
    known.largest = occurring.largest;
    LeaveOut(work, kind, known);
    return false;
  }
  const MadeTable table = MakeTable(work, 1u << bits, nullptr);
  if (RawWins(table, symbols, tag_counts, TaggedBits(kind, tag_counts), points)) {
    LeaveOut(work, TagsOf(kind), {});
  } else {
    MakeTagTable(work, kind, tags, first_tag_entry);
  }
  return false;
}

// By all warps.
__device__ void MakeRankedTable(const DracoWork& work, const Attribute& attribute) {
  const Ranking& ranking = attribute.ranking;
  ranking.ZeroCounts();
  const uint32_t occurring = ranking.Name();
  WriteRanks(work, attribute.kind, ranking);
  __syncthreads();
  if (RoleOfWarp() == attribute.place) attribute.MakeTable(work, occurring, ranking.names);
}

// Zeros, once all threads have passed a barrier.
__device__ void Zero(const Rankings& rankings, TagCounts& tags) {
  for (const Ranking* ranking : {&rankings.positions, &rankings.normals}) {
    ranking->ZeroBits();
    ranking->ZeroCounts();
  }
  tags.Zero();
}

__device__ void WriteAndCount(const DracoWork& work, Span span, const Rankings& rankings,
                              TagCounts& tags) {
  const TagSink position_tags(work, DracoKind::kPositions, tags.counts[0]);
  const TagSink normal_tags(work, DracoKind::kNormals, tags.counts[1]);
  WriteSymbols(
      work, span,
      [&](uint32_t i, const auto& symbols) {
        rankings.positions.Take(symbols);
        position_tags.Take(i, symbols);
      },
      [&](uint32_t i, const auto& symbols) {
        rankings.normals.Take(symbols);
        normal_tags.Take(i, symbols);
      });
}

__global__ void __launch_bounds__(kThreads, kBlocksAtOnce)
    RankedKernel(const __grid_constant__ DracoWork work) {
  extern __shared__ uint32_t shared[];
  __shared__ TagCounts tags;
  __shared__ bool by_ranks[2];
  __shared__ uint32_t first_entry;
  const uint32_t chunk = blockIdx.x, points = work.Points(chunk);
  if (!IsRanked(work, points)) return;
  if (SkipUnchanged(work)) return;
  const uint32_t entries = RankedEntries(work, points);
  // Answered by the time the span is known.
  if (threadIdx.x == 0) first_entry = atomicAdd(&work.draco_control->entries_used, entries);
  const Rankings rankings(work, shared);
  Zero(rankings, tags);
  const Span span =
      SpanOf(reinterpret_cast<const uint16_t*>(work.Vertices(chunk)), kPositionValues * points);
  const bool has_bits = span.size() <= 1u << work.position_bits;  // or else no encoder has
  if (!has_bits || first_entry + entries > work.entry_room) {
    if (threadIdx.x == 0) Skip(work);
    return;
  }
  WriteAndCount(work, span, rankings, tags);
  __syncthreads();

  const Attribute positions = PositionsOf(work, rankings.positions, first_entry, span);
  const Attribute normals = NormalsOf(work, rankings.normals, first_entry);
  const uint32_t role = RoleOfWarp();
  if (role == 0) by_ranks[0] = positions.Choose(work, tags);
  if (role == 1) by_ranks[1] = work.has_normals() && normals.Choose(work, tags);
  __syncthreads();
  if (by_ranks[0]) MakeRankedTable(work, positions);
  if (by_ranks[1]) MakeRankedTable(work, normals);
}

}  // namespace

cudaError_t LaunchDracoRanked(const DracoWork& work, cudaStream_t stream) {
  if (work.count == 0 || work.most_ranked == 0) return cudaSuccess;
  const RankingSizes sizes(work);
  const uint32_t shared = sizes.positions.Bytes() + sizes.normals.Bytes();
  RankedKernel<<<work.count, kThreads, shared, stream>>>(work);
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
