// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Rounds a block of points at a time, in loops that compilers vectorise: no branches, each
// component by itself. The definition rounds normals in double. Here a normal is rounded in float32
// where that cannot differ, otherwise by the definition.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/bench/codec/quantise_vertices.cc"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Highway asks for this include after foreach_target.h.
#include "core/codec/octahedral.h"
#include "hwy/highway.h"
#include "tests/bench/codec/quantise_vertices.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::quantise {
namespace HWY_NAMESPACE {

// A block is the points that are rounded together; a plane is one component of them.
constexpr size_t kBlock = 64;
using Plane = float[kBlock];

// A float of 2^23 or more has no bits for a fraction. After adding 2^23 to a smaller number, the
// low bits are the integer, rounded to even.
constexpr float kNoFraction = 0x1p23f;
inline float Rounded(float value) { return (value + kNoFraction) - kNoFraction; }

template <class T>
void StoreIntegers(const Plane& values, void* out) {
  T integers[kBlock];
  for (size_t i = 0; i < kBlock; ++i) {
    integers[i] = static_cast<T>(std::bit_cast<uint32_t>(values[i] + kNoFraction));
  }
  std::memcpy(out, integers, sizeof(integers));
}

// Reads two components at a time, because there are loads and shuffles for pairs.
template <size_t kComponents>
void SplitPairs(const float* points, Plane& first, Plane& second) {
  float pairs[2 * kBlock];
  for (size_t i = 0; i < kBlock; ++i) {
    std::memcpy(&pairs[2 * i], points + kComponents * i, 2 * sizeof(float));
  }
  for (size_t i = 0; i < kBlock; ++i) {
    first[i] = pairs[2 * i];
    second[i] = pairs[2 * i + 1];
  }
}

void ClampToGrid(Plane& values, float scale, float offset, float top) {
  for (size_t i = 0; i < kBlock; ++i) {
    const float grid = values[i] * scale + offset;
    const float positive = grid > 0.0f ? grid : 0.0f;  // also for NaN
    values[i] = positive < top ? positive : top;
  }
}

// How near to a half the fraction may be before float32 is not trusted: six roundings of numbers up
// to `centre`, 2^-24 of them each, doubled.
constexpr float kSlack = 0x1p-20f;
// Float32 is trusted for L1 norms between these. Draco's shortest normal is 1e-6.
constexpr float kShortest = 1e-5f, kLongest = 1e30f;

// QuantiseNormal in float32: y becomes s and z becomes t. Returns whether any result could differ
// from the definition, and marks those in `doubtful`: normals near a half, on the rim of the
// octahedral square, too short, or not finite.
bool QuantiseNormals(const Plane& x, Plane& y, Plane& z, float centre, int32_t* doubtful) {
  const float most = 0.5f - centre * kSlack;
  int32_t any = 0;
  for (size_t i = 0; i < kBlock; ++i) {
    const float sum = std::abs(x[i]) + std::abs(y[i]) + std::abs(z[i]), scale = centre / sum;
    const float gx = std::abs(x[i]) * scale, gy = std::abs(y[i]) * scale;
    const float ix = Rounded(gx), iy = Rounded(gy);
    // z takes the rounding errors of x and y. If that makes it negative, y takes the rest.
    const float rest = centre - ix - iy;
    const float ay = iy + (rest < 0.0f ? rest : 0.0f), az = rest > 0.0f ? rest : 0.0f;
    // Behind the diamond: mirror at the nearest side, where centre - |z| = |y| + |x|.
    const float fold = x[i] < 0.0f ? ix : 0.0f;
    y[i] = centre + std::copysign(ay + fold, y[i]);
    z[i] = centre + std::copysign(az + fold, z[i] + 0.0f);  // -0 is not below 0

    const float off_x = std::abs(gx - ix), off_y = std::abs(gy - iy), least = ay < az ? ay : az;
    float off = off_x < off_y ? off_y : off_x;
    off = least > 0.0f ? off : off + fold;  // on the rim two points are one direction
    off = sum > kShortest ? off : 1.0f;
    off = sum < kLongest ? off : 1.0f;
    doubtful[i] = off < most ? 0 : 1;
    any |= doubtful[i];
  }
  return any != 0;
}

template <class T>
void StoreNormals(const float* points, int bits, Plane& x, Plane& y, Plane& z, uint8_t* s,
                  uint8_t* t) {
  const int32_t half = OctahedralMax(bits) / 2;
  const auto centre = static_cast<float>(half);
  int32_t doubtful[kBlock];
  const bool any = QuantiseNormals(x, y, z, centre, doubtful);
  for (size_t i = 0; any && i < kBlock; ++i) {
    if (doubtful[i] == 0) continue;
    const float* n = points + 6 * i + 3;
    const OctahedralNormal q = QuantiseNormal({n[0], n[1], n[2]}, bits);
    y[i] = static_cast<float>(q.s);
    z[i] = static_cast<float>(q.t);
  }
  StoreIntegers<T>(y, s);
  StoreIntegers<T>(z, t);
}

// T is the type that s and t are stored as.
template <class T, bool kNormals>
void QuantiseBlock(const FloatVertices& v, const float* points, const QuantisedPlanes& out) {
  Plane plane[6];
  if constexpr (kNormals) {
    for (size_t c = 0; c < 6; c += 2) SplitPairs<6>(points + c, plane[c], plane[c + 1]);
    StoreNormals<T>(points, v.normal_bits, plane[3], plane[4], plane[5], out.s, out.t);
  } else {
    for (size_t c = 0; c < 2; ++c) SplitPairs<3>(points + c, plane[c], plane[c + 1]);
  }
  const auto top = static_cast<float>((1 << v.position_bits) - 1);
  for (size_t c = 0; c < 3; ++c) {
    ClampToGrid(plane[c], v.scale[c], v.offset[c], top);
    StoreIntegers<uint16_t>(plane[c], out.position[c]);
  }
}

template <class T, bool kNormals>
void QuantiseBlocks(const FloatVertices& v, const QuantisedPlanes& planes) {
  constexpr size_t kComponents = kNormals ? 6 : 3;
  const auto& [x, y, z] = planes.position;
  const float* points = v.values;
  size_t i = 0;
  for (; i + kBlock <= v.point_count; i += kBlock, points += kComponents * kBlock) {
    QuantiseBlock<T, kNormals>(v, points,
                               {.position = {x + i, y + i, z + i},
                                .s = planes.s + sizeof(T) * i,
                                .t = planes.t + sizeof(T) * i});
  }
  const size_t rest = v.point_count - i;
  if (rest == 0) return;
  // The last points, in a block padded with zeros.
  float block[kComponents * kBlock] = {};
  std::memcpy(block, points, rest * kComponents * sizeof(float));
  uint16_t position[3][kBlock];
  uint8_t s[sizeof(T) * kBlock], t[sizeof(T) * kBlock];
  QuantiseBlock<T, kNormals>(v, block,
                             {.position = {position[0], position[1], position[2]}, .s = s, .t = t});
  for (size_t c = 0; c < 3; ++c) std::copy_n(position[c], rest, planes.position[c] + i);
  if constexpr (kNormals) {
    std::copy_n(s, sizeof(T) * rest, planes.s + sizeof(T) * i);
    std::copy_n(t, sizeof(T) * rest, planes.t + sizeof(T) * i);
  }
}

void QuantiseImpl(const FloatVertices& v, const QuantisedPlanes& planes) {
  if (v.normal_bits == 0) return QuantiseBlocks<uint8_t, false>(v, planes);
  if (v.normal_bits <= 8) return QuantiseBlocks<uint8_t, true>(v, planes);
  QuantiseBlocks<uint16_t, true>(v, planes);
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::quantise
HWY_AFTER_NAMESPACE();

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
