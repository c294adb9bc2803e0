// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The symbols of draco_symbols.h, many points at a time in lanes of 16 bits: all values of normals
// are below 2^12, and those of positions are right modulo 2^16.
// Included once per instruction set by draco_kernel.cc.
#if defined(LATTICED_CORE_CODEC_DRACO_SYMBOLS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CODEC_DRACO_SYMBOLS_INL_H_
#undef LATTICED_CORE_CODEC_DRACO_SYMBOLS_INL_H_
#else
#define LATTICED_CORE_CODEC_DRACO_SYMBOLS_INL_H_
#endif

#include <algorithm>
#include <cstring>

#include "core/codec/diamond-inl.h"
#include "core/codec/draco_kernel.h"
#include "core/codec/draco_symbols.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::draco_kernel {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using DU16 = hn::ScalableTag<uint16_t>;
using DI16 = hn::RebindToSigned<DU16>;
using VU16 = hn::Vec<DU16>;
using VI16 = hn::Vec<DI16>;
// Without vectors the scalar definitions are faster: selects for a single lane cost more than branches.
constexpr bool kVectors = hn::MaxLanes(DU16()) > 1;

ValueSpan SpanOfImpl(const uint16_t* values, size_t count) {
  const DU16 d;
  const size_t lanes = hn::Lanes(d);
  ValueSpan span{0xFFFF, 0};
  size_t i = 0;
  if (count >= lanes) {
    VU16 least = hn::LoadU(d, values), most = least;
    for (i = lanes; i + lanes <= count; i += lanes) {
      const VU16 v = hn::LoadU(d, values + i);
      least = hn::Min(least, v);
      most = hn::Max(most, v);
    }
    HWY_ALIGN uint16_t both[2][hn::MaxLanes(d)];
    hn::Store(least, d, both[0]);
    hn::Store(most, d, both[1]);
    span = {*std::min_element(both[0], both[0] + lanes),
            *std::max_element(both[1], both[1] + lanes)};
  }
  for (; i < count; ++i) {
    span = {std::min(span.least, values[i]), std::max(span.most, values[i])};
  }
  return span;
}

void PositionSymbolsImpl(const uint16_t* values, size_t count, ValueSpan span, uint16_t* symbols) {
  const DU16 d;
  const uint32_t wrap = uint32_t{span.most} - span.least + 1;
  symbols[0] = static_cast<uint16_t>(PositionSymbol(values[0], span.least, wrap));
  const VU16 all = hn::Set(d, static_cast<uint16_t>(wrap)), one = hn::Set(d, uint16_t{1});
  const VU16 most_fall = hn::Set(d, static_cast<uint16_t>(wrap / 2));
  const VU16 most_rise = hn::Set(d, static_cast<uint16_t>((wrap - 1) / 2));
  size_t i = 1;
  for (; kVectors && i + hn::Lanes(d) <= count; i += hn::Lanes(d)) {
    const VU16 value = hn::LoadU(d, values + i), previous = hn::LoadU(d, values + i - 1);
    const VU16 rise = hn::SaturatedSub(value, previous), fall = hn::SaturatedSub(previous, value);
    const VU16 distance = hn::Or(rise, fall);
    const auto falls = hn::Lt(value, previous);
    const auto wraps = hn::Gt(distance, hn::IfThenElse(falls, most_fall, most_rise));
    const VU16 shortest = hn::IfThenElse(wraps, hn::Sub(all, distance), distance);
    const VU16 symbol =
        hn::Sub(hn::Add(shortest, shortest), hn::IfThenElseZero(hn::Xor(falls, wraps), one));
    hn::StoreU(symbol, d, symbols + i);
  }
  for (; i < count; ++i) {
    symbols[i] = static_cast<uint16_t>(PositionSymbol(values[i], values[i - 1], wrap));
  }
}

// Values of a plane about the centre of the octahedral square; T: how they are stored.
template <class T>
HWY_INLINE VI16 LoadCentred(const uint8_t* plane, size_t point, VU16 top, VI16 centre) {
  const DU16 d;
  VU16 value;
  if constexpr (sizeof(T) == 1) {
    value = hn::PromoteTo(d, hn::LoadU(hn::Rebind<uint8_t, DU16>(), plane + point));
  } else {
    value = hn::LoadU(d, reinterpret_cast<const uint16_t*>(plane) + point);
  }
  return hn::Sub(hn::BitCast(DI16(), hn::Min(value, top)), centre);
}

// InvertDiamond in the lanes of `outside`.
HWY_INLINE void InvertWhere(hn::Mask<DI16> outside, VI16 centre, VI16& s, VI16& t) {
  VI16 inverse_s, inverse_t;
  latticed::HWY_NAMESPACE::InvertDiamondLanes(DI16(), centre, s, t, inverse_s, inverse_t);
  s = hn::IfThenElse(outside, inverse_s, s);
  t = hn::IfThenElse(outside, inverse_t, t);
}

// NormalSymbols for values about the centre.
HWY_INLINE void NormalSymbolLanes(VI16 s, VI16 t, VI16 ps, VI16 pt, VI16 centre, VI16& s_symbol,
                                  VI16& t_symbol) {
  const DI16 d;
  const VI16 zero = hn::Zero(d);
  const auto outside = hn::Gt(hn::Add(hn::Abs(ps), hn::Abs(pt)), centre);
  // Neighbours are in the same hemisphere most of the time.
  if (!hn::AllFalse(d, outside)) {
    InvertWhere(outside, centre, s, t);
    InvertWhere(outside, centre, ps, pt);
  }
  const VI16 ds = hn::Sub(s, ps), dt = hn::Sub(t, pt);
  const auto half = hn::AndNot(hn::Lt(pt, zero), hn::Gt(ps, zero));
  const auto right = hn::AndNot(hn::Lt(ps, zero), hn::Lt(pt, zero));
  const auto left = hn::AndNot(hn::Gt(ps, zero), hn::Gt(pt, zero));
  const auto quarter = hn::Or(right, left);
  const auto negate_s = hn::Or(half, left), negate_t = hn::Or(half, right);
  const VI16 turned_s = hn::IfThenElse(quarter, dt, ds), turned_t = hn::IfThenElse(quarter, ds, dt);
  const VI16 modulus = hn::Add(hn::Add(centre, centre), hn::Set(d, int16_t{1}));
  s_symbol = hn::IfThenElse(negate_s, hn::Neg(turned_s), turned_s);
  t_symbol = hn::IfThenElse(negate_t, hn::Neg(turned_t), turned_t);
  s_symbol = hn::Add(s_symbol, hn::IfThenElseZero(hn::Lt(s_symbol, zero), modulus));
  t_symbol = hn::Add(t_symbol, hn::IfThenElseZero(hn::Lt(t_symbol, zero), modulus));
}

template <class T>
OctahedralNormal LoadNormal(const uint8_t* s, const uint8_t* t, size_t point, int32_t top) {
  T pair[2];
  std::memcpy(&pair[0], s + sizeof(T) * point, sizeof(T));
  std::memcpy(&pair[1], t + sizeof(T) * point, sizeof(T));
  return {std::min(int32_t{pair[0]}, top), std::min(int32_t{pair[1]}, top)};
}

template <class T>
void NormalSymbolsOf(const uint8_t* s, const uint8_t* t, size_t count, int bits,
                     uint16_t* s_symbols, uint16_t* t_symbols) {
  const DI16 d;
  const DU16 du;
  const int32_t top_value = OctahedralMax(bits);
  const VU16 top = hn::Set(du, static_cast<uint16_t>(top_value));
  const VI16 centre = hn::Set(d, static_cast<int16_t>(top_value / 2));
  const auto one_by_one = [&](size_t begin, size_t end) HWY_ATTR {
    OctahedralNormal previous =
        begin == 0 ? OctahedralNormal{} : LoadNormal<T>(s, t, begin - 1, top_value);
    for (size_t i = begin; i < end; ++i) {
      const OctahedralNormal value = LoadNormal<T>(s, t, i, top_value);
      const OctahedralNormal n = ::latticed::NormalSymbols(value, previous, bits);
      previous = value;
      s_symbols[i] = static_cast<uint16_t>(n.s);
      t_symbols[i] = static_cast<uint16_t>(n.t);
    }
  };
  one_by_one(0, 1);
  size_t i = 1;
  for (; kVectors && i + hn::Lanes(d) <= count; i += hn::Lanes(d)) {
    VI16 s_symbol, t_symbol;
    NormalSymbolLanes(LoadCentred<T>(s, i, top, centre), LoadCentred<T>(t, i, top, centre),
                      LoadCentred<T>(s, i - 1, top, centre), LoadCentred<T>(t, i - 1, top, centre),
                      centre, s_symbol, t_symbol);
    hn::StoreU(hn::BitCast(du, s_symbol), du, s_symbols + i);
    hn::StoreU(hn::BitCast(du, t_symbol), du, t_symbols + i);
  }
  one_by_one(i, count);
}

void NormalSymbolsImpl(const uint8_t* s, const uint8_t* t, size_t count, int bits,
                       uint16_t* s_symbols, uint16_t* t_symbols) {
  if (bits <= 8) return NormalSymbolsOf<uint8_t>(s, t, count, bits, s_symbols, t_symbols);
  NormalSymbolsOf<uint16_t>(s, t, count, bits, s_symbols, t_symbols);
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::draco_kernel
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CODEC_DRACO_SYMBOLS_INL_H_
