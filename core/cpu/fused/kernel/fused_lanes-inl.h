// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The vector types of all SIMD code of the fused pipeline: one patch, edge or corner per lane.
// Included once per instruction set by fused_kernel.cc.
#if defined(LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_LANES_INL_H_
#undef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_LANES_INL_H_
#else
#define LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_LANES_INL_H_
#endif

#include "core/base/host_device.h"
#include "core/cpu/fused/kernel/fused_kernel.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, kLanes>;
using V = hn::Vec<D>;

HWY_INLINE V Coefficient(const BoxPolynomial& box, int index, int component) {
  return hn::Set(D(), box.coefficient[static_cast<size_t>(index)][static_cast<size_t>(component)]);
}

HWY_INLINE void LoadPoint(const CornerLanes& corner, size_t lane, V* point) {
  for (size_t a = 0; a < 3; ++a) point[a] = hn::Load(D(), corner.point[a].data() + lane);
}

struct V3 {
  V x, y, z;
};
HWY_INLINE V3 CrossLanes(const V3& a, const V3& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
          hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}
HWY_INLINE V DotLanes(const V3& a, const V3& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}

// The hardware's estimate has 12 bits or more on x86, and 8 elsewhere. A Newton step doubles them; a float has 24.
constexpr int kNewtonSteps =
    HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128 ? 1 : 2;

HWY_INLINE V InverseSqrt(V x) {
  const D d;
  V estimate = hn::ApproximateReciprocalSqrt(x);
  for (int step = 0; step < kNewtonSteps; ++step) {
    const V half = hn::Mul(hn::Set(d, 0.5f), estimate);
    const V error = hn::NegMulAdd(hn::Mul(x, estimate), estimate, hn::Set(d, 1.0f));
    estimate = hn::MulAdd(half, error, estimate);
  }
  return estimate;
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_LANES_INL_H_
