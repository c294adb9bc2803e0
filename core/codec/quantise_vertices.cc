// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/codec/quantise_vertices.cc"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target, as Highway asks.
#include "core/codec/quantise_vertices-inl.h"
#include "core/codec/quantise_vertices.h"
#include "hwy/highway.h"

#if HWY_ONCE
namespace latticed {
namespace quantise {

HWY_EXPORT(QuantiseImpl);

void Quantise(const FloatVertices& vertices, const QuantisedPlanes& planes) {
  HWY_DYNAMIC_DISPATCH(QuantiseImpl)(vertices, planes);
}

}  // namespace quantise

QuantisedVertices QuantiseVertices(const FloatVertices& vertices, uint8_t* bytes) {
  const size_t points = vertices.point_count;
  auto* positions = reinterpret_cast<uint16_t*>(bytes);
  uint8_t* normals = bytes + 6 * points;
  quantise::Quantise(vertices, {.position = {positions, positions + points, positions + 2 * points},
                                .s = normals,
                                .t = normals + points * (vertices.normal_bits <= 8 ? 1 : 2)});
  return QuantisedVertices::FromBytes({bytes, 10 * points}, points, vertices.position_bits,
                                      vertices.normal_bits);
}

}  // namespace latticed
#endif  // HWY_ONCE
