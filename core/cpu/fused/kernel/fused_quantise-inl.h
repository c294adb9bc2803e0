// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Rounds positions and normals to the integers of a view, one point per lane.
// Included once per instruction set by each kernel that stores vertices.
#if defined(LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_QUANTISE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_QUANTISE_INL_H_
#undef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_QUANTISE_INL_H_
#else
#define LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_QUANTISE_INL_H_
#endif

#include "core/cpu/fused/kernel/fused_kernel.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using DF = hn::CappedTag<float, kLanes>;
using DI = hn::RebindToSigned<DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;

HWY_INLINE VI QuantisePosition(VF p, VF scale, VF offset, VI top) {
  const VI integer = hn::NearestInt(hn::MulAdd(p, scale, offset));
  return hn::Min(hn::Max(integer, hn::Zero(DI())), top);
}

// Folds the lanes of the lower half outwards over the sides of the diamond. Only these directions can lie
// on the rim of the square, where each has two pairs of coordinates: it chooses the same pair as
// CanonicaliseOctahedral.
HWY_INLINE void FoldBack(hn::Mask<DI> back, VI i1, VI i2, VI centre, VI top, VI& s, VI& t) {
  const DI di;
  const VI zero = hn::Zero(di);
  const VI a1 = hn::Abs(i1), a2 = hn::Abs(i2);
  const VI back_s = hn::IfThenElse(hn::Lt(i1, zero), a2, hn::Sub(top, a2));
  const VI back_t = hn::IfThenElse(hn::Lt(i2, zero), a1, hn::Sub(top, a1));
  s = hn::IfThenElse(back, back_s, s);
  t = hn::IfThenElse(back, back_t, t);
  if (hn::AllFalse(di, hn::And(back, hn::Eq(hn::Min(a1, a2), zero)))) return;
  const auto s0 = hn::Eq(s, zero), t0 = hn::Eq(t, zero), s1 = hn::Eq(s, top), t1 = hn::Eq(t, top);
  const auto corner = hn::Or(hn::And(s0, hn::Or(t0, t1)), hn::And(s1, t0));
  const VI mirror_s = hn::Sub(top, s), mirror_t = hn::Sub(top, t);
  const auto flip_t = hn::Or(hn::And(s0, hn::Gt(t, centre)), hn::And(s1, hn::Lt(t, centre)));
  const auto flip_s =
      hn::AndNot(flip_t, hn::Or(hn::And(t1, hn::Lt(s, centre)), hn::And(t0, hn::Gt(s, centre))));
  s = hn::IfThenElse(corner, top, hn::IfThenElse(flip_s, mirror_s, s));
  t = hn::IfThenElse(corner, top, hn::IfThenElse(flip_t, mirror_t, t));
}

// Draco's octahedral map (core/codec/octahedral.h), 16 lanes at a time.
HWY_INLINE void QuantiseNormalLanes(VF x, VF y, VF z, int bits, VI& s, VI& t) {
  const DF df;
  const DI di;
  const int top_value = (1 << bits) - 2;
  const int32_t centre_value = top_value / 2;
  const VI centre = hn::Set(di, centre_value), top = hn::Set(di, top_value);
  const VI zero = hn::Zero(di);
  const VF sum = hn::Add(hn::Add(hn::Abs(x), hn::Abs(y)), hn::Abs(z));
  const VF scale = hn::Div(hn::Set(df, static_cast<float>(centre_value)), sum);
  const VF half = hn::Set(df, 0.5f);
  VI i0 = hn::ConvertTo(di, hn::Floor(hn::MulAdd(x, scale, half)));
  VI i1 = hn::ConvertTo(di, hn::Floor(hn::MulAdd(y, scale, half)));
  VI i2 = hn::Sub(hn::Sub(centre, hn::Abs(i0)), hn::Abs(i1));
  // When both were rounded up the sum can exceed the diamond: subtract the excess from i1.
  const VI over = hn::Min(i2, zero);
  i1 = hn::IfThenElse(hn::Gt(i1, zero), hn::Add(i1, over), hn::Sub(i1, over));
  i2 = hn::Max(i2, zero);
  i2 = hn::IfThenElse(hn::RebindMask(di, hn::Lt(z, hn::Zero(df))), hn::Neg(i2), i2);
  s = hn::Add(i1, centre);
  t = hn::Add(i2, centre);
  // The patches of a group are neighbours, so nearly always none of their normals is folded.
  const auto back = hn::Lt(i0, zero);
  if (!hn::AllFalse(di, back)) FoldBack(back, i1, i2, centre, top, s, t);
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_QUANTISE_INL_H_
