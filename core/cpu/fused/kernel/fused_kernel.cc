// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compiled once per instruction set (AVX-512, AVX2, and the compiler's baseline); Highway picks one at run time.
// The build sets -ffp-contract=off for this file, so that only MulAdd makes fused multiply-adds. Otherwise the two
// sides of an edge, which are inlined into different functions, could be rounded differently.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/cpu/fused/kernel/fused_kernel.cc"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Highway requires this include to follow foreach_target.
#include "core/cpu/fused/kernel/fused_degrees-inl.h"
#include "core/cpu/fused/kernel/fused_direct-inl.h"
#include "core/cpu/fused/kernel/fused_group-inl.h"
#include "core/cpu/fused/kernel/fused_kernel.h"
#include "core/cpu/fused/kernel/fused_store-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

template <int D0, int D1, int D2>
struct Instance {
  static void Group(GroupArguments& arguments) {
    for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(D())) {
      if (!arguments.normals) {
        GroupAt<false, false>(arguments, lane);
      } else if (arguments.smooth == nullptr) {
        GroupAt<true, false>(arguments, lane);
      } else {
        GroupAt<true, true>(arguments, lane);
      }
    }
  }

  template <bool kNormals, bool kSmooth>
  static void GroupAt(GroupArguments& arguments, size_t lane) {
    if (arguments.segments <= kMostDirectSegments) {
      DirectGroupKernel<D0, D1, D2, kNormals, kSmooth>(arguments, lane).Run();
    } else {
      GroupKernel<D0, D1, D2, kNormals, kSmooth>(arguments, lane).Run();
    }
  }

  static void Edges(const BoxPolynomial& box, const EdgeLanes& edges, int segments, float* out) {
    for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(D())) {
      V from[3], to[3];
      LoadPoint(edges.from, lane, from);
      LoadPoint(edges.to, lane, to);
      const EdgeLine line(from, to);
      const auto store = [&](size_t k, size_t c, V value) HWY_ATTR {
        hn::Store(value, D(), out + ((k - 1) * 3 + c) * kLanes + lane);
      };
      if (segments <= kMostDirectSegments) {
        DirectEdgePoints<D0, D1, D2>(box, line, segments, store);
      } else {
        ComposedEdgePoints<D0, D1, D2>(box, line, segments, store);
      }
    }
  }

  static void Corners(const BoxPolynomial& box, const CornerLanes& corners, float* out) {
    for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(D())) {
      V point[3], value;
      LoadPoint(corners, lane, point);
      for (size_t c = 0; c < 3; ++c) {
        EvaluatePoint<D0, D1, D2, false>(box, point, static_cast<int>(c), &value);
        hn::Store(value, D(), out + c * kLanes + lane);
      }
    }
  }
};

void EvaluateGroupImpl(GroupArguments& arguments) {
  WithDegrees<Instance>(arguments.degree, [&](auto instance) { instance.Group(arguments); });
}
void EvaluateEdgesImpl(const std::array<int, 3>& degree, const BoxPolynomial& box,
                       const EdgeLanes& edges, int segments, float* out) {
  WithDegrees<Instance>(degree, [&](auto instance) { instance.Edges(box, edges, segments, out); });
}
void EvaluateCornersImpl(const std::array<int, 3>& degree, const BoxPolynomial& box,
                         const CornerLanes& corners, float* out) {
  WithDegrees<Instance>(degree, [&](auto instance) { instance.Corners(box, corners, out); });
}
const char* TargetNameImpl() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace latticed::fused {

HWY_EXPORT(EvaluateGroupImpl);
HWY_EXPORT(EvaluateEdgesImpl);
HWY_EXPORT(EvaluateCornersImpl);
HWY_EXPORT(StoreQuantisedImpl);
HWY_EXPORT(StoreFloatsImpl);
HWY_EXPORT(StoreLaneOrderImpl);
HWY_EXPORT(TargetNameImpl);

void EvaluateGroup(GroupArguments& arguments) {
  HWY_DYNAMIC_DISPATCH(EvaluateGroupImpl)(arguments);
}
void EvaluateEdges(const std::array<int, 3>& degree, const BoxPolynomial& box,
                   const EdgeLanes& edges, int segments, float* out) {
  HWY_DYNAMIC_DISPATCH(EvaluateEdgesImpl)(degree, box, edges, segments, out);
}
void EvaluateCorners(const std::array<int, 3>& degree, const BoxPolynomial& box,
                     const CornerLanes& corners, float* out) {
  HWY_DYNAMIC_DISPATCH(EvaluateCornersImpl)(degree, box, corners, out);
}
void StoreQuantised(const QuantiseArguments& arguments) {
  HWY_DYNAMIC_DISPATCH(StoreQuantisedImpl)(arguments);
}
void StoreFloats(const GroupScratch& scratch, size_t components, size_t lanes,
                 const std::array<float*, kLanes>& destination) {
  HWY_DYNAMIC_DISPATCH(StoreFloatsImpl)(scratch, components, lanes, destination);
}
void StoreLaneOrder(const GroupScratch& scratch, size_t components, float* destination) {
  HWY_DYNAMIC_DISPATCH(StoreLaneOrderImpl)(scratch, components, destination);
}
const char* TargetName() { return HWY_DYNAMIC_DISPATCH(TargetNameImpl)(); }

}  // namespace latticed::fused
#endif  // HWY_ONCE
