// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Differences of the meshopt codec, several side by side in a word, the first in the lowest bits
// (core/codec/meshopt/meshopt_format.h).
#ifndef LATTICED_CUDA_MESHOPT_MESHOPT_DIFFERENCES_H_
#define LATTICED_CUDA_MESHOPT_MESHOPT_DIFFERENCES_H_

#include <cstdint>

#include "core/base/host_device.h"

namespace latticed::kernels {

// The differences of numbers of kBits bits, 8 or 16, zigzag.
template <unsigned kBits>
LATTICED_HD constexpr uint32_t ZigzagDifferences(uint32_t to, uint32_t from) {
  constexpr uint32_t kOnes = kBits == 8 ? 0x01010101u : 0x00010001u;
  constexpr uint32_t kTops = kOnes << (kBits - 1);
  const uint32_t differences = ((to | kTops) - (from & ~kTops)) ^ ((to ^ ~from) & kTops);
  const uint32_t negative = differences >> (kBits - 1) & kOnes;
  return ((differences & ~kTops) << 1) ^ (negative * ((1u << kBits) - 1));
}

// Eight bytes.
struct EightBytes {
  uint32_t lower, upper;
};

// Eight marks: that of byte k is bit 7 of byte k, and that of byte k + 4 is bit 6 of it, for k below 4.
LATTICED_HD constexpr uint32_t MarkOf(uint32_t k) { return 1u << (8 * (k % 4) + 7 - k / 4); }

// Marks the bytes that are at least `limit`, which is 1 … 128.
LATTICED_HD constexpr uint32_t MarkFrom(EightBytes bytes, uint32_t limit) {
  constexpr uint32_t kTops = 0x80808080u;
  const uint32_t above = (128 - limit) * 0x01010101u;
  const uint32_t lower = (((bytes.lower & ~kTops) + above) | bytes.lower) & kTops;
  const uint32_t upper = (((bytes.upper & ~kTops) + above) | bytes.upper) & kTops;
  return lower | upper >> 1;
}

// The codes of eight differences in one bit each, two or four. `marks`: those that do not fit.
LATTICED_HD constexpr uint32_t OneBitEach(uint32_t marks) {
  constexpr uint32_t kOnes = 0x01010101u;
  // Each product has its bits apart, four of them in the highest byte.
  return ((marks >> 7 & kOnes) * 0x01020408u + (marks >> 6 & kOnes) * 0x10204080u) >> 24;
}
LATTICED_HD constexpr uint32_t TwoBitsEach(EightBytes bytes, uint32_t marks) {
  constexpr uint32_t kOnes = 0x01010101u, kGather = 0x40100401u;
  const uint32_t lower = (bytes.lower | (marks >> 7 & kOnes) * 0xff) & 0x03030303u;
  const uint32_t upper = (bytes.upper | (marks >> 6 & kOnes) * 0xff) & 0x03030303u;
  return lower * kGather >> 24 | (upper * kGather >> 24) << 8;
}
LATTICED_HD constexpr uint32_t FourBitsEach(EightBytes bytes, uint32_t marks) {
  constexpr uint32_t kOnes = 0x01010101u, kEven = 0x00ff00ffu;
  const uint32_t lower = (bytes.lower | (marks >> 7 & kOnes) * 0xff) & 0x0f0f0f0fu;
  const uint32_t upper = (bytes.upper | (marks >> 6 & kOnes) * 0xff) & 0x0f0f0f0fu;
  const uint32_t low = (lower << 4 | lower >> 8) & kEven, high = (upper << 4 | upper >> 8) & kEven;
  return ((low | low >> 8) & 0xffff) | (high | high >> 8) << 16;
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_MESHOPT_MESHOPT_DIFFERENCES_H_
