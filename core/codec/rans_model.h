// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Every choice that Draco leaves to a writer of rANS symbols (its scheme RAW), as integer functions of the histogram,
// so that all writers make the same bytes. rans_shares.h has the probabilities of the symbols.
//
//   M = 2^precision: what the probabilities of a stream sum up to. A stream names it by its bit
//   length b, 1 … 18: precision = clamp(floor(3 b / 2), 12, 20).
//
// Threads  pure functions, on host and device
#ifndef LATTICED_CORE_CODEC_RANS_MODEL_H_
#define LATTICED_CORE_CODEC_RANS_MODEL_H_

#include <cstdint>

#include "core/base/host_device.h"

namespace latticed {

inline constexpr uint32_t kSchemeTagged = 0, kSchemeRaw = 1;  // the format's numbers of the schemes

// Bit lengths up to 8 all mean 12 bits, those from 14 on all mean 20.
inline constexpr int kLeastRansBitLength = 8, kMostRansBitLength = 14;
inline constexpr int kLeastRansPrecision = 12, kMostRansPrecision = 20;

LATTICED_HD constexpr int RansPrecision(int bit_length) {
  const int bits = 3 * bit_length / 2;
  if (bits < kLeastRansPrecision) return kLeastRansPrecision;
  return bits > kMostRansPrecision ? kMostRansPrecision : bits;
}

// The least bit length whose M is at least twice the number of distinct symbols. Then so many symbols get a probability
// without distorting those of the others. 0 where there is none: store the symbols plainly.
LATTICED_HD constexpr int RansBitLength(uint32_t distinct_symbols) {
  for (int bit_length = kLeastRansBitLength; bit_length <= kMostRansBitLength; ++bit_length) {
    if (distinct_symbols <= uint32_t{1} << (RansPrecision(bit_length) - 1)) return bit_length;
  }
  return 0;
}

// Bytes of a symbol that is stored plainly.
LATTICED_HD constexpr uint32_t PlainSymbolBytes(uint32_t largest_symbol) {
  return largest_symbol < 0x100 ? 1 : largest_symbol < 0x10000 ? 2 : 4;
}

// Decides, after the table and the states are coded, whether the plain symbols take less.
LATTICED_HD constexpr bool StorePlainly(uint64_t coded_bytes, uint64_t symbols,
                                        uint32_t largest_symbol) {
  return coded_bytes > symbols * PlainSymbolBytes(largest_symbol);
}

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_RANS_MODEL_H_
