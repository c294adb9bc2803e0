// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One warp makes a stream's table from the counts of its symbols, 32 symbols at a time. Twin of
// core/codec/rans_table.cc.
#ifndef LATTICED_CUDA_DRACO_DRACO_TABLE_CUH_
#define LATTICED_CUDA_DRACO_DRACO_TABLE_CUH_

#include "core/codec/rans_model.h"
#include "core/codec/rans_shares.h"
#include "cuda/draco/draco_kernels.h"
#include "cuda/draco/rans_entry.h"
#include "cuda/streams/warp.cuh"

namespace latticed::kernels {

// A stream with at most so many distinct symbols has their counts in a list. Nearly all streams do, and
// most of their counts are zero.
inline constexpr uint32_t kListedCounts = 256;

// The highest bit of a mask that is not 0.
__device__ __forceinline__ unsigned HighestBit(unsigned mask) { return 31 - __clz(mask); }

__device__ __forceinline__ float SumOfLanes(float value) {
  for (unsigned step = kWarp / 2; step > 0; step /= 2) {
    value += __shfl_xor_sync(kAllLanes, value, static_cast<int>(step));
  }
  return value;
}

class TableBuilder {
 public:
  // `counts`: of the symbols 0 … end - 1; `total`: their sum; `list`: as many words of shared memory, kListedCounts at
  // most. All lanes of a warp call it.
  //
  // `names`: of ranked symbols, those that occur, in ascending order; counts[i] is then that of names[i], not 0.
  __device__ TableBuilder(uint32_t* counts, uint32_t end, uint32_t total, uint32_t* list,
                          const uint16_t* names = nullptr)
      : counts_(counts), names_(names) {
    Look(end, list);
    bit_length_ = RansBitLength(distinct_);
    precision_ = RansPrecision(bit_length_);
    ShareOut(total,
             distinct_ <= kListedCounts ? Counts{list, distinct_} : Counts{counts_, largest_ + 1});
  }

  __device__ uint32_t largest() const { return NameOf(largest_); }
  __device__ int bit_length() const { return bit_length_; }
  // No less than what the probabilities say of the symbols, in bits: the sum of log2(M / p). All lanes call it.
  __device__ float MostBits() const { return SumOfLanes(lane_bits_); }

  // Writes the entries, in the order of the counts, and the table's bytes; returns how many bytes.
  __device__ uint32_t Write(uint2* entries, uint8_t* bytes) const;

 private:
  // In any order, with or without zeros.
  struct Counts {
    const uint32_t* values;
    uint32_t size;
  };
  struct Sums {
    uint32_t all, ones;  // RansShares::Try
  };

  __device__ uint32_t NameOf(uint32_t place) const {
    return names_ == nullptr ? place : names_[place];
  }
  // How many symbols of probability 0 come before the one at `place`. `next`: the first place that may be theirs.
  __device__ uint32_t ZerosBefore(uint32_t place, uint32_t next) const {
    if (names_ == nullptr) return place - next;
    return place == 0 ? names_[0] : names_[place] - names_[place - 1] - 1u;
  }
  __device__ uint32_t At(uint32_t symbol) const { return symbol <= largest_ ? counts_[symbol] : 0; }
  __device__ void Look(uint32_t end, uint32_t* list);
  __device__ void ShareOut(uint32_t total, Counts counts);
  __device__ void GiveOut(const RansShares& shares, uint32_t left);
  static __device__ Sums SumsAt(uint32_t scale, const RansShares& shares, Counts counts);

  uint32_t* counts_;  // probabilities after ShareOut
  const uint16_t* names_;
  uint32_t distinct_ = 0, largest_ = 0, most_frequent_ = 0;
  int bit_length_ = 0, precision_ = 0;
  float lane_bits_ = 0;  // of this lane's symbols
};

// Finds the number of distinct symbols, the largest and the most frequent one, and lists the counts.
__device__ inline void TableBuilder::Look(uint32_t end, uint32_t* list) {
  uint32_t most = 0, its_symbol = 0;  // of this lane's
  for (uint32_t base = 0; base < end; base += kWarp) {
    const uint32_t symbol = base + Lane(), count = symbol < end ? counts_[symbol] : 0;
    const unsigned present = __ballot_sync(kAllLanes, count > 0);
    if (present == 0) continue;
    const uint32_t place = distinct_ + static_cast<uint32_t>(__popc(present & LanesBelow()));
    if (count > 0 && place < kListedCounts) list[place] = count;
    if (count > most) most = count, its_symbol = symbol;
    distinct_ += static_cast<uint32_t>(__popc(present));
    largest_ = base + HighestBit(present);
  }
  const bool has_most = most == __reduce_max_sync(kAllLanes, most);
  most_frequent_ = __reduce_min_sync(kAllLanes, has_most ? its_symbol : end);
  __syncwarp();
}

__device__ inline TableBuilder::Sums TableBuilder::SumsAt(uint32_t scale, const RansShares& shares,
                                                          Counts counts) {
  Sums sums{};
  for (uint32_t i = Lane(); i < counts.size; i += kWarp) {
    const uint32_t count = counts.values[i];
    const uint32_t probability = count > 0 ? shares.Probability(scale, count) : 0;
    sums.all += probability;
    sums.ones += probability == 1 ? 1 : 0;
  }
  return {__reduce_add_sync(kAllLanes, sums.all), __reduce_add_sync(kAllLanes, sums.ones)};
}

__device__ inline void TableBuilder::ShareOut(uint32_t total, Counts counts) {
  RansShares shares(total, precision_);
  while (shares.searching()) {
    const Sums sums = SumsAt(shares.scale(), shares, counts);
    shares.Try(sums.all, sums.ones);
  }
  GiveOut(shares, (1u << precision_) - SumsAt(shares.fits(), shares, counts).all);
}

// `left`: of M, at the scale that fits.
__device__ inline void TableBuilder::GiveOut(const RansShares& shares, uint32_t left) {
  uint32_t asked = 0, given = 0;  // more, by the symbols up to here
  for (uint32_t base = 0; base <= largest_; base += kWarp) {
    const uint32_t symbol = base + Lane(), count = At(symbol);
    if (__ballot_sync(kAllLanes, count > 0) == 0) continue;
    uint32_t probability = 0, more = 0;
    if (count > 0) {
      probability = shares.Probability(shares.fits(), count);
      more = shares.Probability(shares.exceeds(), count) - probability;
    }
    if (asked <= left && __ballot_sync(kAllLanes, more > 0) != 0) {
      const uint32_t up_to = asked + SumUpTo(more);
      const bool suffices = up_to <= left;
      if (suffices) probability += more;
      given = __reduce_max_sync(kAllLanes, suffices ? up_to : given);
      asked = __shfl_sync(kAllLanes, up_to, kWarp - 1);
    }
    if (count > 0) {
      counts_[symbol] = probability;
      lane_bits_ += static_cast<float>(count) *
                    (static_cast<float>(precision_) - __log2f(static_cast<float>(probability)));
    }
  }
  __syncwarp();
  if (Lane() == 0) counts_[most_frequent_] += left - given;
  __syncwarp();
}

// Writes `count` bytes of a word, the lowest first.
__device__ __forceinline__ void PutBytes(uint8_t* to, uint32_t word, uint32_t count) {
  for (uint32_t b = 0; b < count; ++b) to[b] = static_cast<uint8_t>(word >> (8 * b));
}

__device__ inline uint32_t TableBuilder::Write(uint2* entries, uint8_t* bytes) const {
  constexpr uint32_t kMostZeros = 64;  // in one byte
  // The varint of largest + 1 <= 2^16.
  const uint32_t symbols = largest() + 1;
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
    uint32_t zeros = 0;
    if (probability > 0) {
      zeros = ZerosBefore(symbol, below == 0 ? next : base + HighestBit(below) + 1);
    }
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
