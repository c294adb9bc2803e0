// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From rows of symbols to points, a chunk in each lane. core/codec/draco_symbols.h defines the symbols; this is their inverse.
// Included once per instruction set by lane_kernel.cc.
#if defined(LATTICED_CLIENT_DECODER_LANES_POINTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CLIENT_DECODER_LANES_POINTS_INL_H_
#undef LATTICED_CLIENT_DECODER_LANES_POINTS_INL_H_
#else
#define LATTICED_CLIENT_DECODER_LANES_POINTS_INL_H_
#endif

#include <algorithm>
#include <cstring>

#include "client/decoder/lanes/lane_kernel.h"
#include "core/codec/diamond-inl.h"
#include "core/codec/octahedral.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::decoder::lane_kernel {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using DU16 = hn::FixedTag<uint16_t, kLanes>;
using DI16 = hn::FixedTag<int16_t, kLanes>;
using VU16 = hn::Vec<DU16>;
using VI16 = hn::Vec<DI16>;

// One coordinate of all lanes, counted from the least value.
struct PositionLanes {
  VU16 value, low, high;
};

HWY_INLINE void NextPosition(const uint16_t* row, VU16 span, PositionLanes& lanes) {
  const DU16 d;
  const VU16 symbol = hn::LoadU(d, row);
  const VU16 negative = hn::Sub(hn::Zero(d), hn::And(symbol, hn::Set(d, uint16_t{1})));
  const VU16 sum = hn::Add(lanes.value, hn::Xor(hn::ShiftRight<1>(symbol), negative));
  // Of the sum, one span more and one span less, the one within the span is the smallest.
  lanes.value = hn::Min(sum, hn::Min(hn::Add(sum, span), hn::Sub(sum, span)));
  lanes.low = hn::Min(lanes.low, lanes.value);
  lanes.high = hn::Max(lanes.high, lanes.value);
}

// Normals of all lanes about the centre of the octahedral square: inside of the diamond, and whether the true point is its
// inversion. The prediction of the next point is this one.
struct NormalLanes {
  VI16 s, t;
  hn::Mask<DI16> inverted;
};

// Returns s and t of the true points, as they are sent.
HWY_INLINE void NextNormal(const uint16_t* rows, VI16 centre, NormalLanes& lanes, VU16& out_s,
                           VU16& out_t) {
  const DI16 d;
  const DU16 du;
  const VI16 zero = hn::Zero(d), ps = lanes.s, pt = lanes.t;
  // Where the prediction is turned to the lower left: by a half, from the right, from the left.
  const auto half = hn::AndNot(hn::Lt(pt, zero), hn::Gt(ps, zero));
  const auto right = hn::AndNot(hn::Lt(ps, zero), hn::Lt(pt, zero));
  const auto left = hn::AndNot(hn::Gt(ps, zero), hn::Gt(pt, zero));
  const auto quarter = hn::Or(right, left);
  const auto negate_s = hn::Or(half, left), negate_t = hn::Or(half, right);
  const VI16 swapped_s = hn::IfThenElse(quarter, pt, ps),
             swapped_t = hn::IfThenElse(quarter, ps, pt);
  VI16 a = hn::IfThenElse(negate_s, hn::Neg(swapped_s), swapped_s);
  VI16 b = hn::IfThenElse(negate_t, hn::Neg(swapped_t), swapped_t);
  a = hn::Add(a, hn::BitCast(d, hn::LoadU(du, rows)));
  b = hn::Add(b, hn::BitCast(d, hn::LoadU(du, rows + kLanes)));
  const VI16 modulus = hn::Add(hn::Add(centre, centre), hn::Set(d, int16_t{1}));
  a = hn::Sub(a, hn::IfThenElseZero(hn::Gt(a, centre), modulus));
  b = hn::Sub(b, hn::IfThenElseZero(hn::Gt(b, centre), modulus));
  // Turned back.
  a = hn::IfThenElse(negate_s, hn::Neg(a), a);
  b = hn::IfThenElse(negate_t, hn::Neg(b), b);
  const VI16 s = hn::IfThenElse(quarter, b, a), t = hn::IfThenElse(quarter, a, b);
  VI16 inverse_s, inverse_t;
  latticed::HWY_NAMESPACE::InvertDiamondLanes(d, centre, s, t, inverse_s, inverse_t);
  out_s = hn::BitCast(du, hn::Add(hn::IfThenElse(lanes.inverted, inverse_s, s), centre));
  out_t = hn::BitCast(du, hn::Add(hn::IfThenElse(lanes.inverted, inverse_t, t), centre));
  const VI16 distance = hn::Add(hn::Abs(s), hn::Abs(t));
  const auto outside = hn::Gt(distance, centre), inside = hn::Lt(distance, centre);
  lanes.s = hn::IfThenElse(outside, inverse_s, s);
  lanes.t = hn::IfThenElse(outside, inverse_t, t);
  // The border is its own inversion, and not outside.
  lanes.inverted = hn::Or(hn::And(lanes.inverted, inside), hn::AndNot(lanes.inverted, outside));
}

// The numbers of one point of each lane, x y z 0 and s t.
struct alignas(16) PointRow {
  uint64_t position[kLanes];
  uint32_t normal[kLanes];
};

HWY_INLINE void Interleave(VU16 x, VU16 y, VU16 z, VU16 s, VU16 t, PointRow& row) {
  const DU16 d;
  const hn::FixedTag<uint32_t, 4> d32;
  const hn::FixedTag<uint64_t, 2> d64;
  const VU16 zero = hn::Zero(d);
  const auto xy_lower = hn::BitCast(d32, hn::InterleaveLower(d, x, y));
  const auto xy_upper = hn::BitCast(d32, hn::InterleaveUpper(d, x, y));
  const auto z0_lower = hn::BitCast(d32, hn::InterleaveLower(d, z, zero));
  const auto z0_upper = hn::BitCast(d32, hn::InterleaveUpper(d, z, zero));
  hn::Store(hn::BitCast(d64, hn::InterleaveLower(d32, xy_lower, z0_lower)), d64, row.position);
  hn::Store(hn::BitCast(d64, hn::InterleaveUpper(d32, xy_lower, z0_lower)), d64, row.position + 2);
  hn::Store(hn::BitCast(d64, hn::InterleaveLower(d32, xy_upper, z0_upper)), d64, row.position + 4);
  hn::Store(hn::BitCast(d64, hn::InterleaveUpper(d32, xy_upper, z0_upper)), d64, row.position + 6);
  hn::Store(hn::BitCast(d32, hn::InterleaveLower(d, s, t)), d32, row.normal);
  hn::Store(hn::BitCast(d32, hn::InterleaveUpper(d, s, t)), d32, row.normal + 4);
}

HWY_INLINE void Put(const PointRow& row, size_t active, uint16_t** out) {
  for (size_t k = 0; k < active; ++k) {
    std::memcpy(out[k], &row.position[k], sizeof(row.position[k]));
    std::memcpy(out[k] + 4, &row.normal[k], sizeof(row.normal[k]));
    out[k] += 6;
  }
}

template <bool kNormals>
void WriteRows(PointLanes& lanes) {
  const DU16 d;
  const DI16 di;
  const VU16 least = hn::LoadU(d, lanes.least), span = hn::LoadU(d, lanes.span);
  PositionLanes axes[3];
  for (PositionLanes& axis : axes) axis = {hn::Zero(d), hn::Set(d, uint16_t{0xFFFF}), hn::Zero(d)};
  const VI16 centre = hn::Set(di, static_cast<int16_t>(OctahedralMax(lanes.normal_bits) / 2));
  // The first prediction is the corner of the square, whose inversion is the centre.
  NormalLanes normals{hn::Zero(di), hn::Zero(di), hn::Eq(centre, centre)};
  VU16 s = hn::Zero(d), t = hn::Zero(d);
  uint16_t* out[kLanes];
  std::copy(lanes.out, lanes.out + kLanes, out);
  const uint16_t* positions = lanes.position_rows;
  const uint16_t* normal_rows = lanes.normal_rows;
  PointRow row;
  uint32_t i = 0;
  for (size_t active = kLanes; active > 0; --active) {
    for (const uint32_t end = lanes.points[active - 1]; i < end; ++i) {
      for (size_t c = 0; c < 3; ++c) NextPosition(positions + c * kLanes, span, axes[c]);
      positions += 3 * kLanes;
      if constexpr (kNormals) {
        NextNormal(normal_rows, centre, normals, s, t);
        normal_rows += 2 * kLanes;
      }
      Interleave(hn::Add(axes[0].value, least), hn::Add(axes[1].value, least),
                 hn::Add(axes[2].value, least), s, t, row);
      if (active == kLanes) {
        Put(row, kLanes, out);
      } else {
        Put(row, active, out);
      }
    }
    // Later rows of this lane have nothing to say.
    HWY_ALIGN uint16_t low[kLanes], high[kLanes];
    for (size_t c = 0; c < 3; ++c) {
      hn::Store(hn::Add(axes[c].low, least), d, low);
      hn::Store(hn::Add(axes[c].high, least), d, high);
      lanes.low[c][active - 1] = low[active - 1];
      lanes.high[c][active - 1] = high[active - 1];
    }
  }
}

void WritePointsImpl(PointLanes& lanes) {
  if (lanes.normal_rows != nullptr) {
    WriteRows<true>(lanes);
  } else {
    WriteRows<false>(lanes);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::decoder::lane_kernel
HWY_AFTER_NAMESPACE();

#endif
