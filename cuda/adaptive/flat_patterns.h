// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// All adaptive patterns in three flat tables, as kernels read them. Twin of core/cpu/adaptive/kernel/pattern_places.h.
//
//   heads       by PatternKey::Code: where the entries of a pattern begin in the other tables, and how many there are
//   places      of the points of a pattern, in its order
//   triangles   AdaptivePattern::longest, what a certificate looks at
//
// A place is m + along d + up (c - m), with m = (a + b) / 2, d = b - a and a, b, c corners of the patch:
//
//   corner e                   a = b = c = e
//   point k of edge e          a = e, b = (e + 1) % 3, along = k / 2^level - 1/2, up = 0
//   inner point (b0, b1, b2)   a = 0, b = 1, c = 2, along = b1 - 1/2 + b2 / 2, up = b2
//
// Exchanging a and b changes the signs of d and along, exactly, so both patches of an edge get the same place, bit for
// bit. All numbers are exact in float32.
//
// Units    none
// Threads  Get makes the tables once per process; they are immutable
#ifndef LATTICED_CUDA_ADAPTIVE_FLAT_PATTERNS_H_
#define LATTICED_CUDA_ADAPTIVE_FLAT_PATTERNS_H_

#include <cstdint>
#include <vector>

#include "core/adaptive/pattern_key.h"
#include "core/base/host_device.h"

namespace latticed {
namespace kernels {

struct PatternHead {
  uint32_t first_place, first_triangle;
  uint16_t points, triangles;
};

//   bits 0..13   4096 + 8192 along      14..26   4096 up      27..29   kind
// Kind 0..2 is a corner, 3..5 an edge, 6 the inside.
struct PatternPlace {
  static constexpr int kInside = 6;
  uint32_t word;

  static PatternPlace Make(int kind, int along_8192, int up_4096) {
    return {static_cast<uint32_t>(along_8192 + 4096) | static_cast<uint32_t>(up_4096) << 14 |
            static_cast<uint32_t>(kind) << 27};
  }
  LATTICED_HD int Kind() const { return static_cast<int>(word >> 27); }
  LATTICED_HD float Along() const {
    return static_cast<float>(static_cast<int>(word & 16383) - 4096) * 0x1p-13f;
  }
  LATTICED_HD float Up() const { return static_cast<float>(word >> 14 & 8191) * 0x1p-12f; }
};

// |d| of each side, d the difference of its ends' barycentrics.
struct PatternTriangle {
  float side[3][3];
};

}  // namespace kernels

struct FlatPatterns {
  std::vector<kernels::PatternHead> heads;  // zeros for codes that name no pattern
  std::vector<kernels::PatternPlace> places;
  std::vector<kernels::PatternTriangle> triangles;

  static const FlatPatterns& Get();
};

}  // namespace latticed

#endif  // LATTICED_CUDA_ADAPTIVE_FLAT_PATTERNS_H_
