// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluates all points of a group: the rows of the composed polynomials, and then edges and corners, which
// overwrite the ends of rows. When points are few, fused_direct-inl.h takes less time.
// Included once per instruction set by fused_kernel.cc.
#if defined(LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_GROUP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_GROUP_INL_H_
#undef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_GROUP_INL_H_
#else
#define LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_GROUP_INL_H_
#endif

#include "core/cpu/fused/kernel/fused_edge-inl.h"
#include "core/cpu/fused/kernel/fused_polynomial-inl.h"
#include "core/cpu/fused/kernel/fused_vertices-inl.h"
#include "core/cpu/fused/kernel/fused_weights-inl.h"
#include "core/ffd/tessellation_pattern.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

// Powers t^j and j t^(j-1), the same for all lanes.
template <int N>
struct RowPowers {
  float value[N + 1], derivative[N + 1];
  explicit RowPowers(float t) {
    value[0] = 1;
    derivative[0] = 0;
    for (int j = 1; j <= N; ++j) {
      value[j] = value[j - 1] * t;
      derivative[j] = static_cast<float>(j) * value[j - 1];
    }
  }
};

// Computes the row polynomials in x at t (plus) and at -t (minus) from one pass over the even and odd
// parts: the value, of degree N, and d/dt, of degree N - 1.
template <int N, bool kSlope>
HWY_INLINE void CollapseRows(const V* HWY_RESTRICT p, const float* powers,
                             const float* power_slopes, V* HWY_RESTRICT plus, V* HWY_RESTRICT minus,
                             V* HWY_RESTRICT slope_plus, V* HWY_RESTRICT slope_minus) {
  const D d;
  LATTICED_UNROLL for (int i = 0; i <= N; ++i) {
    V even = p[At(i, 0)], odd = hn::Zero(d), slope_even = hn::Zero(d), slope_odd = hn::Zero(d);
    LATTICED_UNROLL for (int j = 1; j <= N - i; ++j) {
      const V coefficient = p[At(i, j)];
      const V power = hn::Set(d, powers[j]);
      const V slope = kSlope ? hn::Set(d, power_slopes[j]) : power;
      if (j % 2 == 0) {
        even = hn::MulAdd(coefficient, power, even);
        if (kSlope) slope_odd = hn::MulAdd(coefficient, slope, slope_odd);
      } else {
        odd = hn::MulAdd(coefficient, power, odd);
        if (kSlope) slope_even = hn::MulAdd(coefficient, slope, slope_even);
      }
    }
    plus[i] = hn::Add(even, odd);
    minus[i] = hn::Sub(even, odd);
    if (kSlope && i < N) {
      slope_plus[i] = hn::Add(slope_even, slope_odd);
      slope_minus[i] = hn::Sub(slope_even, slope_odd);
    }
  }
}

template <int N>
HWY_INLINE V Horner(const V* c, V x) {
  V sum = c[N];
  LATTICED_UNROLL for (int k = N - 1; k >= 0; --k) sum = hn::MulAdd(sum, x, c[k]);
  return sum;
}

// Value and derivative together.
template <int N>
HWY_INLINE void HornerWithSlope(const V* c, V x, V& value, V& slope) {
  value = c[N];
  slope = c[N];
  LATTICED_UNROLL for (int k = N - 1; k >= 0; --k) {
    value = hn::MulAdd(value, x, c[k]);
    if (k > 0) slope = hn::MulAdd(slope, x, value);
  }
}

// The polynomials of one row, all components.
template <int N, bool kSmooth>
struct Row {
  V position[3][N + 1];
  V across[3][N];        // d position / d t
  V along_normal[3][N];  // d R / d facet normal; smooth only
};

template <int D0, int D1, int D2, bool kNormals, bool kSmooth, class PatchWeights = NoWeights>
class GroupKernel {
  static constexpr int kVolumeDegree = D0 + D1 + D2,
                       kDegree = kVolumeDegree + PatchWeights::kDegree;

 public:
  GroupKernel(GroupArguments& arguments, size_t lane, const WeightedPatch* weights = nullptr)
      : args_(arguments),
        lane_(lane),
        segments_(arguments.segments),
        shear_(Load(args_.patches->shear)),
        inverse_height_(Load(args_.patches->inverse_height)),
        weights_(arguments, weights, lane),
        vertices_(MakeVertices(arguments, lane,
                               kSmooth ? Broadcast(1.0f) : Load(args_.patches->along_length),
                               weights_)) {}

  void Run() {
    ComposeAll();
    for (int low = 0; 2 * low <= segments_; ++low) {
      const int high = segments_ - low;
      const float t = static_cast<float>(high) / static_cast<float>(segments_) - 0.5f;
      const RowPowers<kDegree> powers(t);
      Row<kDegree, kSmooth> plus, minus;
      for (int c = 0; c < 3; ++c) {
        CollapseRows<kDegree, kNormals>(composed_[c], powers.value, powers.derivative,
                                        plus.position[c], minus.position[c], plus.across[c],
                                        minus.across[c]);
        if constexpr (kSmooth) {
          CollapseNormalRows(composed_normal_[c], powers, plus.along_normal[c],
                             minus.along_normal[c]);
        }
      }
      EvaluateRow(low, minus);
      if (high != low) EvaluateRow(high, plus);
    }
    EvaluateAllEdges();
  }

 private:
  V Load(const Lanes& lanes) const { return hn::Load(D(), lanes.data() + lane_); }
  V Broadcast(float value) const { return hn::Set(D(), value); }

  static void CollapseNormalRows(const V* p, const RowPowers<kDegree>& powers, V* plus, V* minus) {
    V no_slope_plus[1], no_slope_minus[1];
    CollapseRows<kDegree - 1, false>(p, powers.value, nullptr, plus, minus, no_slope_plus,
                                     no_slope_minus);
  }

  void ComposeAll() {
    const PatchLanes& p = *args_.patches;
    AffineMap map;
    for (size_t a = 0; a < 3; ++a) {
      map.l[a][0] = Load(p.center[a]);
      map.l[a][1] = Load(p.along[a]);
      map.l[a][2] = Load(p.across[a]);
      if constexpr (kSmooth) map.normal[a] = Load(args_.smooth->facet[a]);
    }
    Powers<D2>(map);
    for (int c = 0; c < 3; ++c) {
      if constexpr (PatchWeights::kDegree == 0) {
        Compose<D0, D1, D2, 0, kSmooth>(*args_.box, map, c, composed_[c], composed_normal_[c]);
      } else {
        V offset[Terms(kVolumeDegree)], slope[Terms(kVolumeDegree - 1)];
        Compose<D0, D1, D2, 0, kSmooth>(*args_.box, map, c, offset, slope);
        weights_.template Blend<kVolumeDegree, kSmooth>(static_cast<size_t>(c), offset, slope,
                                                        composed_[c], composed_normal_[c]);
      }
    }
  }

  void EvaluateRow(int row, const Row<kDegree, kSmooth>& r) {
    const float step = 1.0f / static_cast<float>(segments_);
    const float b2 = static_cast<float>(row) * step;
    const V x0 = hn::MulSub(shear_, Broadcast(b2), Broadcast(0.5f));
    for (int k = 0; k <= segments_ - row; ++k) {
      const float b1 = static_cast<float>(k) * step;
      const auto point = static_cast<size_t>(PointIndex(segments_, row, k));
      EvaluatePointOfRow(r, hn::Add(x0, Broadcast(b1)), b1, b2, point);
    }
  }

  HWY_INLINE void EvaluatePointOfRow(const Row<kDegree, kSmooth>& r, V x, float b1, float b2,
                                     size_t point) {
    if constexpr (!kNormals) {
      for (size_t c = 0; c < 3; ++c) {
        vertices_.Store(c, point, Horner<kDegree>(r.position[c], x));
      }
      return;
    }
    V3 position, along;
    HornerWithSlope<kDegree>(r.position[0], x, position.x, along.x);
    HornerWithSlope<kDegree>(r.position[1], x, position.y, along.y);
    HornerWithSlope<kDegree>(r.position[2], x, position.z, along.z);
    vertices_.Store(0, point, position.x);
    vertices_.Store(1, point, position.y);
    vertices_.Store(2, point, position.z);
    const V3 across{Across(r, x, 0), Across(r, x, 1), Across(r, x, 2)};
    V3 normal = CrossLanes(along, across);
    if constexpr (kSmooth) normal = CarrySmooth(r, x, b1, b2, along, across, normal);
    vertices_.StoreNormal(normal, point);
  }

  HWY_INLINE V Across(const Row<kDegree, kSmooth>& r, V x, size_t c) const {
    return hn::Mul(Horner<kDegree - 1>(r.across[c], x), inverse_height_);
  }

  // cof(J) N = n_f P_a x P_c + n_a P_c x P_f + n_c P_f x P_a for N given in the frame.
  HWY_INLINE V3 CarrySmooth(const Row<kDegree, kSmooth>& r, V x, float b1, float b2,
                            const V3& along, const V3& across, const V3& facet) {
    const V3 off{Horner<kDegree - 1>(r.along_normal[0], x),
                 Horner<kDegree - 1>(r.along_normal[1], x),
                 Horner<kDegree - 1>(r.along_normal[2], x)};
    const V3 first = CrossLanes(across, off), second = CrossLanes(off, along);
    const V nf = VertexNormal(0, b1, b2), na = VertexNormal(1, b1, b2);
    const V nc = VertexNormal(2, b1, b2);
    const auto combine = [&](V f, V a, V c) HWY_ATTR {
      return hn::MulAdd(nf, f, hn::MulAdd(na, a, hn::Mul(nc, c)));
    };
    return {combine(facet.x, first.x, second.x), combine(facet.y, first.y, second.y),
            combine(facet.z, first.z, second.z)};
  }

  HWY_INLINE V VertexNormal(size_t component, float b1, float b2) const {
    const auto& n = args_.smooth->normal[component];
    return hn::MulAdd(Load(n[0]), Broadcast(1.0f - b1 - b2),
                      hn::MulAdd(Load(n[1]), Broadcast(b1), hn::Mul(Load(n[2]), Broadcast(b2))));
  }

  void EvaluateAllEdges() {
    const TessellationPattern& pattern = TessellationPattern::Get(segments_);
    V corners[3][3];
    for (size_t e = 0; e < 3; ++e) LoadPoint(args_.patches->corners[e], lane_, corners[e]);
    for (size_t e = 0; e < 3; ++e) {
      const auto& points = pattern.edge_points[e];
      const auto line = weights_.Line(e, (e + 1) % 3);
      const auto store = [&](size_t k, size_t c, V value) HWY_ATTR {
        vertices_.Store(c, points[k], line.Position(static_cast<int>(k), segments_, c, value));
      };
      ComposedEdgePoints<D0, D1, D2>(*args_.box, EdgeLine(corners[e], corners[(e + 1) % 3]),
                                     segments_, store);
      weights_.SetCorner(e);
      for (int c = 0; c < 3; ++c) {
        V value;
        EvaluatePoint<D0, D1, D2, false>(*args_.box, corners[e], c, &value);
        weights_.template Combine<false>(static_cast<size_t>(c), &value);
        vertices_.Store(static_cast<size_t>(c), points[0], value);
      }
    }
  }

  GroupArguments& args_;
  const size_t lane_;
  const int segments_;
  const V shear_, inverse_height_;
  PatchWeights weights_;
  GroupVertices vertices_;
  V composed_[3][Terms(kDegree)];
  V composed_normal_[3][kSmooth ? Terms(kDegree - 1) : 1];
};

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_GROUP_INL_H_
