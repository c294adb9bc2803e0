// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A symbol's entry in a table on the device, in eight bytes, and the step of the rANS state that it
// encodes (core/codec/rans_encoder.h). The state x takes a symbol of probability p and cumulative c:
//
//   b bytes leave: the least b with y = floor(x / 2^8b) < 1024 p;  x' = floor(y / p) M + y mod p + c
//
//                at 12 bits                              at more
//   first word   1 / p, rounded up to a float            p
//   second word  p | c << 13                             c
//
// Each step waits for the one before, so what counts is how long a step takes. At 12 bits, the precision of nearly all
// tables, x is below 2^22, and a step is done in float32, whose instructions take the fewest cycles. Integers below 2^24 are
// exact in float32. A float from 2^23 on has no bits behind the point, so that
//
//   floor(a b) = (a b + 2^23, rounded down) - 2^23,      and the low bits of the float 2^23 + x are those of x.
//
// A state is kept as the float 2^23 + x. At most two bytes leave:
//
//   x1 = floor(x / 2^8), x2 = floor(x / 2^16)
//   z1 = 1 where x >= 1024 p, else 0;  z2 = 1 where x1 >= 1024 p, else 0       differences, clamped to [0, 1]
//   y  = x + z1 (x1 - x) + z2 (x2 - x1)
//   x' = q (M - p) + y + c,  q = floor(y r),  r = 1 / p rounded up
//
// q is exact: y r exceeds y / p by less than 2^-23 y / p, which is below 1 / p, the distance of y / p from a higher integer.
//
// Threads  pure functions, on host and device
#ifndef LATTICED_CUDA_DRACO_RANS_ENTRY_H_
#define LATTICED_CUDA_DRACO_RANS_ENTRY_H_

#include <vector_types.h>

#include <bit>
#include <cstdint>

#include "core/base/host_device.h"
#include "core/codec/rans_model.h"

namespace latticed::kernels {

inline constexpr uint32_t kShortM = uint32_t{1} << kLeastRansPrecision;

LATTICED_HD inline uint2 MakeShortEntry(uint32_t probability, uint32_t cumulative) {
  const auto nearest = static_cast<float>(1.0 / probability);
  const bool below = static_cast<double>(nearest) * probability < 1;  // 24 and 13 bits: exact
  return {std::bit_cast<uint32_t>(nearest) + (below ? 1u : 0u), probability | cumulative << 13};
}

// A state as the float 2^23 + x.
inline constexpr float kStateBase = 1 << 23;
LATTICED_HD inline uint32_t StateOf(float state) {
  return std::bit_cast<uint32_t>(state) & 0x7fffff;
}
LATTICED_HD inline float ToState(uint32_t x) {
  return std::bit_cast<float>(std::bit_cast<uint32_t>(kStateBase) | x);
}

// An entry taken apart for a step.
struct alignas(16) ShortEntry {
  float reciprocal;  // r
  float above;       // 1 - 1024 p - 2^23
  uint32_t rest;     // M - p
  uint32_t sum;      // c less rest times the bits of the float 2^23
};
LATTICED_HD inline ShortEntry TakeApart(uint2 entry) {
  const uint32_t p = entry.y & 0x1fff, rest = kShortM - p;
  // The bits of -2^23, and behind them what is added to it.
  const uint32_t above = std::bit_cast<uint32_t>(-kStateBase) + (1024 * p - 1);
  return {std::bit_cast<float>(entry.x), std::bit_cast<float>(above), rest,
          (entry.y >> 13) - std::bit_cast<uint32_t>(kStateBase) * rest};
}

// The step and its parts. Arithmetic has a + b clamped to [0, 1], and a b + c to the nearest float and down.
template <class Arithmetic>
LATTICED_HD inline float WithoutByte(float state) {  // 2^23 + x1
  return Arithmetic::MultiplyAddDown(state, 1.0f / 256, kStateBase - kStateBase / 256);
}
// Whether a byte leaves. With WithoutByte(state): whether a second one does.
LATTICED_HD inline bool ByteLeaves(float state, float above) { return state + above > 0; }

template <class Arithmetic>
LATTICED_HD inline float ShortStep(float state, const ShortEntry& entry) {
  constexpr float kBy2 = 1.0f / 65536;
  const float state1 = WithoutByte<Arithmetic>(state);
  const float state2 = Arithmetic::MultiplyAddDown(state, kBy2, kStateBase - kStateBase * kBy2);
  const float z1 = Arithmetic::ClampedSum(state, entry.above);
  const float z2 = Arithmetic::ClampedSum(state1, entry.above);
  const float change1 = state1 - state, change2 = state2 - state1;
  // y, and beside it 2^23 + y.
  const float y = Arithmetic::MultiplyAdd(z2, change2,
                                          Arithmetic::MultiplyAdd(z1, change1, state - kStateBase));
  const float state_y =
      Arithmetic::MultiplyAdd(z2, change2, Arithmetic::MultiplyAdd(z1, change1, state));
  const float quotient = Arithmetic::MultiplyAddDown(y, entry.reciprocal, kStateBase);
  return std::bit_cast<float>(std::bit_cast<uint32_t>(quotient) * entry.rest +
                              (std::bit_cast<uint32_t>(state_y) + entry.sum));
}

LATTICED_HD inline uint2 MakeLongEntry(uint32_t probability, uint32_t cumulative) {
  return {probability, cumulative};
}
LATTICED_HD inline uint32_t LongStep(uint32_t x, uint2 entry, int precision) {
  return x + entry.y + x / entry.x * ((uint32_t{1} << precision) - entry.x);
}

LATTICED_HD inline uint2 MakeEntry(uint32_t probability, uint32_t cumulative, int precision) {
  return precision == kLeastRansPrecision ? MakeShortEntry(probability, cumulative)
                                          : MakeLongEntry(probability, cumulative);
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_DRACO_RANS_ENTRY_H_
