// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The probabilities of a stream's symbols, which sum up to M (rans_model.h): how a count becomes one,
// and the search for the scale at which they nearly do.
//
//   share = scale * count
//
// The probability is the share rounded to the nearest, 1 at least. From 64 on it takes a second byte
// of the table: it is 63 for the shares above that, too, for which the longer stream is the lesser
// cost. 63 in place of a share s takes (s - 63)^2 / 126 * log2(e) * total / M bits, to the second
// order, where `total` counts share M and all others share what is saved.
//
// Probabilities ascend with the scale. `fits()` is one at which they sum up to M at most; `exceeds()`
// one at which they sum up to more, or the end of the range that is searched, or the same where the
// sum is M. Who shares out begins with `fits()`. What is left of M goes
//
//   to the symbols that have more at `exceeds()`, as much more, in ascending order, up to the first
//   that it does not suffice for; then to the most frequent symbol, the least one of several.
//
// So they sum up to M and none is below 1, given that the search begins with a scale that fits, which
// M / 2 / total does. There shares sum up to M / 2, a probability is at most its share + 1, and there
// are M / 2 symbols at most (RansBitLength).
//
// Integers throughout, and a guess depends on sums only: all that search make the same guesses. The
// scale is in units of M / 2^30 and at most 2^31 / total: times a count it fits 32 bits.
//
// Threads  one thread at a time, on host and device
#ifndef LATTICED_CORE_CODEC_RANS_SHARES_H_
#define LATTICED_CORE_CODEC_RANS_SHARES_H_

#include <cstdint>

#include "core/base/host_device.h"

namespace latticed {

class RansShares {
 public:
  // `total`: of all counts, not 0.
  LATTICED_HD constexpr RansShares(uint32_t total, int precision)
      : fraction_bits_(kShareBits - precision),
        gap_(1 + Root((uint64_t{kWorthAByte} << precision) / total)),
        sum_(uint32_t{1} << precision),
        scale_((uint32_t{1} << kShareBits) / total),
        fits_(scale_ / 2),
        exceeds_(2 * scale_) {}

  // The probability of a symbol that is counted `count` times, not 0, at `scale`.
  LATTICED_HD constexpr uint32_t Probability(uint32_t scale, uint32_t count) const {
    const uint32_t half = uint32_t{1} << (fraction_bits_ - 1);
    const uint32_t nearest = (scale * count + half) >> fraction_bits_;
    const uint32_t probability = nearest > 0 ? nearest : 1;
    // One comparison: below the gap the difference wraps.
    return probability - kMostOfOneByte < gap_ ? kMostOfOneByte : probability;
  }

  LATTICED_HD constexpr bool searching() const {
    return tries_ < kMostTries && exceeds_ - fits_ > 1;
  }
  // The next one to try.
  LATTICED_HD constexpr uint32_t scale() const { return scale_; }
  // What probabilities sum up to with it, and how many of them are 1, which hardly move with the
  // scale. The next is where M would be if all others moved as it does, or else half-way.
  LATTICED_HD constexpr void Try(uint32_t sum, uint32_t ones) {
    ++tries_;
    if (sum <= sum_) fits_ = scale_;
    if (sum >= sum_) exceeds_ = scale_;
    const uint32_t off = sum > sum_ ? sum - sum_ : sum_ - sum;
    const uint32_t moving = sum > ones ? sum - ones : 1;
    const uint64_t step = uint64_t{scale_} * off / moving;
    const uint64_t next = sum <= sum_ ? scale_ + step : scale_ - (step < scale_ ? step : scale_);
    const bool inside = next > fits_ && next < exceeds_;
    scale_ = inside ? static_cast<uint32_t>(next) : fits_ + (exceeds_ - fits_) / 2;
  }

  LATTICED_HD constexpr uint32_t fits() const { return fits_; }
  LATTICED_HD constexpr uint32_t exceeds() const { return exceeds_; }

 private:
  static constexpr int kShareBits = 30;
  static constexpr uint32_t kMostOfOneByte = 63, kWorthAByte = 699;  // 8 * 126 / log2(e)
  // Three or four do for most; what further ones would gain is a ten thousandth of a percent.
  static constexpr uint32_t kMostTries = 6;

  // For squares below 2^24: kWorthAByte * 2^12 is below it; a larger M has a total of M / 4 at least.
  static LATTICED_HD constexpr uint32_t Root(uint64_t square) {
    uint32_t root = 0;
    for (uint32_t bit = 1 << 11; bit != 0; bit >>= 1) {
      if ((root | bit) * (root | bit) <= square) root |= bit;
    }
    return root;
  }

  int fraction_bits_;  // of a share
  uint32_t gap_;       // how many shares, from 63 on, get 63
  uint32_t sum_;       // M
  uint32_t scale_, fits_, exceeds_;
  uint32_t tries_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_RANS_SHARES_H_
