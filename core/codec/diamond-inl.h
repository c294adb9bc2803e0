// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// InvertDiamond of draco_symbols.h in the lanes of a vector, for the encoder and the decoder.
// Included once per instruction set.
#if defined(LATTICED_CORE_CODEC_DIAMOND_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CODEC_DIAMOND_INL_H_
#undef LATTICED_CORE_CODEC_DIAMOND_INL_H_
#else
#define LATTICED_CORE_CODEC_DIAMOND_INL_H_
#endif

#include <cstdint>

#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed {
namespace HWY_NAMESPACE {

// D: lanes of int16_t.
template <class D, class V>
HWY_INLINE void InvertDiamondLanes(D d, V centre, V s, V t, V& inverse_s, V& inverse_t) {
  namespace hn = hwy::HWY_NAMESPACE;
  const V zero = hn::Zero(d);
  const auto right = hn::Or(hn::Gt(s, zero), hn::AndNot(hn::Lt(t, zero), hn::Eq(s, zero)));
  const auto upper = hn::Or(hn::Gt(t, zero), hn::AndNot(hn::Lt(s, zero), hn::Eq(t, zero)));
  const auto opposite = hn::Xor(right, upper);
  const V turned_s = hn::IfThenElse(opposite, t, hn::Neg(t));
  const V turned_t = hn::IfThenElse(opposite, s, hn::Neg(s));
  inverse_s = hn::Add(hn::IfThenElse(right, centre, hn::Neg(centre)), turned_s);
  inverse_t = hn::Add(hn::IfThenElse(upper, centre, hn::Neg(centre)), turned_t);
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed
HWY_AFTER_NAMESPACE();

#endif
