// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Converts vertices from the RAW layout to the QUANTISED layout, which encoders take.
//
//   position   integer = clamp(round(p * scale + offset), 0, 2^position_bits - 1) in float32, each
//              operation rounded by itself, ties to even; NaN becomes 0
//   normal     exactly QuantiseNormal of core/codec/octahedral.h
//
// Units    scale = 1 / step of the quantisation box
//          offset = (origin of the floats - origin of the box) / step
// Threads  pure function; gives the same integers under every instruction set
#ifndef LATTICED_TESTS_BENCH_CODEC_QUANTISE_VERTICES_H_
#define LATTICED_TESTS_BENCH_CODEC_QUANTISE_VERTICES_H_

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/codec/chunk_encoder.h"

namespace latticed {

struct FloatVertices {
  size_t point_count = 0;
  const float* values = nullptr;  // per point: x y z [nx ny nz]
  std::array<float, 3> scale{1, 1, 1}, offset{0, 0, 0};
  int position_bits = 12;
  int normal_bits = 0;  // 0: no normals in `values`
};

// Where the integers go. Up to 8 bits, s and t take one byte each, otherwise two.
struct QuantisedPlanes {
  std::array<uint16_t*, 3> position;
  uint8_t *s, *t;
};

// `bytes` holds 10 bytes per point, 2-byte aligned. The result points into it.
[[nodiscard]] QuantisedVertices QuantiseVertices(const FloatVertices& vertices, uint8_t* bytes);

}  // namespace latticed

#endif  // LATTICED_TESTS_BENCH_CODEC_QUANTISE_VERTICES_H_
