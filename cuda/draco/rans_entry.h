// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A symbol's entry in a table on the device, in eight bytes, and the step of the rANS state that it
// encodes (core/codec/rans_encoder.h):  x' = floor(x / p) M + x mod p + c.
//
// At 12 bits, the precision of nearly all tables, a multiplication replaces the division. With
// s = ceil(log2 p) and R = ceil(2^(31 + s) / p), which is below 2^32 for p >= 2,
//
//   floor(x / p) = floor(x R / 2^32) >> (s - 1)        for x < 2^31 (Granlund and Montgomery 1994)
//
// and x' = x + floor(x / p) (M - p) + c. For p = 1, s is 1 and R would be 2^32, which does not fit.
// R = 2^32 - 1 gives x - 1 instead of x, and c' = c + M - 1 in place of c corrects that.
//
//                at 12 bits                        at more
//   first word   R                                 p
//   second word  p | c' << 13 | (s - 1) << 26      c
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

LATTICED_HD inline uint32_t HighProduct(uint32_t a, uint32_t b) {
  return static_cast<uint32_t>((uint64_t{a} * b) >> 32);
}

LATTICED_HD inline uint2 MakeShortEntry(uint32_t probability, uint32_t cumulative) {
  if (probability == 1) return {0xffffffffu, 1 | (cumulative + kShortM - 1) << 13};
  // The exponent of p - 1 in float32, which holds it exactly.
  const uint32_t shift =
      (std::bit_cast<uint32_t>(static_cast<float>(probability - 1)) >> 23) - 127u;  // log - 1
  // In double, since a device divides 64-bit integers slowly. A quotient has at most 32 bits before the point, and is an
  // integer or 1 / M away from one, so that rounding to 53 bits cannot change how it is rounded up.
  const double quotient = static_cast<double>(uint64_t{1} << (32 + shift)) / probability;
  const auto floor = static_cast<uint32_t>(quotient);
  return {floor + (static_cast<double>(floor) < quotient ? 1u : 0u),
          probability | cumulative << 13 | shift << 26};
}
LATTICED_HD inline uint32_t ShortProbability(uint2 entry) { return entry.y & 0x1fff; }
LATTICED_HD inline uint32_t ShortBias(uint2 entry) { return entry.y >> 13 & 0x1fff; }
LATTICED_HD inline uint32_t ShortShift(uint2 entry) { return entry.y >> 26; }
// The step of a state that has emitted its bytes, from the fields of an entry. `rest`: M - p.
LATTICED_HD inline uint32_t ShortStep(uint32_t x, uint32_t reciprocal, uint32_t shift,
                                      uint32_t bias, uint32_t rest) {
  return x + bias + (HighProduct(x, reciprocal) >> shift) * rest;
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
