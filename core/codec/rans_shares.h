// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The probabilities of a stream's symbols, which sum to M (rans_model.h): how a count becomes a probability, and the
// search for the scale at which the probabilities nearly sum to M.
//
//   share = scale * count
//
// A probability is the share rounded to the nearest integer, and at least 1. From 64 on, it takes a second byte of the
// table. Shares a little above 63 therefore get 63, as long as this makes the stream longer by less than that byte.
// With 63 in place of a share s, the stream takes (s - 63)^2 / 126 * log2(e) * total / M bits more, to the second
// order; `total` is the sum of all counts, and the other symbols share what is saved.
//
// Probabilities rise with the scale. `fits()` is a scale at which they sum to M or less. `exceeds()` is one at which
// they sum to more, or the end of the searched range; it equals `fits()` where the sum is M. The writer takes the
// probabilities at `fits()`. The rest of M goes
//
//   to the symbols that have a higher probability at `exceeds()`, up to that one, in ascending order, until the rest is
//   too small for one; what is left then goes to the most frequent symbol, the smallest one of several.
//
// The result sums to M and has no probability below 1, provided that the search begins with a scale that fits. The
// scale M / 2 / total does: shares sum to M / 2, a probability is at most its share + 1, and there are at most M / 2
// symbols (RansBitLength).
//
// All numbers are integers, and a guess depends on sums only, so that all writers make the same guesses. The scale is
// in units of M / 2^30 and at most 2^31 / total; its product with a count fits 32 bits.
//
// Threads  one thread at a time, on host and device
#ifndef LATTICED_CORE_CODEC_RANS_SHARES_H_
#define LATTICED_CORE_CODEC_RANS_SHARES_H_

#include <cstdint>

#include "core/base/host_device.h"

namespace latticed {

class RansShares {
 public:
  // `total`: the sum of all counts, not 0.
  LATTICED_HD constexpr RansShares(uint32_t total, int precision)
      : fraction_bits_(kShareBits - precision),
        gap_(1 + Root((kWorthAByte << precision) / total)),
        sum_(uint32_t{1} << precision),
        scale_((uint32_t{1} << kShareBits) / total),
        fits_(scale_ / 2),
        exceeds_(2 * scale_) {}

  // The probability at `scale` of a symbol that occurs `count` times, not 0.
  LATTICED_HD constexpr uint32_t Probability(uint32_t scale, uint32_t count) const {
    const uint32_t half = uint32_t{1} << (fraction_bits_ - 1);
    const uint32_t nearest = (scale * count + half) >> fraction_bits_;
    const uint32_t probability = nearest > 0 ? nearest : 1;
    // One unsigned comparison: below 63 the difference wraps around.
    return probability - kMostOfOneByte < gap_ ? kMostOfOneByte : probability;
  }

  LATTICED_HD constexpr bool searching() const {
    return tries_ < kMostTries && exceeds_ - fits_ > 1;
  }
  // The next scale to try.
  LATTICED_HD constexpr uint32_t scale() const { return scale_; }
  // `sum`: of the probabilities at scale(). `ones`: how many of them are 1; these hardly change with the scale. The
  // next scale is where the sum would be M if all others changed in proportion, or the middle if that is out of range.
  LATTICED_HD constexpr void Try(uint32_t sum, uint32_t ones) {
    ++tries_;
    if (sum <= sum_) fits_ = scale_;
    if (sum >= sum_) exceeds_ = scale_;
    const uint32_t off = sum > sum_ ? sum - sum_ : sum_ - sum;
    const uint32_t moving = sum > ones ? sum - ones : 1;
    const uint64_t step = Quotient(uint64_t{scale_} * off, moving);
    const uint64_t next = sum <= sum_ ? scale_ + step : scale_ - (step < scale_ ? step : scale_);
    const bool inside = next > fits_ && next < exceeds_;
    scale_ = inside ? static_cast<uint32_t>(next) : fits_ + (exceeds_ - fits_) / 2;
  }

  LATTICED_HD constexpr uint32_t fits() const { return fits_; }
  LATTICED_HD constexpr uint32_t exceeds() const { return exceeds_; }

 private:
  static constexpr int kShareBits = 30;
  static constexpr uint32_t kMostOfOneByte = 63,
                            kWorthAByte = 699;  // 8 * 126 / log2(e); times 2^20 fits 32 bits
  // Three or four suffice for most streams. Further ones would gain a ten thousandth of a percent.
  static constexpr uint32_t kMostTries = 6;

  // floor(a / b) for a < 2^62, if that is below 2^31; else 2^31, which is as good: a step so long leaves the range. A
  // device divides doubles in fewer instructions than 64-bit integers. Their quotient is off by less than one.
  static LATTICED_HD constexpr uint32_t Quotient(uint64_t a, uint32_t b) {
    if (a >> 31 >= b) return uint32_t{1} << 31;
    const auto near = static_cast<uint32_t>(static_cast<double>(a) / b);
    const auto rest = static_cast<int64_t>(a - uint64_t{near} * b);
    return rest < 0 ? near - 1 : rest >= int64_t{b} ? near + 1 : near;
  }
  // The root of a square below 2^24. kWorthAByte * 2^12 is below it; a larger M implies a total of M / 4 at least.
  static LATTICED_HD constexpr uint32_t Root(uint32_t square) {
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
