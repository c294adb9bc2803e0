// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From vertices in the RAW layout to the QUANTISED one, which encoders take.
//
//   position   integer = clamp(p * scale + offset rounded to even, 0, 2^position_bits - 1), float32,
//              each operation rounded by itself; NaN becomes 0
//   normal     QuantiseNormal of core/codec/octahedral.h, exactly
//
// Units    scale: 1 / step of the quantisation box; offset: (origin of the floats - origin of the
//          box) / step
// Threads  pure function; the same integers under every instruction set
#ifndef LATTICED_TESTS_BENCH_CODEC_QUANTISE_VERTICES_H_
#define LATTICED_TESTS_BENCH_CODEC_QUANTISE_VERTICES_H_

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/codec/chunk_encoder.h"

namespace latticed {

struct FloatVertices {
  size_t point_count = 0;
  const float* values = nullptr;  // x y z [nx ny nz] a point
  std::array<float, 3> scale{1, 1, 1}, offset{0, 0, 0};
  int position_bits = 12;
  int normal_bits = 0;  // 0: no normals in `values`
};

// Where the integers go; s and t in one byte up to 8 bits, else in two.
struct QuantisedPlanes {
  std::array<uint16_t*, 3> position;
  uint8_t *s, *t;
};

// `bytes` must have room for 10 a point, 2-byte aligned. The result points into them.
[[nodiscard]] QuantisedVertices QuantiseVertices(const FloatVertices& vertices, uint8_t* bytes);

}  // namespace latticed

#endif  // LATTICED_TESTS_BENCH_CODEC_QUANTISE_VERTICES_H_
