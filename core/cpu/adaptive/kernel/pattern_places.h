// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The points of a pattern as places between the corners of a patch, in the form of adaptive_kernel.h.
//
//   corner e                   a = b = c = e
//   point k of edge e          a = e, b = (e + 1) % 3, along = k / 2^level - 1/2, up = 0
//   inner point (b0, b1, b2)   a = 0, b = 1, c = 2, along = b1 - 1/2 + b2 / 2, up = b2
//
// All numbers are exact in float32.
//
// Threads  Get returns one immutable table per pattern, made on first use
#ifndef LATTICED_CORE_CPU_ADAPTIVE_KERNEL_PATTERN_PLACES_H_
#define LATTICED_CORE_CPU_ADAPTIVE_KERNEL_PATTERN_PLACES_H_

#include <cstdint>
#include <vector>

#include "core/adaptive/adaptive_pattern.h"

namespace latticed {

struct PatternPlaces {
  explicit PatternPlaces(const AdaptivePattern& pattern);

  // By point: PlaceCode, and the two numbers.
  std::vector<int32_t> code;
  std::vector<float> along, up;

  // `code` is PatternKey::Code.
  static const PatternPlaces& Get(uint16_t code);
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_ADAPTIVE_KERNEL_PATTERN_PLACES_H_
