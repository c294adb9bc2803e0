// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Between how many bytes the states of rANS symbols take, from what a table's probabilities say of them:
//
//   bits = sum of log2(M / p) over the symbols
//
// A step x' = floor(x / p) M + x mod p + c begins with x >= 4 p, where all bytes that must leave have left. So
//
//   4/5 x M / p < floor(x / p) M <= x' < (x / p + 1) M <= 5/4 x M / p
//
// also where x is the state before bytes left: a symbol adds log2(M / p) bits, more or less by at most
// log2(5/4) = 0.322. Eight of these leave with each byte, and log2(x / 4 M) stay in the last state x. It takes at most
// four bytes, and at least one and an eighth of what stays, less 0.006 bits. 0.33 in place of 0.322 has room for these,
// and for a sum of bits that is rounded by a thousandth a symbol.
//
// Threads  pure functions, on host and device
#ifndef LATTICED_CUDA_DRACO_CODED_BOUNDS_H_
#define LATTICED_CUDA_DRACO_CODED_BOUNDS_H_

#include <cstdint>

#include "core/base/host_device.h"

namespace latticed::kernels {

inline constexpr float kStepBits = 0.33f;

// `bits`: at least the sum.
LATTICED_HD constexpr uint32_t MostCodedBytes(float bits, uint32_t symbols) {
  constexpr uint32_t kLastState = 4;
  return static_cast<uint32_t>((bits + kStepBits * static_cast<float>(symbols)) / 8) + kLastState;
}

// `bits`: at most the sum. For any probabilities, it is at least the sum of log2(symbols / count) over the symbols.
LATTICED_HD constexpr uint32_t LeastCodedBytes(float bits, uint32_t symbols) {
  const float kept = bits - kStepBits * static_cast<float>(symbols);
  return 1 + (kept > 0 ? static_cast<uint32_t>(kept / 8) : 0);
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_DRACO_CODED_BOUNDS_H_
