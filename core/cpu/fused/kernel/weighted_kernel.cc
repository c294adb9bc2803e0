// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The kernels of meshes with weights. They are apart from fused_kernel.cc, whose comments on compilation hold here too.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/cpu/fused/kernel/weighted_kernel.cc"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Highway requires this include to follow foreach_target.
#include "core/cpu/fused/kernel/fused_degrees-inl.h"
#include "core/cpu/fused/kernel/fused_direct-inl.h"
#include "core/cpu/fused/kernel/fused_group-inl.h"
#include "core/cpu/fused/kernel/fused_weights-inl.h"
#include "core/cpu/fused/kernel/weight_lanes.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

template <int D0, int D1, int D2>
struct WeightedInstance {
  static void Group(GroupArguments& arguments, const WeightedPatch& weights) {
    for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(D())) {
      if (!arguments.normals) {
        GroupAt<false, false>(arguments, weights, lane);
      } else if (arguments.smooth == nullptr) {
        GroupAt<true, false>(arguments, weights, lane);
      } else {
        GroupAt<true, true>(arguments, weights, lane);
      }
    }
  }

  template <bool kNormals, bool kSmooth>
  static void GroupAt(GroupArguments& arguments, const WeightedPatch& weights, size_t lane) {
    if (arguments.segments <= kMostDirectSegments) {
      DirectGroupKernel<D0, D1, D2, kNormals, kSmooth, Weights>(arguments, lane, &weights).Run();
    } else {
      GroupKernel<D0, D1, D2, kNormals, kSmooth, Weights>(arguments, lane, &weights).Run();
    }
  }

  static void Edges(const BoxPolynomial& box, const EdgeLanes& edges, const EdgeWeights& weights,
                    int segments, float* out) {
    for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(D())) {
      V from[3], to[3];
      LoadPoint(edges.from, lane, from);
      LoadPoint(edges.to, lane, to);
      const EdgeLine line(from, to);
      V rest_from[3], rest_to[3];
      RestAt(box, from, rest_from);
      RestAt(box, to, rest_to);
      const WeightedLine weighted(rest_from, rest_to, LoadLanes(weights.from, lane),
                                  LoadLanes(weights.to, lane));
      const auto store = [&](size_t k, size_t c, V offset) HWY_ATTR {
        hn::Store(weighted.Position(static_cast<int>(k), segments, c, offset), D(),
                  out + ((k - 1) * 3 + c) * kLanes + lane);
      };
      if (segments <= kMostDirectSegments) {
        DirectEdgePoints<D0, D1, D2>(box, line, segments, store);
      } else {
        ComposedEdgePoints<D0, D1, D2>(box, line, segments, store);
      }
    }
  }

  static void Corners(const BoxPolynomial& box, const CornerLanes& corners,
                      const CornerWeights& weights, float* out) {
    for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(D())) {
      V point[3], rest[3], offset;
      LoadPoint(corners, lane, point);
      RestAt(box, point, rest);
      const V weight = LoadLanes(weights.weight, lane);
      for (size_t c = 0; c < 3; ++c) {
        EvaluatePoint<D0, D1, D2, false>(box, point, static_cast<int>(c), &offset);
        hn::Store(hn::MulAdd(weight, offset, rest[c]), D(), out + c * kLanes + lane);
      }
    }
  }
};

void EvaluateWeightedGroupImpl(GroupArguments& arguments, const WeightedPatch& weights) {
  WithDegrees<WeightedInstance>(arguments.degree,
                                [&](auto instance) { instance.Group(arguments, weights); });
}
void EvaluateWeightedEdgesImpl(const std::array<int, 3>& degree, const BoxPolynomial& box,
                               const EdgeLanes& edges, const EdgeWeights& weights, int segments,
                               float* out) {
  WithDegrees<WeightedInstance>(
      degree, [&](auto instance) { instance.Edges(box, edges, weights, segments, out); });
}
void EvaluateWeightedCornersImpl(const std::array<int, 3>& degree, const BoxPolynomial& box,
                                 const CornerLanes& corners, const CornerWeights& weights,
                                 float* out) {
  WithDegrees<WeightedInstance>(
      degree, [&](auto instance) { instance.Corners(box, corners, weights, out); });
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace latticed::fused {

HWY_EXPORT(EvaluateWeightedGroupImpl);
HWY_EXPORT(EvaluateWeightedEdgesImpl);
HWY_EXPORT(EvaluateWeightedCornersImpl);

void EvaluateWeightedGroup(GroupArguments& arguments, const WeightedPatch& weights) {
  HWY_DYNAMIC_DISPATCH(EvaluateWeightedGroupImpl)(arguments, weights);
}
void EvaluateWeightedEdges(const std::array<int, 3>& degree, const BoxPolynomial& box,
                           const EdgeLanes& edges, const EdgeWeights& weights, int segments,
                           float* out) {
  HWY_DYNAMIC_DISPATCH(EvaluateWeightedEdgesImpl)(degree, box, edges, weights, segments, out);
}
void EvaluateWeightedCorners(const std::array<int, 3>& degree, const BoxPolynomial& box,
                             const CornerLanes& corners, const CornerWeights& weights, float* out) {
  HWY_DYNAMIC_DISPATCH(EvaluateWeightedCornersImpl)(degree, box, corners, weights, out);
}

}  // namespace latticed::fused
#endif  // HWY_ONCE
