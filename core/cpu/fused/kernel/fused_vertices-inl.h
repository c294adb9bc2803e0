// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Stores the points of a group, and finds the normals that are left to the definition.
// Included once per instruction set by fused_kernel.cc.
#if defined(LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_VERTICES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_VERTICES_INL_H_
#undef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_VERTICES_INL_H_
#else
#define LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_VERTICES_INL_H_
#endif

#include "core/cpu/fused/kernel/fused_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

// Normals shorter than this fraction of the box's bound are computed by the definition, in double;
// direct_ffd.h has the same 1e4 as the largest condition of a normal. A normal is longer than the bound
// only when something overflowed.
constexpr float kWeakNormal = 1e-4f, kTooLong = 4;

class GroupVertices {
 public:
  // `scale`: how many times as long as cof(J) N the normals will be.
  GroupVertices(GroupArguments& arguments, size_t lane, V scale) : args_(arguments), lane_(lane) {
    // Two divisions, because the product of the divisors may overflow.
    to_bound_ = hn::Div(hn::Set(D(), 1.0f / args_.box->cofactor_bound), scale);
  }
  // The same, where lanes have bounds of their own.
  GroupVertices(GroupArguments& arguments, size_t lane, V scale, V cofactor_bound)
      : args_(arguments), lane_(lane) {
    to_bound_ = hn::Div(hn::Div(hn::Set(D(), 1.0f), cofactor_bound), scale);
  }

  HWY_INLINE void Store(size_t component, size_t point, V value) const {
    hn::Store(value, D(), args_.scratch.Row(component, point) + lane_);
  }

  HWY_INLINE void StoreNormal(const V3& carried, size_t point) {
    // Scaled to a fraction of the bound, so that the square does not overflow in any units of the mesh.
    const V3 normal{hn::Mul(carried.x, to_bound_), hn::Mul(carried.y, to_bound_),
                    hn::Mul(carried.z, to_bound_)};
    const V length2 = DotLanes(normal, normal);
    const V scale = InverseSqrt(length2);
    Store(3, point, hn::Mul(normal.x, scale));
    Store(4, point, hn::Mul(normal.y, scale));
    Store(5, point, hn::Mul(normal.z, scale));
    // Written so that NaN counts as weak too.
    const auto strong = hn::And(hn::Gt(length2, hn::Set(D(), kWeakNormal * kWeakNormal)),
                                hn::Lt(length2, hn::Set(D(), kTooLong * kTooLong)));
    if (HWY_UNLIKELY(!hn::AllTrue(D(), strong))) NoteWeak(hn::Not(strong), point);
  }

 private:
  template <class M>
  HWY_NOINLINE void NoteWeak(M weak, size_t point) {
    HWY_ALIGN float flags[kLanes];
    hn::Store(hn::IfThenElseZero(weak, hn::Set(D(), 1.0f)), D(), flags);
    for (size_t i = 0; i < hn::Lanes(D()); ++i) {
      if (flags[i] == 0) continue;
      args_.weak[args_.weak_count++] = {static_cast<uint16_t>(point),
                                        static_cast<uint16_t>(lane_ + i)};
    }
  }

  GroupArguments& args_;
  const size_t lane_;
  V to_bound_;
};

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_VERTICES_INL_H_
