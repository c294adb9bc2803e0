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

// Room in shared memory for the symbols of a stream that occur, and their counts.
struct SymbolRoom {
  uint32_t* counts;
  uint16_t* names;
  uint32_t size;
};
template <uint32_t kSize>
struct SymbolList {
  uint32_t counts[kSize];
  uint16_t names[kSize];
  __device__ SymbolRoom room() { return {counts, names, kSize}; }
};
// Nearly all streams have fewer distinct symbols, among many values that do not occur.
inline constexpr uint32_t kListedSymbols = 256;

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
  // `counts`: of the symbols 0 … end - 1; `total`: their sum. Those that occur are listed, if `room` suffices; else their
  // probabilities replace the counts. All lanes of a warp call it.
  //
  // `names`: of ranked symbols, all that occur, in ascending order; counts[i] is then that of names[i]. The entries are by rank.
  __device__ TableBuilder(uint32_t* counts, uint32_t end, uint32_t total, SymbolRoom room,
                          const uint16_t* names = nullptr)
      : places_{counts, names, end}, by_rank_(names != nullptr) {
    if (by_rank_) {
      distinct_ = end;
      largest_ = names[end - 1];
    } else {
      List(room);
      places_ = distinct_ <= room.size ? Places{room.counts, room.names, distinct_}
                                       : Places{counts, nullptr, largest_ + 1};
    }
    ShareOut(total);
  }

  __device__ uint32_t largest() const { return largest_; }
  __device__ int bit_length() const { return bit_length_; }
  // No less than what the probabilities say of the symbols, in bits: the sum of log2(M / p). All lanes call it.
  __device__ float MostBits() const { return SumOfLanes(lane_bits_); }

  // Writes the entries, by symbol or by rank, and the table's bytes; returns how many bytes.
  __device__ uint32_t Write(uint2* entries, uint8_t* bytes) const;

 private:
  // Counts, then probabilities, in the order of the symbols. Without names they are of the symbols 0 … size - 1, some zero.
  struct Places {
    uint32_t* values;
    const uint16_t* names;
    uint32_t size;

    __device__ uint32_t NameOf(uint32_t place) const {
      return names == nullptr ? place : names[place];
    }
    // How many symbols come between this one and the last one before it that occurs. `next`: where names are missing, the one
    // behind that.
    __device__ uint32_t ZerosBefore(uint32_t place, uint32_t next) const {
      if (names == nullptr) return place - next;
      return place == 0 ? names[0] : names[place] - names[place - 1] - 1u;
    }
    __device__ uint32_t At(uint32_t place) const { return place < size ? values[place] : 0; }
  };
  struct Sums {
    uint32_t all, ones;  // RansShares::Try
  };

  __device__ void List(SymbolRoom room);
  __device__ uint32_t MostFrequent() const;
  __device__ void ShareOut(uint32_t total);
  __device__ void GiveOut(const RansShares& shares, uint32_t left);
  __device__ Sums SumsAt(uint32_t scale, const RansShares& shares) const;

  Places places_;
  bool by_rank_;
  uint32_t distinct_ = 0, largest_ = 0;  // largest_: a symbol
  int bit_length_ = 0, precision_ = 0;
  float lane_bits_ = 0;  // of this lane's symbols
};

// Finds the number of distinct symbols and the largest one, and lists them as far as there is room.
__device__ inline void TableBuilder::List(SymbolRoom room) {
  const uint32_t end = places_.size;
  constexpr uint32_t kAtOnce = 4;  // loads that are on their way together
  for (uint32_t base = 0; base < end; base += kAtOnce * kWarp) {
    uint32_t its[kAtOnce], any = 0;
#pragma unroll
    for (uint32_t k = 0; k < kAtOnce; ++k) {
      const uint32_t symbol = base + k * kWarp + Lane();
      its[k] = places_.At(symbol);
      any |= its[k];
    }
    if (!__any_sync(kAllLanes, any > 0)) continue;
#pragma unroll
    for (uint32_t k = 0; k < kAtOnce; ++k) {
      const unsigned present = __ballot_sync(kAllLanes, its[k] > 0);
      const uint32_t place = distinct_ + static_cast<uint32_t>(__popc(present & LanesBelow()));
      if (its[k] > 0 && place < room.size) {
        room.counts[place] = its[k];
        room.names[place] = static_cast<uint16_t>(base + k * kWarp + Lane());
      }
      distinct_ += static_cast<uint32_t>(__popc(present));
      if (present != 0) largest_ = base + k * kWarp + HighestBit(present);
    }
  }
  __syncwarp();
}

// The place of the largest count, the first one of several.
__device__ inline uint32_t TableBuilder::MostFrequent() const {
  uint32_t most = 0, its_place = 0;  // of this lane's
  for (uint32_t place = Lane(); place < places_.size; place += kWarp) {
    const uint32_t count = places_.values[place];
    if (count > most) most = count, its_place = place;
  }
  const bool has_most = most == __reduce_max_sync(kAllLanes, most);
  return __reduce_min_sync(kAllLanes, has_most ? its_place : places_.size);
}

__device__ inline TableBuilder::Sums TableBuilder::SumsAt(uint32_t scale,
                                                          const RansShares& shares) const {
  Sums sums{};
  for (uint32_t place = Lane(); place < places_.size; place += kWarp) {
    const uint32_t count = places_.values[place];
    const uint32_t probability = count > 0 ? shares.Probability(scale, count) : 0;
    sums.all += probability;
    sums.ones += probability == 1 ? 1 : 0;
  }
  return {__reduce_add_sync(kAllLanes, sums.all), __reduce_add_sync(kAllLanes, sums.ones)};
}

__device__ inline void TableBuilder::ShareOut(uint32_t total) {
  bit_length_ = RansBitLength(distinct_);
  precision_ = RansPrecision(bit_length_);
  RansShares shares(total, precision_);
  while (shares.searching()) {
    const Sums sums = SumsAt(shares.scale(), shares);
    shares.Try(sums.all, sums.ones);
  }
  GiveOut(shares, (1u << precision_) - SumsAt(shares.fits(), shares).all);
}

// `left`: of M, at the scale that fits.
__device__ inline void TableBuilder::GiveOut(const RansShares& shares, uint32_t left) {
  const uint32_t most_frequent = MostFrequent();
  uint32_t asked = 0, given = 0;  // more, by the symbols up to here
  for (uint32_t base = 0; base < places_.size; base += kWarp) {
    const uint32_t place = base + Lane(), count = places_.At(place);
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
      places_.values[place] = probability;
      lane_bits_ += static_cast<float>(count) *
                    (static_cast<float>(precision_) - __log2f(static_cast<float>(probability)));
    }
  }
  __syncwarp();
  if (Lane() == 0) places_.values[most_frequent] += left - given;
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
  for (uint32_t base = 0; base < places_.size; base += kWarp) {
    const uint32_t place = base + Lane(), probability = places_.At(place);
    const unsigned present = __ballot_sync(kAllLanes, probability > 0);
    if (present == 0) continue;
    const unsigned below = present & LanesBelow();
    uint32_t zeros = 0;
    if (probability > 0) {
      zeros = places_.ZerosBefore(place, below == 0 ? next : base + HighestBit(below) + 1);
    }
    const uint32_t more = probability < 1u << 6 ? 0 : probability < 1u << 14 ? 1 : 2;
    const uint32_t runs = (zeros + kMostZeros - 1) / kMostZeros;
    const uint32_t length = probability > 0 ? runs + 1 + more : 0;
    const uint32_t probabilities = SumUpTo(probability), lengths = SumUpTo(length);
    if (probability > 0) {
      entries[by_rank_ ? place : places_.NameOf(place)] =
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
