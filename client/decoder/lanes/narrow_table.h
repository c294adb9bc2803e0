// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The probabilities of one stream of symbols, in a form that decodes fast. A symbol's rank is its place among those that
// occur.
//
//   state x, M = 2^precision, slot = x mod M, q = floor(x / M)
//   the symbol is the one with cumulative <= slot < cumulative + probability; the state before it was coded is
//   probability q + slot - cumulative = x - cumulative - q (M - probability)
#ifndef LATTICED_CLIENT_DECODER_LANES_NARROW_TABLE_H_
#define LATTICED_CLIENT_DECODER_LANES_NARROW_TABLE_H_

#include <cstdint>

namespace latticed::decoder {

// Almost all tables have this precision and so few symbols.
inline constexpr int kNarrowPrecision = 12;
inline constexpr uint32_t kNarrowSlots = 1u << kNarrowPrecision, kNarrowSymbols = 256;
// Where the state lies in a word of 64 bits: at the top, with bytes of the stream below it.
inline constexpr int kStateShift = 42;

struct NarrowTable {
  uint8_t rank[kNarrowSlots];
  // By rank. The first two are shifted to the state's place in the word.
  uint64_t cumulative[kNarrowSymbols];
  uint64_t complement[kNarrowSymbols];  // M - probability
  uint16_t symbol[kNarrowSymbols];
};

}  // namespace latticed::decoder

#endif  // LATTICED_CLIENT_DECODER_LANES_NARROW_TABLE_H_
