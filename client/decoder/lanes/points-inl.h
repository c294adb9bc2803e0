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

#include <cstring>

#include "client/decoder/lanes/lane_kernel.h"
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
// inversion. The prediction of the next point is this one. Masks are all ones or 0.
struct NormalLanes {
  VI16 s, t;          // the prediction
  VI16 abs_s, abs_t;  // its distances from the axes
  VI16 inverted;      // mask
};

// All ones where `value` is negative.
HWY_INLINE VI16 IsNegative(VI16 value) { return hn::ShiftRight<15>(value); }
// -value under the mask.
HWY_INLINE VI16 NegateIf(VI16 mask, VI16 value) { return hn::Sub(hn::Xor(value, mask), mask); }

// Returns s and t of the true points, as they are sent.
//
// The prediction is turned to the lower left, to (-|s|, -|t|) or (-|t|, -|s|). There the symbols are added and wrapped, and
// the sum is turned back. Swapping the symbols instead leaves s and t in their places. A point on an axis counts as a
// little counter-clockwise of it.
HWY_INLINE void NextNormal(const uint16_t* rows, VI16 centre, NormalLanes& lanes, VU16& out_s,
                           VU16& out_t) {
  const DI16 d;
  const DU16 du;
  const VI16 ps = lanes.s, pt = lanes.t;
  const VI16 first = hn::BitCast(d, hn::LoadU(du, rows));
  const VI16 second = hn::BitCast(d, hn::LoadU(du, rows + kLanes));
  // Whether s > 0, t > 0.
  const VI16 negate_s = IsNegative(hn::Sub(IsNegative(pt), hn::Add(ps, ps)));
  const VI16 negate_t = IsNegative(hn::Sub(IsNegative(hn::Neg(ps)), hn::Add(pt, pt)));
  const VI16 swap = hn::And(hn::Xor(first, second), hn::Xor(negate_s, negate_t));
  const VI16 modulus = hn::Add(hn::Add(centre, centre), hn::Set(d, int16_t{1}));
  const auto corrected = [&](VI16 symbol, VI16 abs) {
    const VI16 sum = hn::Sub(symbol, abs);
    return hn::Sub(sum, hn::And(IsNegative(hn::Sub(centre, sum)), modulus));
  };
  const VI16 sum_s = corrected(hn::Xor(first, swap), lanes.abs_s);
  const VI16 sum_t = corrected(hn::Xor(second, swap), lanes.abs_t);
  const VI16 s = NegateIf(negate_s, sum_s), t = NegateIf(negate_t, sum_t);
  const VI16 abs_s = hn::Abs(sum_s), abs_t = hn::Abs(sum_t);
  // The inversion keeps the sides.
  const VI16 is_left = IsNegative(hn::Add(hn::Add(s, s), IsNegative(t)));
  const VI16 is_below = IsNegative(hn::Add(hn::Add(t, t), IsNegative(s)));
  const VI16 inverse_s = hn::Sub(centre, abs_t), inverse_t = hn::Sub(centre, abs_s);
  const VI16 beyond = hn::Sub(abs_s, inverse_s);
  const VI16 outside = IsNegative(hn::Neg(beyond));
  const auto sent = [&](VI16 side, VI16 abs, VI16 inverse) {
    const VI16 value = NegateIf(side, hn::IfVecThenElse(lanes.inverted, inverse, abs));
    return hn::BitCast(du, hn::Add(value, centre));
  };
  out_s = sent(is_left, abs_s, inverse_s);
  out_t = sent(is_below, abs_t, inverse_t);
  // The border is its own inversion, and not outside.
  lanes.inverted = hn::IfVecThenElse(lanes.inverted, IsNegative(beyond), outside);
  lanes.abs_s = hn::IfVecThenElse(outside, inverse_s, abs_s);
  lanes.abs_t = hn::IfVecThenElse(outside, inverse_t, abs_t);
  lanes.s = NegateIf(is_left, lanes.abs_s);
  lanes.t = NegateIf(is_below, lanes.abs_t);
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

HWY_INLINE void Put(const PointRow& row, size_t active, uint16_t* const* out, size_t begin) {
  for (size_t k = 0; k < active; ++k) {
    std::memcpy(out[k] + begin, &row.position[k], sizeof(row.position[k]));
    std::memcpy(out[k] + begin + 4, &row.normal[k], sizeof(row.normal[k]));
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
  NormalLanes normals{hn::Zero(di), hn::Zero(di), hn::Zero(di), hn::Zero(di),
                      hn::Set(di, int16_t{-1})};
  VU16 s = hn::Zero(d), t = hn::Zero(d);
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
        Put(row, kLanes, lanes.out, 6 * size_t{i});
      } else {
        Put(row, active, lanes.out, 6 * size_t{i});
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
