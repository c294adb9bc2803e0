// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluates all points of a group from the polynomial of the box, without composing one for each patch:
//
//   position   R at the point; an edge point has the same place, bit for bit, from both sides
//   normal     cof(J) N = n0 J1 x J2 + n1 J2 x J0 + n2 J0 x J1, where J is the Jacobian of R at the point
//              and n the conormal of N; smooth normals interpolate it from the corners
//
// Included once per instruction set by fused_kernel.cc.
#if defined(LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_DIRECT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_DIRECT_INL_H_
#undef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_DIRECT_INL_H_
#else
#define LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_DIRECT_INL_H_
#endif

#include <array>

#include "core/cpu/fused/kernel/fused_edge-inl.h"
#include "core/cpu/fused/kernel/fused_point-inl.h"
#include "core/cpu/fused/kernel/fused_vertices-inl.h"
#include "core/cpu/fused/kernel/fused_weights-inl.h"
#include "core/ffd/tessellation_pattern.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

template <int D0, int D1, int D2, bool kNormals, bool kSmooth, class PatchWeights = NoWeights>
class DirectGroupKernel {
 public:
  DirectGroupKernel(GroupArguments& arguments, size_t lane, const WeightedPatch* weights = nullptr)
      : args_(arguments),
        lane_(lane),
        segments_(arguments.segments),
        weights_(arguments, weights, lane),
        vertices_(MakeVertices(arguments, lane, hn::Set(D(), 1.0f), weights_)) {
    for (size_t c = 0; c < 3; ++c) LoadPoint(args_.patches->corners[c], lane_, corners_[c]);
  }

  void Run() {
    const TessellationPattern& pattern = TessellationPattern::Get(segments_);
    V place[3];
    for (size_t e = 0; e < 3; ++e) {
      const auto& points = pattern.edge_points[e];
      const EdgeLine line(corners_[e], corners_[(e + 1) % 3]);
      weights_.SetCorner(e);
      Evaluate(corners_[e], pattern.points[points[0]], points[0]);
      const auto weighted_line = weights_.Line(e, (e + 1) % 3);
      for (int k = 1; k < segments_; ++k) {
        const size_t point = points[static_cast<size_t>(k)];
        line.Place(k, segments_, place);
        weights_.SetOnLine(weighted_line, k, segments_);
        Evaluate(place, pattern.points[point], point);
      }
    }
    for (size_t point = 0; point < pattern.points.size(); ++point) {
      const Steps& steps = pattern.points[point];
      if (steps[0] == 0 || steps[1] == 0 || steps[2] == 0) continue;
      for (size_t a = 0; a < 3; ++a) {
        place[a] = Interpolate(corners_[0][a], corners_[1][a], corners_[2][a], steps);
      }
      weights_.SetInside([&](V v0, V v1, V v2) HWY_ATTR { return Interpolate(v0, v1, v2, steps); });
      Evaluate(place, steps, point);
    }
  }

 private:
  using Steps = std::array<uint8_t, 3>;  // barycentrics times segments

  HWY_INLINE V Interpolate(V v0, V v1, V v2, const Steps& steps) const {
    const D d;
    const float step = 1.0f / static_cast<float>(segments_);
    return hn::MulAdd(
        v0, hn::Set(d, steps[0] * step),
        hn::MulAdd(v1, hn::Set(d, steps[1] * step), hn::Mul(v2, hn::Set(d, steps[2] * step))));
  }

  HWY_NOINLINE void Evaluate(const V* place, const Steps& steps, size_t point) {
    V jet[3][kNormals ? 4 : 1];
    for (int c = 0; c < 3; ++c) {
      EvaluatePoint<D0, D1, D2, kNormals>(*args_.box, place, c, jet[c]);
      weights_.template Combine<kNormals>(static_cast<size_t>(c), jet[c]);
      vertices_.Store(static_cast<size_t>(c), point, jet[c][0]);
    }
    if constexpr (kNormals) {
      vertices_.StoreNormal(
          CofactorTimes(jet, Conormal(0, steps), Conormal(1, steps), Conormal(2, steps)), point);
    }
  }

  HWY_INLINE V Conormal(size_t component, const Steps& steps) const {
    const auto load = [&](const Lanes& lanes)
                          HWY_ATTR { return hn::Load(D(), lanes.data() + lane_); };
    if constexpr (kSmooth) {
      const auto& n = args_.smooth->conormal[component];
      return Interpolate(load(n[0]), load(n[1]), load(n[2]), steps);
    } else {
      return load(args_.patches->conormal[component]);
    }
  }

  GroupArguments& args_;
  const size_t lane_;
  const int segments_;
  PatchWeights weights_;
  GroupVertices vertices_;
  V corners_[3][3];  // [corner][axis]
};

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_DIRECT_INL_H_
