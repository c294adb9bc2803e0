// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From the counts of a stream's symbols to its table, by one warp: twin of core/codec/rans_table.cc,
// 32 symbols at a time.
#ifndef LATTICED_CUDA_DRACO_DRACO_TABLE_CUH_
#define LATTICED_CUDA_DRACO_DRACO_TABLE_CUH_

#include "core/codec/rans_model.h"
#include "cuda/draco/draco_kernels.h"
#include "cuda/draco/rans_entry.h"

namespace latticed::kernels {

inline constexpr unsigned kWarp = 32, kAllLanes = 0xffffffffu;

// Thresholds end below this: (threshold + 1) M / 2 is then more than the symbols of a chunk of
// 65,535 points, since lifted <= distinct <= M / 2 and M >= 4096.
inline constexpr uint32_t kThresholds = 97;

__device__ __forceinline__ unsigned Lane() { return threadIdx.x % kWarp; }
__device__ __forceinline__ unsigned LanesBelow() { return (1u << Lane()) - 1; }
// The highest bit of a mask that is not 0.
__device__ __forceinline__ unsigned HighestBit(unsigned mask) { return 31 - __clz(mask); }

// Sum of the values of this lane and those below.
__device__ __forceinline__ uint32_t SumUpTo(uint32_t value) {
  for (unsigned step = 1; step < kWarp; step *= 2) {
    const uint32_t below = __shfl_up_sync(kAllLanes, value, step);
    if (Lane() >= step) value += below;
  }
  return value;
}

class TableBuilder {
 public:
  // `counts` of the symbols 0 … end - 1, `total` in all; `few`: kThresholds words of shared memory.
  // All lanes of a warp.
  __device__ TableBuilder(uint32_t* counts, uint32_t end, uint32_t total, uint32_t* few)
      : counts_(counts) {
    Look(end, few);
    bit_length_ = RansBitLength(distinct_);
    precision_ = RansPrecision(bit_length_);
    ShareOut(total, few);
  }

  __device__ uint32_t largest() const { return largest_; }
  __device__ int bit_length() const { return bit_length_; }

  // Entries by symbol, and the table's bytes; how many they are.
  __device__ uint32_t Write(uint2* entries, uint8_t* bytes) const;

 private:
  __device__ uint32_t At(uint32_t symbol) const { return symbol <= largest_ ? counts_[symbol] : 0; }
  __device__ void Look(uint32_t end, uint32_t* few);
  __device__ void ShareOut(uint32_t total, const uint32_t* few);
  static __device__ uint32_t Shares(unsigned heavies, uint32_t boundary, uint32_t count,
                                    uint32_t& given);

  uint32_t* counts_;  // probabilities after ShareOut
  uint32_t distinct_ = 0, largest_ = 0;
  int bit_length_ = 0, precision_ = 0;
};

// Distinct symbols, the largest, and how many of them have each of the least counts.
__device__ inline void TableBuilder::Look(uint32_t end, uint32_t* few) {
  for (uint32_t t = Lane(); t < kThresholds; t += kWarp) few[t] = 0;
  __syncwarp();
  for (uint32_t base = 0; base < end; base += kWarp) {
    const uint32_t symbol = base + Lane(), count = symbol < end ? counts_[symbol] : 0;
    const unsigned present = __ballot_sync(kAllLanes, count > 0);
    if (present == 0) continue;
    distinct_ += static_cast<uint32_t>(__popc(present));
    largest_ = base + HighestBit(present);
    if (count > 0 && count < kThresholds) atomicAdd(few + count, 1u);
  }
  __syncwarp();
}

// Probabilities of the lanes of `heavies`, which share by their counts; `given`: what all before got.
__device__ inline uint32_t TableBuilder::Shares(unsigned heavies, uint32_t boundary, uint32_t count,
                                                uint32_t& given) {
  const unsigned before = heavies & LanesBelow();
  const uint32_t neighbour =
      __shfl_sync(kAllLanes, boundary, before == 0 ? Lane() : HighestBit(before));
  const uint32_t share = boundary - (before == 0 ? given : neighbour);
  const bool heavy = (heavies >> Lane() & 1) != 0;
  uint32_t probability = heavy ? RansProbability(share, count) : 0;
  if (__ballot_sync(kAllLanes, heavy && probability != share) == 0) {
    given = __shfl_sync(kAllLanes, boundary, HighestBit(heavies));
    return probability;
  }
  // One that got less than its share leaves the rest to the next one: one by one.
  for (unsigned left = heavies; left != 0; left &= left - 1) {
    const unsigned lane = static_cast<unsigned>(__ffs(left)) - 1;
    const uint32_t its = RansProbability(__shfl_sync(kAllLanes, boundary, lane) - given,
                                         __shfl_sync(kAllLanes, count, lane));
    given += its;
    if (Lane() == lane) probability = its;
  }
  return probability;
}

__device__ inline void TableBuilder::ShareOut(uint32_t total, const uint32_t* few) {
  uint32_t threshold = 0, lifted = 0, rest = total;
  while (!IsRansThreshold(threshold, lifted, rest, precision_)) {
    ++threshold;
    lifted += few[threshold];
    rest -= few[threshold] * threshold;
  }
  const uint64_t scale = RansScale(lifted, rest, precision_);
  uint32_t before = 0, given = 0, last = 0;
  for (uint32_t base = 0; base <= largest_; base += kWarp) {
    const uint32_t symbol = base + Lane(), count = At(symbol);
    const bool heavy = count > threshold;
    const unsigned heavies = __ballot_sync(kAllLanes, heavy);
    uint32_t probability = count > 0 ? 1 : 0;
    if (heavies != 0) {
      const uint32_t up_to = before + SumUpTo(heavy ? count : 0);
      const uint32_t share = Shares(heavies, RansBoundary(scale, up_to), count, given);
      if (heavy) probability = share;
      before = __shfl_sync(kAllLanes, up_to, kWarp - 1);
      last = base + HighestBit(heavies);
    }
    if (symbol <= largest_) counts_[symbol] = probability;
  }
  __syncwarp();
  if (Lane() == 0) counts_[last] += RansBoundary(scale, rest) - given;
  __syncwarp();
}

// `count` bytes of a word, the lowest first.
__device__ __forceinline__ void PutBytes(uint8_t* to, uint32_t word, uint32_t count) {
  for (uint32_t b = 0; b < count; ++b) to[b] = static_cast<uint8_t>(word >> (8 * b));
}

__device__ inline uint32_t TableBuilder::Write(uint2* entries, uint8_t* bytes) const {
  constexpr uint32_t kMostZeros = 64;  // in one byte
  // The varint of largest + 1 <= 2^16.
  const uint32_t symbols = largest_ + 1;
  uint32_t at = symbols < 1u << 7 ? 1 : symbols < 1u << 14 ? 2 : 3;
  const uint32_t varint = at == 1   ? symbols
                          : at == 2 ? (symbols & 127) | 128 | symbols >> 7 << 8
                                    : (symbols & 127) | 128 | (symbols >> 7 & 127) << 8 | 1u << 15 |
                                          symbols >> 14 << 16;
  if (Lane() == 0) PutBytes(bytes, varint, at);
  uint32_t cumulative = 0, next = 0;  // of the symbols before, and the one behind the last of them
  for (uint32_t base = 0; base <= largest_; base += kWarp) {
    const uint32_t symbol = base + Lane(), probability = At(symbol);
    const unsigned present = __ballot_sync(kAllLanes, probability > 0);
    if (present == 0) continue;
    const unsigned below = present & LanesBelow();
    const uint32_t zeros = symbol - (below == 0 ? next : base + HighestBit(below) + 1);
    const uint32_t more = probability < 1u << 6 ? 0 : probability < 1u << 14 ? 1 : 2;
    const uint32_t runs = (zeros + kMostZeros - 1) / kMostZeros;
    const uint32_t length = probability > 0 ? runs + 1 + more : 0;
    const uint32_t probabilities = SumUpTo(probability), lengths = SumUpTo(length);
    if (probability > 0) {
      entries[symbol] =
          MakeEntry(probability, cumulative + probabilities - probability, precision_);
      uint8_t* to = bytes + at + lengths - length;
      for (uint32_t left = zeros; left > 0; left -= min(left, kMostZeros)) {
        *to++ = static_cast<uint8_t>((min(left, kMostZeros) - 1) << 2 | 3);
      }
      PutBytes(to, (probability & 63) << 2 | more | probability >> 6 << 8, 1 + more);
    }
    cumulative += __shfl_sync(kAllLanes, probabilities, kWarp - 1);
    at += __shfl_sync(kAllLanes, lengths, kWarp - 1);
    next = base + HighestBit(present) + 1;
  }
  return at;
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_DRACO_DRACO_TABLE_CUH_
