// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bounds of the second derivatives of 16 patches: composes the polynomial of their box with their affine maps, and takes
// the largest Bernstein coefficients. Included once per instruction set by adaptive_kernel.cc.
#if defined(LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_BOUNDS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_BOUNDS_INL_H_
#undef LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_BOUNDS_INL_H_
#else
#define LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_BOUNDS_INL_H_
#endif

#include "core/adaptive/curvature_slack.h"
#include "core/cpu/adaptive/kernel/adaptive_kernel.h"
#include "core/cpu/fused/kernel/fused_polynomial-inl.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

#include "core/adaptive/patch_curvature-inl.h"

struct LaneOps {
  using V = hn::Vec<D>;
  static HWY_INLINE V Set(double value) { return hn::Set(D(), static_cast<float>(value)); }
  static HWY_INLINE V Add(V a, V b) { return hn::Add(a, b); }
  static HWY_INLINE V Sub(V a, V b) { return hn::Sub(a, b); }
  static HWY_INLINE V Mul(V a, V b) { return hn::Mul(a, b); }
  static HWY_INLINE V MulAdd(V a, V b, V c) { return hn::MulAdd(a, b, c); }
  static HWY_INLINE V Max(V a, V b) { return hn::Max(a, b); }
};

template <int D0, int D1, int D2>
class BoundKernel {
  static constexpr int kDegree = D0 + D1 + D2;

 public:
  static HWY_INLINE void Run(const BoundArguments& args, size_t lane) {
    const auto load = [&](const Lanes& lanes)
                          HWY_ATTR { return hn::Load(D(), lanes.data() + lane); };
    const PatchLanes& patches = *args.patches;
    AffineMap map;
    V reach[3];
    for (size_t a = 0; a < 3; ++a) {
      map.l[a][0] = load(patches.center[a]);
      map.l[a][1] = load(patches.along[a]);
      map.l[a][2] = load(patches.across[a]);
      const V along = hn::Abs(map.l[a][1]);
      reach[a] = hn::Add(hn::Add(along, along), hn::Abs(map.l[a][2]));
    }
    Powers<D2>(map);
    V composed[3][Terms(kDegree)];
    for (int c = 0; c < 3; ++c) {
      Compose<D0, D1, D2, 0, false>(*args.box, map, c, composed[c], nullptr);
    }
    const V* const p[3] = {composed[0], composed[1], composed[2]};
    V squared[6];
    PatchCurvature<kDegree, LaneOps>::SquaredBounds(p, load(patches.shear), squared, squared + 3);
    // 0, or not a number where a coefficient is none or infinite. Max would lose it.
    V check = hn::Zero(D());
    for (const auto& component : composed) {
      for (const V& coefficient : component) {
        check = hn::MulAdd(coefficient, hn::Zero(D()), check);
      }
    }
    const V slack = hn::Add(Slack(args.slack, reach), check);
    for (size_t k = 0; k < 6; ++k) {
      const V bound = hn::Mul(hn::Set(D(), static_cast<float>(kBoundFactor)),
                              hn::Add(hn::Sqrt(squared[k]), slack));
      hn::Store(bound, D(), (*args.bounds)[k].data() + lane);
    }
  }

 private:
  // PatchSlack of core/adaptive/curvature_slack.h.
  static HWY_INLINE V Slack(const std::array<float, 6>& slack, const V* v) {
    V sum = hn::Zero(D());
    for (size_t a = 0; a < 3; ++a) {
      const V row = hn::MulAdd(v[a], hn::Set(D(), slack[a]),
                               hn::Mul(v[(a + 1) % 3], hn::Set(D(), slack[3 + a])));
      sum = hn::MulAdd(v[a], row, sum);
    }
    return sum;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_BOUNDS_INL_H_
