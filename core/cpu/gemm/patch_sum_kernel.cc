// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compiled once per instruction set (AVX-512, AVX2, and the compiler's baseline); Highway picks one at run time.
#include "core/cpu/gemm/patch_sum_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/cpu/gemm/patch_sum_kernel.cc"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Highway requires these includes to follow foreach_target.
#include "core/points/lane_vectors-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::patch_sums {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using namespace points::HWY_NAMESPACE::lanes;  // NOLINT(google-build-using-namespace)

constexpr int kMaxOrder = limits::kMaxDegree + 1;

HWY_INLINE V3 SetAll(Vec3d v) { return Set3(v.x, v.y, v.z); }
HWY_INLINE V Blend(const V3& barycentrics, double a, double b, double c) {
  const D d;
  const V sum = hn::MulAdd(barycentrics.y, hn::Set(d, b), hn::Mul(barycentrics.x, hn::Set(d, a)));
  return hn::MulAdd(barycentrics.z, hn::Set(d, c), sum);
}
HWY_INLINE V3 Blend3(const V3& barycentrics, const Corners& corners) {
  const auto& [a, b, c] = corners;
  return {Blend(barycentrics, a.x, b.x, c.x), Blend(barycentrics, a.y, b.y, c.y),
          Blend(barycentrics, a.z, b.z, c.z)};
}

// One over the differences of knots in bspline_basis.h: [degree of the functions][r], of one axis.
struct Reciprocals {
  double at[kMaxOrder][kMaxOrder];

  Reciprocals(const double* span, int degree) {
    for (int j = 1; j <= degree; ++j) {
      for (int r = 0; r < j; ++r) at[j][r] = 1 / (span[r + 1] - span[r + 1 - j]);
    }
  }
};

// Basis functions of one axis and, with kSlopes, their derivatives (bspline_basis.h).
struct Basis {
  V value[kMaxOrder], slope[kMaxOrder];
};

template <bool kSlopes>
HWY_INLINE void SetBasis(const double* span, int degree, const Reciprocals& reciprocals, V u,
                         Basis& basis) {
  const D d;
  basis.value[0] = hn::Set(d, 1.0);
  for (int j = 1; j <= degree; ++j) {
    V saved = hn::Zero(d), term_before = hn::Zero(d);
    for (int r = 0; r < j; ++r) {
      const V right = hn::Sub(hn::Set(d, span[r + 1]), u),
              left = hn::Sub(u, hn::Set(d, span[r + 1 - j]));
      const V term = hn::Mul(basis.value[r], hn::Set(d, reciprocals.at[j][r]));
      if constexpr (kSlopes) {
        if (j == degree) {
          basis.slope[r] =
              hn::Mul(hn::Set(d, static_cast<double>(degree)), hn::Sub(term_before, term));
          term_before = term;
        }
      }
      basis.value[r] = hn::MulAdd(right, term, saved);
      saved = hn::Mul(left, term);
    }
    basis.value[j] = saved;
    if constexpr (kSlopes) {
      if (j == degree)
        basis.slope[j] = hn::Mul(hn::Set(d, static_cast<double>(degree)), term_before);
    }
  }
}

// R less its origin, and with kSlopes its derivatives by u, v, w.
struct Sums {
  V3 value, by[3];
};

template <bool kSlopes>
HWY_INLINE void SumPoints(const Volume& volume, const Basis (&basis)[3], Sums& sums) {
  sums = {Zero3(), {Zero3(), Zero3(), Zero3()}};
  const double* p = volume.points.data();
  for (int k = 0; k <= volume.degree[2]; ++k) {
    V3 plane = Zero3(), plane_u = Zero3(), plane_v = Zero3();
    for (int j = 0; j <= volume.degree[1]; ++j) {
      V3 row = Zero3(), row_u = Zero3();
      for (int i = 0; i <= volume.degree[0]; ++i, p += 3) {
        const V3 point = Set3(p[0], p[1], p[2]);
        row = AddTimes(basis[0].value[i], point, row);
        if constexpr (kSlopes) row_u = AddTimes(basis[0].slope[i], point, row_u);
      }
      plane = AddTimes(basis[1].value[j], row, plane);
      if constexpr (kSlopes) {
        plane_u = AddTimes(basis[1].value[j], row_u, plane_u);
        plane_v = AddTimes(basis[1].slope[j], row, plane_v);
      }
    }
    sums.value = AddTimes(basis[2].value[k], plane, sums.value);
    if constexpr (kSlopes) {
      sums.by[0] = AddTimes(basis[2].value[k], plane_u, sums.by[0]);
      sums.by[1] = AddTimes(basis[2].value[k], plane_v, sums.by[1]);
      sums.by[2] = AddTimes(basis[2].slope[k], plane, sums.by[2]);
    }
  }
}

template <bool kAdd>
HWY_INLINE void StoreDerivatives(const Volume& volume, const Rest& rest, const Sums& sums, size_t i,
                                 Values& values) {
  for (size_t k = 0; k < rest.direction_count; ++k) {
    V3 along = Zero3();
    for (int axis = 0; axis < 3; ++axis) {
      along = AddTimes(hn::Set(D(), volume.directions[k][axis]), sums.by[axis], along);
    }
    if constexpr (kAdd) {
      along = Sum(Load3(values.along[k], i), Difference(along, SetAll(rest.directions[k])));
    }
    Store3(along, values.along[k], i);
  }
}

template <bool kAdd, bool kSlopes>
void TakeVolumeOf(const Places& places, const Volume& volume, const Rest& rest, Values& values) {
  const Reciprocals reciprocals[3] = {{volume.span[0], volume.degree[0]},
                                      {volume.span[1], volume.degree[1]},
                                      {volume.span[2], volume.degree[2]}};
  for (size_t i = 0; i < places.count; i += hn::Lanes(D())) {
    const V3 barycentrics = Load3(places.barycentrics, i);
    const V3 at = Blend3(barycentrics, volume.parameters);
    const V parameter[3] = {at.x, at.y, at.z};
    Basis basis[3];
    for (size_t a = 0; a < 3; ++a) {
      SetBasis<kSlopes>(volume.span[a], volume.degree[a], reciprocals[a], parameter[a], basis[a]);
    }
    Sums sums;
    SumPoints<kSlopes>(volume, basis, sums);
    V3 position = Sum(sums.value, SetAll(volume.origin));
    if constexpr (kAdd) {
      position =
          Sum(Load3(values.position, i), Difference(position, Blend3(barycentrics, rest.corners)));
    }
    Store3(position, values.position, i);
    if constexpr (kSlopes) StoreDerivatives<kAdd>(volume, rest, sums, i, values);
  }
}

template <bool kAdd>
void TakeVolume(const Places& places, const Volume& volume, const Rest& rest, Values& values) {
  if (rest.direction_count == 0) return TakeVolumeOf<kAdd, false>(places, volume, rest, values);
  TakeVolumeOf<kAdd, true>(places, volume, rest, values);
}

void SetVolumeImpl(const Places& places, const Volume& volume, const Rest& rest, Values& values) {
  TakeVolume<false>(places, volume, rest, values);
}
void AddVolumeImpl(const Places& places, const Volume& volume, const Rest& rest, Values& values) {
  TakeVolume<true>(places, volume, rest, values);
}

void SetRestImpl(const Places& places, const Rest& rest, Values& values) {
  for (size_t i = 0; i < places.count; i += hn::Lanes(D())) {
    Store3(Blend3(Load3(places.barycentrics, i), rest.corners), values.position, i);
    for (size_t k = 0; k < rest.direction_count; ++k) {
      Store3(SetAll(rest.directions[k]), values.along[k], i);
    }
  }
}

void WeighImpl(const Places& places, const Weights& weights, const Rest& rest, Values& values) {
  const D d;
  for (size_t i = 0; i < places.count; i += hn::Lanes(d)) {
    const V3 barycentrics = Load3(places.barycentrics, i);
    const auto& [a, b, c] = weights.corners;
    const V weight = Blend(barycentrics, a, b, c);
    const V3 at_rest = Blend3(barycentrics, rest.corners);
    const V3 move = Difference(Load3(values.position, i), at_rest);
    V3 position = at_rest;
    position = AddTimes(weight, move, position);
    Store3(position, values.position, i);
    for (size_t k = 0; k < rest.direction_count; ++k) {
      const V3 direction = SetAll(rest.directions[k]);
      V3 along = direction;
      along = AddTimes(weight, Difference(Load3(values.along[k], i), direction), along);
      along = AddTimes(hn::Set(d, weights.along[k]), move, along);
      Store3(along, values.along[k], i);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::patch_sums
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace latticed::patch_sums {

HWY_EXPORT(SetRestImpl);
HWY_EXPORT(SetVolumeImpl);
HWY_EXPORT(AddVolumeImpl);
HWY_EXPORT(WeighImpl);

void SetRest(const Places& places, const Rest& rest, Values& values) {
  HWY_DYNAMIC_DISPATCH(SetRestImpl)(places, rest, values);
}
void SetVolume(const Places& places, const Volume& volume, const Rest& rest, Values& values) {
  HWY_DYNAMIC_DISPATCH(SetVolumeImpl)(places, volume, rest, values);
}
void AddVolume(const Places& places, const Volume& volume, const Rest& rest, Values& values) {
  HWY_DYNAMIC_DISPATCH(AddVolumeImpl)(places, volume, rest, values);
}
void Weigh(const Places& places, const Weights& weights, const Rest& rest, Values& values) {
  HWY_DYNAMIC_DISPATCH(WeighImpl)(places, weights, rest, values);
}

}  // namespace latticed::patch_sums
#endif  // HWY_ONCE
