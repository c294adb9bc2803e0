// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The state of a range-coded asymmetric numeral system (Duda, arXiv:1311.2540), as Draco reads it.
//
//   state x in [4 M, 1024 M), M = 2^precision; symbols are put in reverse order:
//   while x >= 1024 p: one byte of x leaves;  x := floor(x / p) M + x mod p + c
//
// where p is the symbol's probability of M, and c the sum of the probabilities of smaller symbols. The division is done
// by multiplication: x < 1024 p and p <= 2^20, so x * ceil(2^50 / p) stays below 2^61 and the quotient is exact.
#ifndef LATTICED_CORE_CODEC_RANS_ENCODER_H_
#define LATTICED_CORE_CODEC_RANS_ENCODER_H_

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/codec/byte_writer.h"

namespace latticed {

struct RansEntry {
  uint64_t reciprocal;
  uint32_t probability, cumulative;
};

// A symbol of the least probability takes `precision` bits, and the last state four bytes.
inline size_t MostRansBytes(size_t symbols, int precision) {
  return symbols * static_cast<size_t>((precision + 7) / 8) + 4;
}

inline RansEntry MakeRansEntry(uint32_t probability, uint32_t cumulative) {
  return {((uint64_t{1} << 50) + probability - 1) / probability, probability, cumulative};
}

// Writes the last state in one to four bytes and returns their end. The two high bits of the last
// byte, which is where a reader begins, tell how many.
inline uint8_t* FinishRans(uint32_t state, int precision, uint8_t* out) {
  const uint32_t above = state - (uint32_t{4} << precision);
  const uint32_t more_bytes = above < 1u << 6 ? 0 : above < 1u << 14 ? 1 : above < 1u << 22 ? 2 : 3;
  const uint32_t word = above | more_bytes << (8 * more_bytes + 6);
  for (uint32_t b = 0; b <= more_bytes; ++b) *out++ = static_cast<uint8_t>(word >> (8 * b));
  return out;
}

class RansEncoder {
 public:
  RansEncoder() = default;
  RansEncoder(int precision, uint8_t* out)
      : precision_(precision), state_(uint32_t{4} << precision), out_(out) {}

  void Put(const RansEntry& entry) {
    const uint32_t limit = entry.probability << 10;
    while (state_ >= limit) {
      *out_++ = static_cast<uint8_t>(state_);
      state_ >>= 8;
    }
    Push(state_, entry);
  }

  // Put for precisions up to 16, where at most two bytes leave the state. It has no branch to mispredict; it always
  // writes two bytes.
  void PutShort(const RansEntry& entry) {
    const uint32_t limit = entry.probability << 10;
    const uint32_t leaving = (state_ >= limit ? 1u : 0u) + (state_ >> 8 >= limit ? 1u : 0u);
    const auto low = static_cast<uint16_t>(state_);
    std::memcpy(out_, &low, sizeof(low));
    out_ += leaving;
    Push(state_ >> (8 * leaving), entry);
  }

  // Returns the end of the bytes.
  uint8_t* Finish() { return FinishRans(state_, precision_, out_); }

 private:
  void Push(uint32_t state, const RansEntry& entry) {
    const auto quotient = static_cast<uint32_t>((state * entry.reciprocal) >> 50);
    state_ =
        state + quotient * ((uint32_t{1} << precision_) - entry.probability) + entry.cumulative;
  }

  int precision_ = 0;
  uint32_t state_ = 0;
  uint8_t* out_ = nullptr;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_RANS_ENCODER_H_
