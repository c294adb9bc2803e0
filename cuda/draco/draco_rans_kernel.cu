// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One lane codes one stream. Its state takes the symbols, the last one first, and each step waits for the
// one before. So a warp that codes does nothing but steps (rans_entry.h). Other warps do the rest, 32 symbols of each stream
// at a time: they load symbols and entries ahead, and leave the entries in shared memory; and they store which bytes leave
// the states that they find there. These are stored with gaps and packed later (draco_pack_kernel.cu).
#include "cuda/device/kernel_call.h"
#include "cuda/draco/draco_leaving.cuh"
#include "cuda/draco/draco_table.cuh"

namespace latticed::kernels {
namespace {

// A block codes the streams of one kind of so many chunks, one for each lane of the warp that codes.
constexpr uint32_t kStreams = kWarp;
// The symbols of a stream in a round, one for each lane of a warp that helps.
constexpr uint32_t kRound = kWarp;
// Warps that help, and the streams of each. A scheduler of the multiprocessor takes every fourth warp.
constexpr uint32_t kHelpers = 8, kOwn = kStreams / kHelpers, kSchedulers = 4;
constexpr uint32_t kWarps = (kHelpers + kSchedulers - 2) / (kSchedulers - 1) * kSchedulers;
// That a multiprocessor must hold at once; the compiler limits the registers to that.
constexpr unsigned kBlocksAtOnce = 2;

// A stream of at most 12 bits. Without symbols there is none.
struct ShortStream {
  uint32_t count;        // of symbols
  uint32_t first_entry;  // of its table
  size_t at;             // of its symbols
  bool ranked;
};

// The entries of a round's symbols, and the states before each. The strides are such that no warp meets a bank twice.
struct Round {
  ShortEntry entries[kRound][kStreams + 1];
  float states[kStreams][kRound + 4];
};
// While one round is coded, the next one is prepared.
struct BlockMemory {
  Round rounds[2];
  float last_states[kStreams];
};

// The warp that codes and those that help wait for each other; what one wrote before, the others read after. Barrier 0 is for all
// warps of a block.
__device__ __forceinline__ void Meet() {
  asm volatile("barrier.sync 1, %0;" ::"n"((1 + kHelpers) * kWarp) : "memory");
}

struct DeviceArithmetic {
  static __device__ float ClampedSum(float a, float b) { return __saturatef(__fadd_rn(a, b)); }
  static __device__ float MultiplyAdd(float a, float b, float c) { return __fmaf_rn(a, b, c); }
  static __device__ float MultiplyAddDown(float a, float b, float c) { return __fmaf_rd(a, b, c); }
};

// Keeps a pointer in registers: from its parts, each address would take four instructions instead of one.
template <class T>
__device__ __forceinline__ void Keep(T*& pointer) {
  asm volatile("" : "+l"(pointer));
}

// A warp that helps kOwn streams. Each lane has one symbol of every stream. Symbols are loaded two rounds ahead,
// and entries one.
class Helper {
 public:
  // `mine`: of a lane, its stream. It helps those from `first` on.
  __device__ Helper(const DracoWork& work, const ShortStream& mine, uint32_t first,
                    BlockMemory& memory)
      : memory_(memory), first_(first) {
    uint32_t least = 0xffffffff;
#pragma unroll
    for (uint32_t i = 0; i < kOwn; ++i) {
      counts_[i] = __shfl_sync(kAllLanes, mine.count, first + i);
      least = min(least, counts_[i]);
      const size_t at = __shfl_sync(kAllLanes, mine.at, first + i) + Lane();
      const bool ranked = __shfl_sync(kAllLanes, mine.ranked, first + i);
      symbols_at_[i] = (ranked ? work.ranks : work.symbols) + at;
      entries_at_[i] = work.entries + __shfl_sync(kAllLanes, mine.first_entry, first + i);
      leaving_at_[i] = work.leaving + at;
      Keep(symbols_at_[i]);
      Keep(entries_at_[i]);
      Keep(leaving_at_[i]);
    }
    full_ = least / kRound;
    const uint32_t its = first + Lane() / kHalves;  // this lane stores a half of its rounds
    const uint32_t its_groups = GroupsOf(__shfl_sync(kAllLanes, mine.count, its));
    my_groups_ = Lane() < kHalves * kOwn ? its_groups : 0;
    my_words_ = work.leaving_bytes + __shfl_sync(kAllLanes, mine.at, its) / kSymbolsAWord +
                Lane() % kHalves;
    Keep(my_words_);
  }

  __device__ void Run(uint32_t rounds) {
    Load<false>(rounds - 1);
    Gather<false>(rounds - 1);
    Load<false>(rounds - 2);
    uint32_t round = rounds;  // one above the next
    // Rounds that need no conditions are a loop of their own, whose loads may still be on their way when it begins anew.
    for (; round > 0 && round + 1 >= full_; --round) Turn<false>(rounds, round - 1);
    for (; round > 2; --round) Turn<true>(rounds, round - 1);
    for (; round > 0; --round) Turn<false>(rounds, round - 1);
    if (rounds > 1) Store<false>(1);
#pragma unroll
    for (uint32_t i = 0; i < kOwn; ++i) above_[0][i] = above_[1][i];
    Meet();
    if (rounds > 0) Store<false>(0);
  }
  // The bytes that left the state of stream first + Lane().
  __device__ uint32_t bytes() const {
    const uint32_t both = bytes_ + __shfl_down_sync(kAllLanes, bytes_, 1);
    return __shfl_sync(kAllLanes, both, Lane() * kHalves);
  }

 private:
  static constexpr uint32_t kHalves = kRound / kSymbolsAWord;

  // While `round` + 1 is coded. kFull: all its streams have all symbols of the rounds from `round` - 2 to `round` + 2.
  template <bool kFull>
  __device__ __forceinline__ void Turn(uint32_t rounds, uint32_t round) {
    if (kFull || round + 2 < rounds) Store<kFull>(round + 2);
    Prepare(round);
    Gather<kFull>(round - 1);
    Load<kFull>(round - 2);
    Meet();
  }

  // Before the first round there is none.
  template <bool kFull>
  __device__ __forceinline__ bool IsThere(uint32_t round, uint32_t i) const {
    return kFull || (static_cast<int32_t>(round) >= 0 && round * kRound + Lane() < counts_[i]);
  }
  template <bool kFull>
  __device__ __forceinline__ void Load(uint32_t round) {
#pragma unroll
    for (uint32_t i = 0; i < kOwn; ++i) {
      if (IsThere<kFull>(round, i)) symbols_[i] = __ldg(symbols_at_[i] + round * kRound);
    }
  }
  template <bool kFull>
  __device__ __forceinline__ void Gather(uint32_t round) {
#pragma unroll
    for (uint32_t i = 0; i < kOwn; ++i) {
      // Past the last symbol, p = M, which changes no state.
      if constexpr (!kFull) entries_[i] = MakeShortEntry(kShortM, 0);
      if (IsThere<kFull>(round, i)) entries_[i] = __ldg(entries_at_[i] + symbols_[i]);
    }
  }
  __device__ __forceinline__ void Prepare(uint32_t round) {
    Round& to = memory_.rounds[round % 2];
#pragma unroll
    for (uint32_t i = 0; i < kOwn; ++i) {
      const ShortEntry entry = TakeApart(entries_[i]);
      to.entries[Lane()][first_ + i] = entry;
      above_[0][i] = above_[1][i];
      above_[1][i] = entry.above;
    }
  }
  // Of a round that was coded.
  template <bool kFull>
  __device__ __forceinline__ void Store(uint32_t round) {
    const Round& from = memory_.rounds[round % 2];
    uint32_t my_one = 0, my_two = 0;
#pragma unroll
    for (uint32_t i = 0; i < kOwn; ++i) {
      const float state = from.states[first_ + i][Lane()];
      const bool is_there = IsThere<kFull>(round, i);
      const unsigned one = __ballot_sync(kAllLanes, is_there && ByteLeaves(state, above_[0][i]));
      const unsigned two = __ballot_sync(
          kAllLanes, is_there && ByteLeaves(WithoutByte<DeviceArithmetic>(state), above_[0][i]));
      if (Lane() / kHalves == i) my_one = one, my_two = two;
      if (kFull || round * kRound + Lane() < GroupsOf(counts_[i]) * kSymbolsAWord) {
        __stwb(leaving_at_[i] + round * kRound, static_cast<uint16_t>(StateOf(state)));
      }
    }
    const uint32_t word = LeavingWord(my_one, my_two, Lane() % kHalves);
    if (round * kHalves + Lane() % kHalves < my_groups_) __stwb(my_words_ + round * kHalves, word);
    bytes_ += SumOfBytes(word);
  }

  BlockMemory& memory_;
  uint32_t first_, full_;
  uint32_t counts_[kOwn];
  const uint16_t* symbols_at_[kOwn];
  const uint2* entries_at_[kOwn];
  uint16_t* leaving_at_[kOwn];
  uint32_t symbols_[kOwn] = {};
  uint2 entries_[kOwn];
  float above_[2][kOwn] = {};  // ShortEntry::above of the two rounds that were prepared last
  // This lane's half of a round of a stream.
  uint32_t my_groups_;
  uint32_t* my_words_;
  uint32_t bytes_ = 0;
};

// The warp that codes.
__device__ void CodeRounds(uint32_t rounds, BlockMemory& memory) {
  constexpr uint32_t kPart = 4;  // states of a store of 16 bytes
  float state = ToState(4 * kShortM);
  for (uint32_t round = rounds; round-- > 0;) {
    Meet();
    Round& its = memory.rounds[round % 2];
    // Loaded a part ahead, for shared memory takes longer than a step. Unrolled, or the loads wait at the loop's end.
    ShortEntry ahead[kPart];
#pragma unroll
    for (uint32_t k = 0; k < kPart; ++k) ahead[k] = its.entries[kRound - kPart + k][Lane()];
#pragma unroll
    for (uint32_t end = kRound; end > 0; end -= kPart) {
      const uint32_t first = end - kPart;
      float before[kPart];
#pragma unroll
      for (uint32_t k = kPart; k-- > 0;) {
        before[k] = state;
        state = ShortStep<DeviceArithmetic>(state, ahead[k]);
        if (first > 0) ahead[k] = its.entries[first - kPart + k][Lane()];
      }
      *reinterpret_cast<float4*>(&its.states[Lane()][first]) = {before[0], before[1], before[2],
                                                                before[3]};
    }
  }
  memory.last_states[Lane()] = state;
  Meet();
}

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

__host__ __device__ uint32_t BlocksOfKind(const DracoWork& work) {
  return (work.count + kStreams - 1) / kStreams;
}

// The number of a warp that helps, or what else the warp does. One scheduler of the block has the warp that codes and no
// other. Blocks on a multiprocessor should code on different schedulers; their hashes are as good as random.
enum : uint32_t { kCodes = 0xffffffff, kIdles = 0xfffffffe };
__device__ uint32_t NumberOfWarp() {
  constexpr uint32_t kHash = 0x9e3779b1u;
  const uint32_t coder = (blockIdx.x * kHash >> 24) % kSchedulers;
  const uint32_t warp = threadIdx.x / kWarp, behind = (warp - coder) % kSchedulers;
  if (behind == 0) return warp == coder ? kCodes : kIdles;
  const uint32_t number = warp / kSchedulers * (kSchedulers - 1) + behind - 1;
  return number < kHelpers ? number : kIdles;
}

__global__ void __launch_bounds__(kWarps* kWarp, kBlocksAtOnce)
    RansKernel(const __grid_constant__ DracoWork work) {
  extern __shared__ uint4 block_memory[];
  auto& memory = *reinterpret_cast<BlockMemory*>(block_memory);
  const uint32_t number = NumberOfWarp();
  if (number == kIdles) return;
  const uint32_t blocks = BlocksOfKind(work);
  const DracoKind kind = work.KindOf(blockIdx.x / blocks);
  const uint32_t first_chunk = blockIdx.x % blocks * kStreams;
  ShortStream mine{};
  if (const DracoStream* stream = StreamOf(work, first_chunk + Lane(), kind);
      stream != nullptr && IsShort(*stream)) {
    mine = {work.Points(first_chunk + Lane()) * ValuesOf(kind), stream->first_entry,
            StreamAt(work, first_chunk + Lane(), kind), stream->ranked};
  }
  const uint32_t rounds = (__reduce_max_sync(kAllLanes, mine.count) + kRound - 1) / kRound;
  if (number == kCodes) return CodeRounds(rounds, memory);
  const uint32_t first = number * kOwn;
  Helper helper(work, mine, first, memory);
  helper.Run(rounds);
  const uint32_t bytes = helper.bytes(), chunk = first_chunk + first + Lane();
  DracoStream* const stream = Lane() < kOwn ? StreamOf(work, chunk, kind) : nullptr;
  if (stream == nullptr) return;
  if (IsShort(*stream)) {
    Finish(StateOf(memory.last_states[first + Lane()]), kLeastRansPrecision, bytes, *stream);
    return;
  }
  const size_t place = StreamAt(work, chunk, kind);
  CodeLong(PlacesOf(work, *stream, place), work.Points(chunk) * ValuesOf(kind),
           work.entries + stream->first_entry, reinterpret_cast<uint8_t*>(work.leaving + place),
           *stream);
}

}  // namespace

cudaError_t LaunchDracoRans(const DracoWork& work, cudaStream_t stream) {
  if (work.count == 0) return cudaSuccess;
  return KernelCall(RansKernel, Order::kAfter, work.Kinds() * BlocksOfKind(work), kWarps * kWarp,
                    sizeof(BlockMemory), work)
      .Launch(stream);
}

}  // namespace latticed::kernels
