// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Vectors in space, one in each lane, for the kernels that work on blocks of points (point_kernel.h).
// Included once per instruction set by each kernel.
#if defined(LATTICED_CORE_POINTS_LANE_VECTORS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_POINTS_LANE_VECTORS_INL_H_
#undef LATTICED_CORE_POINTS_LANE_VECTORS_INL_H_
#else
#define LATTICED_CORE_POINTS_LANE_VECTORS_INL_H_
#endif

#include "core/points/point_kernel.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::points {
namespace HWY_NAMESPACE {
namespace lanes {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;

struct V3 {
  V x, y, z;
};

HWY_INLINE V3 Zero3() { return {hn::Zero(D()), hn::Zero(D()), hn::Zero(D())}; }
HWY_INLINE V3 Set3(double x, double y, double z) {
  return {hn::Set(D(), x), hn::Set(D(), y), hn::Set(D(), z)};
}
HWY_INLINE V3 Load3(const BlockVec& from, size_t i) {
  const D d;
  return {hn::LoadU(d, from[0].data() + i), hn::LoadU(d, from[1].data() + i),
          hn::LoadU(d, from[2].data() + i)};
}
HWY_INLINE void Store3(const V3& v, BlockVec& to, size_t i) {
  const D d;
  hn::StoreU(v.x, d, to[0].data() + i);
  hn::StoreU(v.y, d, to[1].data() + i);
  hn::StoreU(v.z, d, to[2].data() + i);
}
HWY_INLINE V Dot(const V3& a, const V3& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE V3 Cross(const V3& a, const V3& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
          hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}
HWY_INLINE V3 Sum(const V3& a, const V3& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE V3 Difference(const V3& a, const V3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE V3 Times(V s, const V3& a) {
  return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)};
}
// s a + b
HWY_INLINE V3 AddTimes(V s, const V3& a, const V3& b) {
  return {hn::MulAdd(s, a.x, b.x), hn::MulAdd(s, a.y, b.y), hn::MulAdd(s, a.z, b.z)};
}

}  // namespace lanes
}  // namespace HWY_NAMESPACE
}  // namespace latticed::points
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_POINTS_LANE_VECTORS_INL_H_
