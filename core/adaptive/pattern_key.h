// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The name of an adaptive pattern: the levels of a patch's three edges, and whether the pattern is the sparser one.
//
//   bits of the code on the wire, a little-endian uint16:   0-2 level of edge 0, 3-5 of edge 1, 6-8 of edge 2, 9 sparse
//
// Edge e joins corner e and corner (e + 1) % 3. An edge of level k has 2^k segments of equal length.
#ifndef LATTICED_CORE_ADAPTIVE_PATTERN_KEY_H_
#define LATTICED_CORE_ADAPTIVE_PATTERN_KEY_H_

#include <array>
#include <cstdint>
#include <optional>

#include "core/base/host_device.h"
#include "core/base/limits.h"

namespace latticed {

inline constexpr int kPatternCodeBits = 10;

struct PatternKey {
  std::array<uint8_t, 3> levels{};  // each 0 … limits::kMaxEdgeLevel
  bool sparse = false;

  LATTICED_HD constexpr uint16_t Code() const {
    return static_cast<uint16_t>(levels[0] | levels[1] << 3 | levels[2] << 6 | int{sparse} << 9);
  }
  // nullopt for a code that names no pattern.
  static constexpr std::optional<PatternKey> FromCode(uint16_t code) {
    if (code >> kPatternCodeBits != 0) return std::nullopt;
    PatternKey key{.sparse = (code >> 9 & 1) != 0};
    for (size_t e = 0; e < 3; ++e) {
      key.levels[e] = static_cast<uint8_t>(code >> (3 * e) & 7);
      if (key.levels[e] > limits::kMaxEdgeLevel) return std::nullopt;
    }
    return key;
  }
  friend bool operator==(const PatternKey&, const PatternKey&) = default;
};

}  // namespace latticed

#endif  // LATTICED_CORE_ADAPTIVE_PATTERN_KEY_H_
