// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One lane codes one stream. Its state takes the symbols, the last one first, and each step waits for the
// one before. So a step does only what it must. All lanes of the warp load the symbols and entries ahead
// and take the entries apart, sixteen symbols of each stream at a time. The bytes that leave a state are
// stored with gaps and packed later (draco_pack_kernel.cu).
#include "cuda/draco/draco_leaving.cuh"
#include "cuda/draco/draco_table.cuh"

namespace latticed::kernels {
namespace {

// A step with p = M, which changes nothing: used past a stream's last symbol.
__device__ __forceinline__ uint2 NoStep() { return MakeShortEntry(kShortM, 0); }

// A stream as the lanes of a warp read it.
struct ShortStream {
  const uint16_t* symbols;
  const uint2* entries;
  uint32_t count;  // 0: there is no stream, or it has more than 12 bits
};

// Codes kStreams streams at once. In each round all lanes prepare 16 symbols of each stream, kPart a lane.
template <uint32_t kStreams>
class Coder {
 public:
  static constexpr uint32_t kLanesAStream = kWarp / kStreams;
  static constexpr uint32_t kPart = kSymbolsAWord / kLanesAStream;  // symbols
  // What ShortStep takes of each symbol; bytes leave before it while the state is at least p << 10,
  // two of them from p << 18 on.
  struct Shared {
    uint4 first[kSymbolsAWord][kStreams];   // R, p << 10, p << 18, c'
    uint2 second[kSymbolsAWord][kStreams];  // M - p, shift
  };

  // `mine`: the stream that this lane prepares for.
  __device__ Coder(Shared& shared, const ShortStream& mine) : shared_(shared), mine_(mine) {}

  // Lanes below kStreams code stream `coded`, of as many symbols.
  __device__ void Code(uint32_t rounds, uint32_t coded, uint16_t* leaving,
                       uint32_t* leaving_bytes) {
    const bool codes = Lane() < kStreams;
    Load(rounds - 1);
    Gather(rounds - 1);
    Load(rounds - 2);
    for (uint32_t round = rounds; round-- > 0;) {
      Prepare();
      __syncwarp();
      Gather(round - 1);
      Load(round - 2);
      if (codes && round * kSymbolsAWord < coded) Steps(round, leaving, leaving_bytes);
      __syncwarp();
    }
  }

  __device__ uint32_t state() const { return x_; }
  __device__ uint32_t bytes() const { return bytes_; }

 private:
  __device__ __forceinline__ uint32_t FirstOf(uint32_t round) const {
    return round * kSymbolsAWord + Lane() % kLanesAStream * kPart;
  }
  // Loads the symbols of a round; before the first round there are none.
  __device__ __forceinline__ void Load(uint32_t round) {
    const uint32_t first = FirstOf(round);
    if (static_cast<int32_t>(round) < 0 || first >= mine_.count) return;
    const uint16_t* from = mine_.symbols + first;
    if constexpr (kPart == 2) {
      pairs_[0] = __ldg(reinterpret_cast<const uint32_t*>(from));
    } else {
      static_assert(kPart == 8);
      const uint4 eight = __ldg(reinterpret_cast<const uint4*>(from));
      pairs_[0] = eight.x, pairs_[1] = eight.y, pairs_[2] = eight.z, pairs_[3] = eight.w;
    }
  }
  // Loads their entries.
  __device__ __forceinline__ void Gather(uint32_t round) {
    const uint32_t first = FirstOf(round);
#pragma unroll
    for (uint32_t i = 0; i < kPart; ++i) {
      const uint32_t symbol = i % 2 == 0 ? pairs_[i / 2] & 0xffff : pairs_[i / 2] >> 16;
      const bool there = static_cast<int32_t>(round) >= 0 && first + i < mine_.count;
      entries_[i] = there ? __ldg(mine_.entries + symbol) : NoStep();
    }
  }
  __device__ __forceinline__ void Prepare() {
#pragma unroll
    for (uint32_t i = 0; i < kPart; ++i) {
      const uint2 entry = entries_[i];
      const uint32_t place = Lane() % kLanesAStream * kPart + i, stream = Lane() / kLanesAStream;
      const uint32_t p = ShortProbability(entry);
      shared_.first[place][stream] = {entry.x, p << 10, p << 18, ShortBias(entry)};
      shared_.second[place][stream] = {kShortM - p, ShortShift(entry)};
    }
  }
  __device__ __forceinline__ void Steps(uint32_t round, uint16_t* leaving,
                                        uint32_t* leaving_bytes) {
    uint32_t low[kSymbolsAWord], counts = 0;
#pragma unroll
    for (uint32_t k = kSymbolsAWord; k-- > 0;) {
      const uint4 first = shared_.first[k][Lane()];
      const uint2 second = shared_.second[k][Lane()];
      const bool any = x_ >= first.y, both = x_ >= first.z;
      low[k] = x_;
      counts |= (both ? 2u : any ? 1u : 0u) << (2 * k);
      // Both shifts are computed while the comparisons run: one shift by their result takes 6 % longer.
      uint32_t kept = any ? x_ >> 8 : x_;
      kept = both ? x_ >> 16 : kept;
      x_ = ShortStep(kept, first.x, second.y, first.w, second.x);
    }
    auto* to = reinterpret_cast<uint4*>(leaving + round * kSymbolsAWord);
    constexpr uint32_t kLowHalves = 0x5410;
#pragma unroll
    for (uint32_t i = 0; i < 2; ++i) {
      const uint32_t* its = low + 8 * i;
      to[i] = {__byte_perm(its[0], its[1], kLowHalves), __byte_perm(its[2], its[3], kLowHalves),
               __byte_perm(its[4], its[5], kLowHalves), __byte_perm(its[6], its[7], kLowHalves)};
    }
    leaving_bytes[round] = counts;
    bytes_ += SumOfBytes(counts);
  }

  Shared& shared_;
  const ShortStream mine_;
  uint32_t pairs_[(kPart + 1) / 2] = {};
  uint2 entries_[kPart];
  uint32_t x_ = 4 * kShortM, bytes_ = 0;
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

template <uint32_t kStreams>
__global__ void __launch_bounds__(kWarp) RansKernel(const __grid_constant__ DracoWork work) {
  using StreamCoder = Coder<kStreams>;
  __shared__ typename StreamCoder::Shared shared;
  const uint32_t warps = (work.count + kStreams - 1) / kStreams;  // of one kind
  const DracoKind kind = work.KindOf(blockIdx.x / warps);
  const uint32_t first = blockIdx.x % warps * kStreams;
  const uint32_t values = ValuesOf(kind);

  const uint32_t mine = first + Lane() / StreamCoder::kLanesAStream;
  ShortStream prepared{};
  if (const DracoStream* stream = StreamOf(work, mine, kind);
      stream != nullptr && IsShort(*stream)) {
    prepared = {PlacesOf(work, *stream, StreamAt(work, mine, kind)),
                work.entries + stream->first_entry, work.Points(mine) * values};
  }
  const uint32_t rounds =
      (__reduce_max_sync(kAllLanes, prepared.count) + kSymbolsAWord - 1) / kSymbolsAWord;
  const uint32_t chunk = first + Lane();
  DracoStream* stream = Lane() < kStreams ? StreamOf(work, chunk, kind) : nullptr;
  const uint32_t count = stream == nullptr ? 0 : work.Points(chunk) * values;
  const bool codes = stream != nullptr && IsShort(*stream);
  const size_t at = stream == nullptr ? 0 : StreamAt(work, chunk, kind);

  StreamCoder coder(shared, prepared);
  if (rounds > 0) {
    coder.Code(rounds, codes ? count : 0, work.leaving + at,
               work.leaving_bytes + at / kSymbolsAWord);
  }
  if (codes) {
    Finish(coder.state(), kLeastRansPrecision, coder.bytes(), *stream);
  } else if (stream != nullptr) {
    CodeLong(PlacesOf(work, *stream, at), count, work.entries + stream->first_entry,
             reinterpret_cast<uint8_t*>(work.leaving + at), *stream);
  }
}

template <uint32_t kStreams>
cudaError_t Launch(const DracoWork& work, cudaStream_t stream) {
  const uint32_t warps = (work.count + kStreams - 1) / kStreams;
  RansKernel<kStreams><<<work.Kinds() * warps, kWarp, 0, stream>>>(work);
  return cudaPeekAtLastError();
}

}  // namespace

cudaError_t LaunchDracoRans(const DracoWork& work, cudaStream_t stream) {
  // One warp for each scheduler is best: two would take turns. A large device has about 500 schedulers.
  constexpr uint32_t kFew = 1000, kFewStreams = 4, kManyStreams = 16;
  if (work.count == 0) return cudaSuccess;
  return work.count <= kFew ? Launch<kFewStreams>(work, stream)
                            : Launch<kManyStreams>(work, stream);
}

}  // namespace latticed::kernels
