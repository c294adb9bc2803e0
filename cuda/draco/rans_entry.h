// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A symbol's entry in a table on the device, in eight bytes, and the step of the rANS state that it
// encodes (core/codec/rans_encoder.h). The state x takes a symbol of probability p and cumulative c:
//
//   b bytes leave: the least b with y = floor(x / 2^8b) < 1024 p;  x' = floor(y / p) M + y mod p + c
//
// At 12 bits, the precision of nearly all tables, b is at most 2. Two identities shorten the chain of
// steps, each of which waits for the one before. The division does not wait for the comparisons, because
//
//   floor(floor(x / 2^8b) / p) = floor(floor(x / p) / 2^8b).
//
// A multiplication replaces it. With s = ceil(log2 p) and R = ceil(2^(31 + s) / p), which is below 2^32,
//
//   floor(x / p) = floor(2^9 x R / 2^32) >> (s + 8)     for x < 1024 M = 2^22 (Granlund and Montgomery 1994)
//
// and x' = floor(y / p) (M - p) + y + c.
//
//                at 12 bits            at more
//   first word   R                     p
//   second word  p | c << 13 | s << 26 c
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
  // One more than the exponent of p - 1 in float32, which holds it exactly.
  const uint32_t log =
      probability == 1
          ? 0
          : (std::bit_cast<uint32_t>(static_cast<float>(probability - 1)) >> 23) - 126u;
  // In double, since a device divides 64-bit integers slowly. A quotient has at most 32 bits before the point, and is an
  // integer or 1 / M away from one, so that rounding to 53 bits cannot change how it is rounded up.
  const double quotient = static_cast<double>(uint64_t{1} << (31 + log)) / probability;
  const auto floor = static_cast<uint32_t>(quotient);
  return {floor + (static_cast<double>(floor) < quotient ? 1u : 0u),
          probability | cumulative << 13 | log << 26};
}

// An entry taken apart for ShortStep.
struct alignas(16) ShortEntry {
  uint32_t reciprocal;      // R
  uint32_t one_byte;        // 1024 p: from here on a byte leaves, and from 2^8 times it two
  uint32_t rest;            // M - p
  uint32_t cumulative_log;  // c << 5 | s + 8
};
LATTICED_HD inline ShortEntry TakeApart(uint2 entry) {
  const uint32_t p = entry.y & 0x1fff;
  return {entry.x, p << 10, kShortM - p, (entry.y >> 13 & 0x1fff) << 5 | ((entry.y >> 26) + 8)};
}
// The bits that leave the state: 0, 8 or 16.
LATTICED_HD inline uint32_t LeavingBits(uint32_t x, const ShortEntry& entry) {
  const bool any = x >= entry.one_byte, both = x >= entry.one_byte << 8;
  return both ? 16u : any ? 8u : 0u;
}
// The step. `leaving`: LeavingBits.
LATTICED_HD inline uint32_t ShortStep(uint32_t x, uint32_t leaving, const ShortEntry& entry) {
  const uint32_t quotient = HighProduct(x << 9, entry.reciprocal) >> (entry.cumulative_log & 31);
  return (quotient >> leaving) * entry.rest + ((x >> leaving) + (entry.cumulative_log >> 5));
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
