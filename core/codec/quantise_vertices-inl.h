// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// quantise_vertices.h many points at a time. A normal is rounded in float32 where that cannot
// differ from the definition, which rounds in double; else by the definition.
// Included once per instruction set by quantise_vertices.cc.
#if defined(LATTICED_CORE_CODEC_QUANTISE_VERTICES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CODEC_QUANTISE_VERTICES_INL_H_
#undef LATTICED_CORE_CODEC_QUANTISE_VERTICES_INL_H_
#else
#define LATTICED_CORE_CODEC_QUANTISE_VERTICES_INL_H_
#endif

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/codec/octahedral.h"
#include "core/codec/quantise_vertices.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::quantise {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using DF = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;

// How near to where rounding turns float32 is not to be trusted: half a dozen roundings of numbers up
// to 2 `centre`, 2^-24 of them each; doubled.
constexpr float kSlack = 0x1p-20f;
// L1 norms between which float32 is to be trusted. Draco's shortest normal is 1e-6.
constexpr float kShortest = 1e-5f, kLongest = 1e30f;

// QuantiseNormal in float32: false where that could differ, on the rim of the octahedral square, and
// for normals that are too short or not finite. Rounds by truncation, which needs no library.
inline bool QuantiseSurely(const float* n, int bits, OctahedralNormal& q) {
  const int32_t top = OctahedralMax(bits), centre = top / 2;
  const float sum = std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]);
  if (!(sum > kShortest && sum < kLongest)) return false;
  const auto centre_value = static_cast<float>(centre);
  const float scale = centre_value / sum, up = centre_value + 1.5f;
  const float x = n[0] * scale + up, y = n[1] * scale + up;  // positive
  const auto ix = static_cast<int32_t>(x), iy = static_cast<int32_t>(y);
  const float slack = centre_value * kSlack, most = 1.0f - slack;
  const float part_x = x - static_cast<float>(ix), part_y = y - static_cast<float>(iy);
  if (part_x < slack || part_x > most || part_y < slack || part_y > most) return false;
  const int32_t a = ix - centre - 1;
  int32_t b = iy - centre - 1, c = centre - std::abs(a) - std::abs(b);
  if (c < 0) {
    b += b > 0 ? c : -c;
    c = 0;
  }
  if (n[2] < 0) c = -c;
  if (a >= 0) {
    q = {b + centre, c + centre};
    return true;
  }
  q = {b < 0 ? std::abs(c) : top - std::abs(c), c < 0 ? std::abs(b) : top - std::abs(b)};
  return b != 0 && c != 0;
}

template <class T>
void StoreNormal(const FloatVertices& v, const QuantisedPlanes& planes, size_t i) {
  const float* n = v.values + 6 * i + 3;
  OctahedralNormal q;
  if (!QuantiseSurely(n, v.normal_bits, q)) q = QuantiseNormal({n[0], n[1], n[2]}, v.normal_bits);
  const T s = static_cast<T>(q.s), t = static_cast<T>(q.t);
  std::memcpy(planes.s + sizeof(T) * i, &s, sizeof(T));
  std::memcpy(planes.t + sizeof(T) * i, &t, sizeof(T));
}

template <class T, bool kNormals>
void QuantiseOneByOne(const FloatVertices& v, const QuantisedPlanes& planes, size_t begin,
                      size_t end) {
  const auto top = static_cast<float>((1 << v.position_bits) - 1);
  for (size_t i = begin; i < end; ++i) {
    const float* p = v.values + (kNormals ? 6 : 3) * i;
    for (size_t c = 0; c < 3; ++c) {
      const float grid = p[c] * v.scale[c] + v.offset[c];
      // Compares false with NaN.
      const float clamped = grid > 0.0f ? std::min(grid, top) : 0.0f;
      constexpr float kNoFraction = 0x1p23f;  // has no bits for one: addition rounds it away
      planes.position[c][i] = static_cast<uint16_t>((clamped + kNoFraction) - kNoFraction);
    }
    if constexpr (kNormals) StoreNormal<T>(v, planes, i);
  }
}

// Octahedral coordinates of the lanes. Returns which are not sure, as QuantiseSurely.
HWY_INLINE hn::Mask<DF> NormalLanes(VF x, VF y, VF z, int32_t top, VI& s, VI& t) {
  const DF df;
  const DI di;
  const int32_t centre_value = top / 2;
  const auto centre = static_cast<float>(centre_value);
  const VF half = hn::Set(df, 0.5f), zero = hn::Zero(df);
  const VF sum = hn::Add(hn::Add(hn::Abs(x), hn::Abs(y)), hn::Abs(z));
  const VF scale = hn::Div(hn::Set(df, centre), sum);
  const VF gx = hn::Add(hn::Mul(x, scale), half), gy = hn::Add(hn::Mul(y, scale), half);
  const VF fx = hn::Floor(gx), fy = hn::Floor(gy);
  const VF slack = hn::Set(df, centre * kSlack);
  const auto near = [&](VF grid, VF floor) HWY_ATTR {
    const VF part = hn::Sub(grid, floor);
    return hn::Or(hn::Lt(part, slack), hn::Gt(part, hn::Sub(hn::Set(df, 1.0f), slack)));
  };
  const auto usual =
      hn::And(hn::Gt(sum, hn::Set(df, kShortest)), hn::Lt(sum, hn::Set(df, kLongest)));
  const VI ix = hn::ConvertTo(di, hn::IfThenElseZero(usual, fx));
  VI iy = hn::ConvertTo(di, hn::IfThenElseZero(usual, fy));
  VI iz = hn::Sub(hn::Sub(hn::Set(di, centre_value), hn::Abs(ix)), hn::Abs(iy));
  // z takes the rounding errors of x and y; where it cannot, y does.
  const VI over = hn::Min(iz, hn::Zero(di));
  iy = hn::IfThenElse(hn::Gt(iy, hn::Zero(di)), hn::Add(iy, over), hn::Sub(iy, over));
  iz = hn::Max(iz, hn::Zero(di));
  iz = hn::IfThenElse(hn::RebindMask(di, hn::Lt(z, zero)), hn::Neg(iz), iz);

  // Behind the diamond: mirrored at its nearest side.
  const VI all = hn::Set(di, top), middle = hn::Set(di, centre_value);
  const VI ay = hn::Abs(iy), az = hn::Abs(iz);
  const auto back = hn::Lt(ix, hn::Zero(di));
  const VI back_s = hn::IfThenElse(hn::Lt(iy, hn::Zero(di)), az, hn::Sub(all, az));
  const VI back_t = hn::IfThenElse(hn::Lt(iz, hn::Zero(di)), ay, hn::Sub(all, ay));
  s = hn::IfThenElse(back, back_s, hn::Add(iy, middle));
  t = hn::IfThenElse(back, back_t, hn::Add(iz, middle));
  // The rim names directions twice: left to the definition.
  const auto rim = hn::And(back, hn::Eq(hn::Min(ay, az), hn::Zero(di)));
  return hn::Or(hn::Or(hn::Not(usual), hn::RebindMask(df, rim)),
                hn::Or(near(gx, fx), near(gy, fy)));
}

template <class T>
HWY_INLINE void StorePlane(VI values, uint8_t* plane, size_t i) {
  hn::StoreU(hn::DemoteTo(hn::Rebind<T, DI>(), values), hn::Rebind<T, DI>(),
             reinterpret_cast<T*>(plane) + i);
}

template <class T, bool kNormals>
void QuantiseVectors(const FloatVertices& v, const QuantisedPlanes& planes) {
  size_t i = 0;
#if HWY_TARGET != HWY_SCALAR
  const DF df;
  const DI di;
  const size_t lanes = hn::Lanes(df);
  const VF top = hn::Set(df, static_cast<float>((1 << v.position_bits) - 1));
  for (; i + lanes <= v.point_count; i += lanes) {
    VF p[3], n[3];
    if constexpr (kNormals) {  // positions and normals are triples by turns
      VF low[3], high[3];
      hn::LoadInterleaved3(df, v.values + 6 * i, low[0], low[1], low[2]);
      hn::LoadInterleaved3(df, v.values + 6 * i + 3 * lanes, high[0], high[1], high[2]);
      for (size_t c = 0; c < 3; ++c) {
        p[c] = hn::ConcatEven(df, high[c], low[c]);
        n[c] = hn::ConcatOdd(df, high[c], low[c]);
      }
    } else {
      hn::LoadInterleaved3(df, v.values + 3 * i, p[0], p[1], p[2]);
    }
    for (size_t c = 0; c < 3; ++c) {
      const VF grid = hn::Add(hn::Mul(p[c], hn::Set(df, v.scale[c])), hn::Set(df, v.offset[c]));
      const VF positive = hn::IfThenElseZero(hn::Gt(grid, hn::Zero(df)), grid);
      const VI integer = hn::NearestInt(hn::Min(positive, top));
      StorePlane<uint16_t>(integer, reinterpret_cast<uint8_t*>(planes.position[c]), i);
    }
    if constexpr (kNormals) {
      VI s, t;
      const auto unsure = NormalLanes(n[0], n[1], n[2], OctahedralMax(v.normal_bits), s, t);
      StorePlane<T>(s, planes.s, i);
      StorePlane<T>(t, planes.t, i);
      if (hn::AllFalse(df, unsure)) continue;
      HWY_ALIGN int32_t again[hn::MaxLanes(di)];
      hn::Store(hn::VecFromMask(di, hn::RebindMask(di, unsure)), di, again);
      for (size_t l = 0; l < lanes; ++l) {
        if (again[l] != 0) StoreNormal<T>(v, planes, i + l);
      }
    }
  }
#endif
  QuantiseOneByOne<T, kNormals>(v, planes, i, v.point_count);
}

void QuantiseImpl(const FloatVertices& v, const QuantisedPlanes& planes) {
  if (v.normal_bits == 0) return QuantiseVectors<uint8_t, false>(v, planes);
  if (v.normal_bits <= 8) return QuantiseVectors<uint8_t, true>(v, planes);
  QuantiseVectors<uint16_t, true>(v, planes);
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::quantise
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CODEC_QUANTISE_VERTICES_INL_H_
