// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How the kernels of a group combine offsets with positions at rest (weight_lanes.h). NoWeights stands for a mesh without
// weights: it does nothing, and the kernels are the same as if it were not there.
// Included once per instruction set by each kernel.
#if defined(LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_WEIGHTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_WEIGHTS_INL_H_
#undef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_WEIGHTS_INL_H_
#else
#define LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_WEIGHTS_INL_H_
#endif

#include "core/cpu/fused/kernel/fused_edge-inl.h"
#include "core/cpu/fused/kernel/fused_polynomial-inl.h"
#include "core/cpu/fused/kernel/fused_vertices-inl.h"
#include "core/cpu/fused/kernel/weight_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

HWY_INLINE V LoadLanes(const Lanes& lanes, size_t lane) {
  return hn::Load(D(), lanes.data() + lane);
}

// The position at rest of a point in box-local coordinates.
HWY_INLINE void RestAt(const BoxPolynomial& box, const V* l, V* rest) {
  const D d;
  for (size_t c = 0; c < 3; ++c) {
    rest[c] = hn::Set(d, box.rest[0][c]);
    for (size_t i = 0; i < 3; ++i) {
      rest[c] = hn::MulAdd(hn::Set(d, box.rest[1 + i][c]), l[i], rest[c]);
    }
  }
}

// The points of an edge at rest, and their weights. Exchanging the ends does not change the bits of a point.
class WeightedLine {
 public:
  WeightedLine(const V* from, const V* to, V weight_from, V weight_to)
      : rest_(from, to),
        weight_(hn::Mul(hn::Set(D(), 0.5f), hn::Add(weight_from, weight_to))),
        rise_(hn::Sub(weight_to, weight_from)) {}

  HWY_INLINE void Place(int k, int segments, V* rest, V& weight) const {
    rest_.Place(k, segments, rest);
    weight = hn::MulAdd(rise_, EdgeLine::Tau(k, segments), weight_);
  }
  // Component c of the k-th point, from that of its offset.
  HWY_INLINE V Position(int k, int segments, size_t c, V offset) const {
    V rest[3], weight;
    Place(k, segments, rest, weight);
    return hn::MulAdd(weight, offset, rest[c]);
  }

 private:
  const EdgeLine rest_;
  const V weight_, rise_;
};

struct NoWeights {
  static constexpr int kDegree = 0;  // of w
  struct Edge {
    HWY_INLINE V Position(int, int, size_t, V position) const { return position; }
  };
  NoWeights(const GroupArguments&, const WeightedPatch*, size_t) {}

  HWY_INLINE Edge Line(size_t, size_t) const { return {}; }
  HWY_INLINE void SetCorner(size_t) const {}
  HWY_INLINE void SetOnLine(Edge, int, int) const {}
  template <class Interpolate>
  HWY_INLINE void SetInside(const Interpolate&) const {}
  template <bool kSlopes>
  HWY_INLINE void Combine(size_t, V*) const {}
};

class Weights {
 public:
  static constexpr int kDegree = 1;  // of w
  Weights(const GroupArguments& group, const WeightedPatch* patch, size_t lane)
      : box_(*group.box), patch_(*patch), lane_(lane) {
    for (size_t corner = 0; corner < 3; ++corner) {
      V local[3];
      LoadPoint(group.patches->corners[corner], lane, local);
      RestAt(box_, local, rest_of_[corner]);
      weight_of_[corner] = Load(patch_.weights.corners[corner]);
    }
  }

  // An upper bound of the norm of cof J: half the squared Frobenius norm of J = I + w J_G + G grad(w)^T.
  V CofactorBound() const {
    const D d;
    const V norm = hn::MulAdd(Load(patch_.weights.steepness), hn::Set(d, box_.offset_bound),
                              hn::Set(d, 1.7320508f + box_.slope_bound));
    return hn::Mul(hn::Set(d, 0.5f), hn::Mul(norm, norm));
  }

  // out = x + w G: a polynomial of degree N + 1 on the patch, from that of the offset's component c. With kNormal also the
  // derivative along the facet normal, where w does not change, from the offset's `slope`.
  template <int N, bool kNormal>
  HWY_INLINE void Blend(size_t c, const V* offset, const V* slope, V* out, V* normal_out) const {
    const V weight[3] = {Load(patch_.center.weight), Load(patch_.along.weight),
                         Load(patch_.across.weight)};
    const V rest[3] = {Load(patch_.center.rest.point[c]), Load(patch_.along.rest.point[c]),
                       Load(patch_.across.rest.point[c])};
    MultiplyLinearAdd<N, 1>(offset, weight, rest, out);
    if constexpr (kNormal) {
      const V facet = Load(patch_.facet.point[c]);
      MultiplyLinearAdd<N - 1, 0>(slope, weight, &facet, normal_out);
    }
  }

  // A point for Combine.
  void SetCorner(size_t corner) {
    for (size_t a = 0; a < 3; ++a) rest_[a] = rest_of_[corner][a];
    weight_ = weight_of_[corner];
  }
  WeightedLine Line(size_t from, size_t to) const {
    return {rest_of_[from], rest_of_[to], weight_of_[from], weight_of_[to]};
  }
  void SetOnLine(const WeightedLine& line, int k, int segments) {
    line.Place(k, segments, rest_, weight_);
  }
  template <class Interpolate>
  void SetInside(const Interpolate& interpolate) {
    for (size_t a = 0; a < 3; ++a) {
      rest_[a] = interpolate(rest_of_[0][a], rest_of_[1][a], rest_of_[2][a]);
    }
    weight_ = interpolate(weight_of_[0], weight_of_[1], weight_of_[2]);
  }
  // Turns the jet of the offset's component c at the point that was set into that of the position. Order of the jet:
  // EvaluatePoint.
  template <bool kSlopes>
  HWY_INLINE void Combine(size_t c, V* jet) const {
    const V offset = jet[0];
    jet[0] = hn::MulAdd(weight_, offset, rest_[c]);
    if constexpr (kSlopes) {
      for (size_t l = 0; l < 3; ++l) {
        const V rest = hn::MulAdd(Load(patch_.weights.by_local.point[l]), offset,
                                  hn::Set(D(), box_.rest[1 + l][c]));
        jet[3 - l] = hn::MulAdd(weight_, jet[3 - l], rest);
      }
    }
  }

 private:
  HWY_INLINE V Load(const Lanes& lanes) const { return LoadLanes(lanes, lane_); }

  const BoxPolynomial& box_;
  const WeightedPatch& patch_;
  const size_t lane_;
  V rest_of_[3][3], weight_of_[3];  // [corner]
  V rest_[3], weight_;
};

HWY_INLINE GroupVertices MakeVertices(GroupArguments& arguments, size_t lane, V scale,
                                      const NoWeights&) {
  return {arguments, lane, scale};
}
HWY_INLINE GroupVertices MakeVertices(GroupArguments& arguments, size_t lane, V scale,
                                      const Weights& weights) {
  return {arguments, lane, scale, weights.CofactorBound()};
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_WEIGHTS_INL_H_
