// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One lane codes one stream. Its state takes the symbols, the last one first, and each step waits for the
// one before. So a warp that codes does nothing else. A second warp loads symbols and entries ahead, takes
// the entries apart, and leaves them in shared memory, 32 symbols of each stream at a time. The bytes that
// leave a state are stored with gaps and packed later (draco_pack_kernel.cu).
#include "cuda/device/kernel_call.h"
#include "cuda/draco/draco_leaving.cuh"
#include "cuda/draco/draco_table.cuh"

namespace latticed::kernels {
namespace {

// Pairs of warps in a block: the schedulers of a multiprocessor. Warps 0 to 3 code, and warps 4 to 7
// prepare; a scheduler has one of each.
constexpr uint32_t kPairs = 4;
constexpr uint32_t kThreads = 2 * kPairs * kWarp;
// The symbols of a stream that a round prepares and codes, one for each lane.
constexpr uint32_t kRound = kWarp;

// A stream of at most 12 bits. count 0: there is none.
struct ShortStream {
  const uint16_t* symbols;
  const uint2* entries;
  uint32_t count;
};

// What a round codes, of each symbol and stream. The stride is odd, so that neither the warp that writes symbols
// beside each other nor the one that reads streams meets a bank twice.
template <uint32_t kStreams>
struct PreparedRound {
  ShortEntry entries[kRound][kStreams + 1];
};
// While one is coded the other one is prepared.
template <uint32_t kStreams>
using PairRounds = PreparedRound<kStreams>[2];

// Both warps of a pair wait for each other; what one wrote before, the other reads after. Barrier 0 is the block's.
__device__ __forceinline__ void Meet(uint32_t pair) {
  asm volatile("barrier.sync %0, %1;" ::"r"(pair + 1), "n"(2 * kWarp) : "memory");
}

// The warp that prepares. Each lane has one symbol of every stream. Symbols are loaded two rounds ahead, and entries one.
template <uint32_t kStreams>
class Preparer {
 public:
  __device__ explicit Preparer(const ShortStream (&streams)[kStreams]) : streams_(streams) {}

  __device__ void Prepare(uint32_t rounds, uint32_t pair, PairRounds<kStreams>& prepared) {
    Load(rounds - 1);
    Gather(rounds - 1);
    Load(rounds - 2);
    for (uint32_t round = rounds; round-- > 0;) {
#pragma unroll
      for (uint32_t i = 0; i < kStreams; ++i) {
        prepared[round % 2].entries[Lane()][i] = TakeApart(entries_[i]);
      }
      Gather(round - 1);
      Load(round - 2);
      Meet(pair);
    }
  }

 private:
  // Before the first round there is none.
  __device__ __forceinline__ bool IsThere(uint32_t round, const ShortStream& stream) const {
    return static_cast<int32_t>(round) >= 0 && round * kRound + Lane() < stream.count;
  }
  __device__ __forceinline__ void Load(uint32_t round) {
#pragma unroll
    for (uint32_t i = 0; i < kStreams; ++i) {
      if (!IsThere(round, streams_[i])) continue;
      symbols_[i] = __ldg(streams_[i].symbols + round * kRound + Lane());
    }
  }
  __device__ __forceinline__ void Gather(uint32_t round) {
#pragma unroll
    for (uint32_t i = 0; i < kStreams; ++i) {
      // Past the last symbol, p = M, which changes no state.
      entries_[i] = IsThere(round, streams_[i]) ? __ldg(streams_[i].entries + symbols_[i])
                                                : MakeShortEntry(kShortM, 0);
    }
  }

  const ShortStream (&streams_)[kStreams];  // in shared memory
  uint16_t symbols_[kStreams] = {};
  uint2 entries_[kStreams];
};

// A lane of the warp that codes.
class Coder {
 public:
  static constexpr uint32_t kPart = 8;  // symbols of a store of 16 bytes

  // `column`: the stream's entries of a round. The first `stored` symbols of the round have room in `leaving`, and two bits
  // each in `leaving_bytes`. The others change nothing.
  template <uint32_t kStride>
  __device__ __forceinline__ void Code(const ShortEntry (*column)[kStride], uint32_t stored,
                                       uint16_t* leaving, uint16_t* leaving_bytes) {
    // Loaded a part ahead, for shared memory takes as long as a step. Unrolled, or the loads wait at the loop's end.
    ShortEntry ahead[kPart];
#pragma unroll
    for (uint32_t k = 0; k < kPart; ++k) ahead[k] = column[kRound - kPart + k][0];
#pragma unroll
    for (uint32_t end = kRound; end > 0; end -= kPart) {
      const uint32_t first = end - kPart;
      uint32_t low[kPart], counts = 0;
#pragma unroll
      for (uint32_t k = kPart; k-- > 0;) {
        const uint32_t bits = LeavingBits(x_, ahead[k]);
        low[k] = x_;
        counts |= bits / 8 << (2 * k);
        bits_ += bits;
        x_ = ShortStep(x_, bits, ahead[k]);
        if (first > 0) ahead[k] = column[first - kPart + k][0];
      }
      if (first < stored) Store(low, counts, leaving + first, leaving_bytes[first / kPart]);
    }
  }

  __device__ uint32_t state() const { return x_; }
  __device__ uint32_t bytes() const { return bits_ / 8; }

 private:
  __device__ __forceinline__ static void Store(const uint32_t (&low)[kPart], uint32_t counts,
                                               uint16_t* leaving, uint16_t& leaving_bytes) {
    constexpr uint32_t kLowHalves = 0x5410;
    *reinterpret_cast<uint4*>(leaving) = {
        __byte_perm(low[0], low[1], kLowHalves), __byte_perm(low[2], low[3], kLowHalves),
        __byte_perm(low[4], low[5], kLowHalves), __byte_perm(low[6], low[7], kLowHalves)};
    leaving_bytes = static_cast<uint16_t>(counts);
  }

  uint32_t x_ = 4 * kShortM, bits_ = 0;
};

// The last state's bytes, as FinishRans of core/codec/rans_encoder.h.
__device__ void Finish(uint32_t x, int precision, uint32_t bytes, DracoStream& stream) {
  const uint32_t above = x - (4u << precision);
  const uint32_t more = above < 1u << 6 ? 0 : above < 1u << 14 ? 1 : above < 1u << 22 ? 2 : 3;
  stream.last_word = above | more << (8 * more + 6);
  stream.coded_bytes = bytes + more + 1;
}

// Stores the bytes one after the other while there is room. A stream with more is sent as plain symbols.
__device__ void CodeLong(const uint16_t* symbols, uint32_t count, const uint2* entries,
                         uint8_t* leaving, DracoStream& stream) {
  const int precision = RansPrecision(stream.bit_length);
  uint32_t x = 4u << precision, bytes = 0;
  for (uint32_t i = count; i > 0; --i) {
    const uint2 entry = entries[symbols[i - 1]];
    for (; x >= entry.x << 10; x >>= 8) {
      if (bytes < 2 * count) leaving[bytes] = static_cast<uint8_t>(x);
      ++bytes;
    }
    x = LongStep(x, entry, precision);
  }
  Finish(x, precision, bytes, stream);
}

// Null when there is none to code.
__device__ DracoStream* StreamOf(const DracoWork& work, uint32_t chunk, DracoKind kind) {
  if (chunk >= work.count) return nullptr;
  DracoStream* stream = &work.Stream(chunk, kind);
  return HasTable(*stream) ? stream : nullptr;
}
// The places of its symbols in its table.
__device__ const uint16_t* PlacesOf(const DracoWork& work, const DracoStream& stream, size_t at) {
  return (stream.ranked ? work.ranks : work.symbols) + at;
}

__device__ bool IsShort(const DracoStream& stream) {
  return RansPrecision(stream.bit_length) == kLeastRansPrecision;
}

// A lane's stream, as the warp that codes sees it.
__device__ void CodeStream(const DracoWork& work, uint32_t chunk, DracoKind kind,
                           const Coder& coder, DracoStream& stream) {
  if (IsShort(stream)) return Finish(coder.state(), kLeastRansPrecision, coder.bytes(), stream);
  const size_t at = StreamAt(work, chunk, kind);
  CodeLong(PlacesOf(work, stream, at), work.Points(chunk) * ValuesOf(kind),
           work.entries + stream.first_entry, reinterpret_cast<uint8_t*>(work.leaving + at),
           stream);
}

template <uint32_t kStreams>
__global__ void __launch_bounds__(kThreads) RansKernel(const __grid_constant__ DracoWork work) {
  extern __shared__ uint4 rounds_memory[];
  __shared__ ShortStream pair_streams[kPairs][kStreams];
  const uint32_t pair = threadIdx.x / kWarp % kPairs;
  const bool codes = threadIdx.x / kWarp < kPairs;
  const uint32_t pairs = (work.count + kStreams - 1) / kStreams;  // of one kind
  const uint32_t at = blockIdx.x * kPairs + pair;
  if (at >= work.Kinds() * pairs) return;  // both warps
  const DracoKind kind = work.KindOf(at / pairs);
  const uint32_t chunk = at % pairs * kStreams + Lane();
  DracoStream* const stream = Lane() < kStreams ? StreamOf(work, chunk, kind) : nullptr;

  ShortStream mine{};
  size_t words = 0;
  if (stream != nullptr && IsShort(*stream)) {
    words = StreamAt(work, chunk, kind);
    mine = {PlacesOf(work, *stream, words), work.entries + stream->first_entry,
            work.Points(chunk) * ValuesOf(kind)};
  }
  const uint32_t rounds = (__reduce_max_sync(kAllLanes, mine.count) + kRound - 1) / kRound;
  auto& prepared = reinterpret_cast<PairRounds<kStreams>*>(rounds_memory)[pair];
  if (!codes) {
    if (Lane() < kStreams) pair_streams[pair][Lane()] = mine;
    __syncwarp();
    Preparer<kStreams>(pair_streams[pair]).Prepare(rounds, pair, prepared);
    return;
  }
  Coder coder;
  // Lanes without a stream code what their neighbours do, and store nothing.
  const uint32_t column = min(Lane(), kStreams - 1);
  const uint32_t stored = GroupsOf(mine.count) * kSymbolsAWord;
  auto* const leaving_bytes = reinterpret_cast<uint16_t*>(work.leaving_bytes);
  for (uint32_t round = rounds; round-- > 0;) {
    Meet(pair);
    const uint32_t first = round * kRound;
    const auto* entries = &prepared[round % 2].entries[0][column];
    coder.Code(reinterpret_cast<const ShortEntry(*)[kStreams + 1]>(entries),
               first < stored ? stored - first : 0, work.leaving + words + first,
               leaving_bytes + (words + first) / Coder::kPart);
  }
  if (stream != nullptr) CodeStream(work, chunk, kind, coder, *stream);
}

template <uint32_t kStreams>
cudaError_t Launch(const DracoWork& work, cudaStream_t stream) {
  const uint32_t pairs = work.Kinds() * ((work.count + kStreams - 1) / kStreams);
  return KernelCall(RansKernel<kStreams>, Order::kAfter, (pairs + kPairs - 1) / kPairs, kThreads,
                    kPairs * sizeof(PairRounds<kStreams>), work)
      .Launch(stream);
}

}  // namespace

cudaError_t LaunchDracoRans(const DracoWork& work, cudaStream_t stream) {
  // Few streams keep one pair on each scheduler, of which a large device has about 500. With many, a pair of eight streams
  // is best: preparing more of them takes longer than coding one.
  constexpr uint32_t kFew = 1000, kFewStreams = 4, kManyStreams = 8;
  if (work.count == 0) return cudaSuccess;
  return work.count <= kFew ? Launch<kFewStreams>(work, stream)
                            : Launch<kManyStreams>(work, stream);
}

}  // namespace latticed::kernels
