// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_CLIENT_DECODER_LANES_POSITION_STEP_H_
#define LATTICED_CLIENT_DECODER_LANES_POSITION_STEP_H_

#include <cstdint>

namespace latticed::decoder {

// The inverse of PositionSymbol in core/codec/draco_symbols.h, for values that are counted from the least one.
constexpr int32_t NextPosition(int32_t previous, uint32_t symbol, int32_t span) {
  const auto half = static_cast<int32_t>(symbol >> 1);
  const int32_t sum = previous + ((symbol & 1) != 0 ? -half - 1 : half);
  return sum < 0 ? sum + span : sum >= span ? sum - span : sum;
}

}  // namespace latticed::decoder

#endif  // LATTICED_CLIENT_DECODER_LANES_POSITION_STEP_H_
