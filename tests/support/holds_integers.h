// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_TESTS_SUPPORT_HOLDS_INTEGERS_H_
#define LATTICED_TESTS_SUPPORT_HOLDS_INTEGERS_H_

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/codec/chunk_encoder.h"
#include "core/codec/draco_decode.h"

namespace latticed::testing {

// Whether libdraco decodes exactly the integers of `v` from the stream.
[[nodiscard]] inline bool HoldsIntegers(std::span<const uint8_t> stream,
                                        const QuantisedVertices& v) {
  const auto decoded = DecodeDracoChunkIntegers(stream);
  if (!decoded.ok() || decoded->positions.size() != 3 * v.point_count ||
      decoded->normals.size() != (v.normal_bits == 0 ? 0 : 2 * v.point_count)) {
    return false;
  }
  const auto code = [&](const uint8_t* plane, size_t i) {
    return v.normal_bits <= 8 ? uint32_t{plane[i]} : plane[2 * i] | uint32_t{plane[2 * i + 1]} << 8;
  };
  for (size_t i = 0; i < v.point_count; ++i) {
    const uint32_t* p = &decoded->positions[3 * i];
    if (p[0] != v.x[i] || p[1] != v.y[i] || p[2] != v.z[i]) return false;
    if (v.normal_bits == 0) continue;
    const uint32_t* n = &decoded->normals[2 * i];
    if (n[0] != code(v.s, i) || n[1] != code(v.t, i)) return false;
  }
  return true;
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SUPPORT_HOLDS_INTEGERS_H_
