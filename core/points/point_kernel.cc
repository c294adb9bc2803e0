// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compiled once per instruction set (AVX-512, AVX2, and the compiler's baseline); Highway picks one at run time.
#include "core/points/point_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/points/point_kernel.cc"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Highway requires this include to follow foreach_target.
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::points {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;

size_t PaddedCountImpl(size_t count) {
  const size_t lanes = hn::Lanes(D());
  return (count + lanes - 1) / lanes * lanes;
}

// Zero in the lanes from `count` on.
HWY_INLINE V LoadSome(const double* values, size_t count) {
  const D d;
  if (count >= hn::Lanes(d)) return hn::LoadU(d, values);
  HWY_ALIGN double some[hn::MaxLanes(D())] = {};
  for (size_t i = 0; i < count; ++i) some[i] = values[i];
  return hn::Load(d, some);
}

void MapBlockImpl(const LocalMap& map, const std::array<const double*, 3>& world, size_t count,
                  BlockVec& local) {
  const D d;
  const size_t lanes = hn::Lanes(d);
  const V half = hn::Set(d, 0.5), minus_half = hn::Set(d, -0.5);
  V origin[3], scale[3][3], offset[3];
  for (int a = 0; a < 3; ++a) {
    origin[a] = hn::Set(d, map.frame_origin[a]);
    offset[a] = hn::Set(d, map.offset[a]);
    for (int c = 0; c < 3; ++c) {
      scale[a][c] = hn::Set(d, map.scale[static_cast<size_t>(a)][c]);
    }
  }
  for (size_t i = 0; i < count; i += lanes) {
    V x[3];
    for (size_t c = 0; c < 3; ++c) {
      x[c] = hn::Sub(LoadSome(world[c] + i, count - i), origin[c]);
    }
    for (size_t a = 0; a < 3; ++a) {
      V sum = hn::MulAdd(scale[a][0], x[0], offset[a]);
      sum = hn::MulAdd(scale[a][1], x[1], sum);
      sum = hn::MulAdd(scale[a][2], x[2], sum);
      // A point is in its box, but for rounding and for the snapping of knot_split.h.
      hn::StoreU(hn::Min(hn::Max(sum, minus_half), half), d, local[a].data() + i);
    }
  }
}

// One point per lane. kSlopes: the derivatives as well.
template <bool kSlopes>
void EvaluateBlockWith(const std::array<int, 3>& degree, const BoxPolynomial& polynomial,
                       const BlockVec& local, size_t count, BlockVec& values, BlockSlopes* slopes) {
  const D d;
  const size_t lanes = hn::Lanes(d);
  const V zero = hn::Zero(d);
  for (size_t i = 0; i < count; i += lanes) {
    const V l = hn::LoadU(d, local[0].data() + i), m = hn::LoadU(d, local[1].data() + i),
            n = hn::LoadU(d, local[2].data() + i);
    for (size_t c = 0; c < 3; ++c) {
      V value = zero, by_l = zero, by_m = zero, by_n = zero;
      for (int p = degree[0]; p >= 0; --p) {
        V row = zero, row_m = zero, row_n = zero;
        for (int q = degree[1]; q >= 0; --q) {
          const auto& line = polynomial.coefficients.at[p][q];
          V cell = hn::Set(d, line[degree[2]][c]), cell_n = zero;
          for (int r = degree[2] - 1; r >= 0; --r) {
            if constexpr (kSlopes) cell_n = hn::MulAdd(cell_n, n, cell);
            cell = hn::MulAdd(cell, n, hn::Set(d, line[r][c]));
          }
          if constexpr (kSlopes) {
            row_m = hn::MulAdd(row_m, m, row);
            row_n = hn::MulAdd(row_n, m, cell_n);
          }
          row = hn::MulAdd(row, m, cell);
        }
        if constexpr (kSlopes) {
          by_l = hn::MulAdd(by_l, l, value);
          by_m = hn::MulAdd(by_m, l, row_m);
          by_n = hn::MulAdd(by_n, l, row_n);
        }
        value = hn::MulAdd(value, l, row);
      }
      const V origin = hn::Set(d, polynomial.origin[static_cast<int>(c)]);
      hn::StoreU(hn::Add(value, origin), d, values[c].data() + i);
      if constexpr (kSlopes) {
        hn::StoreU(by_l, d, (*slopes)[0][c].data() + i);
        hn::StoreU(by_m, d, (*slopes)[1][c].data() + i);
        hn::StoreU(by_n, d, (*slopes)[2][c].data() + i);
      }
    }
  }
}

void EvaluateBlockImpl(const std::array<int, 3>& degree, const BoxPolynomial& polynomial,
                       const BlockVec& local, size_t count, BlockVec& values, BlockSlopes* slopes) {
  if (slopes == nullptr) {
    EvaluateBlockWith<false>(degree, polynomial, local, count, values, slopes);
  } else {
    EvaluateBlockWith<true>(degree, polynomial, local, count, values, slopes);
  }
}

// Sums of every power, one per lane.
struct LaneSums {
  HWY_ALIGN double at[kPowers][kPowers][kPowers][3][hn::MaxLanes(D())];

  explicit LaneSums(const std::array<int, 3>& degree) {
    ForEach(degree, [](double* lanes) { hn::Store(hn::Zero(D()), D(), lanes); });
  }
  HWY_INLINE void Add(int p, int q, int r, size_t c, V power, V cotangent) {
    double* const lanes = at[p][q][r][c];
    hn::Store(hn::MulAdd(power, cotangent, hn::Load(D(), lanes)), D(), lanes);
  }
  void AddTo(const std::array<int, 3>& degree, BoxNumbers& sums) {
    for (int p = 0; p <= degree[0]; ++p) {
      for (int q = 0; q <= degree[1]; ++q) {
        for (int r = 0; r <= degree[2]; ++r) {
          for (size_t c = 0; c < 3; ++c) {
            double sum = 0;
            for (size_t lane = 0; lane < hn::Lanes(D()); ++lane) sum += at[p][q][r][c][lane];
            sums.at[p][q][r][c] += sum;
          }
        }
      }
    }
  }

 private:
  template <class Body>
  void ForEach(const std::array<int, 3>& degree, Body body) {
    for (int p = 0; p <= degree[0]; ++p) {
      for (int q = 0; q <= degree[1]; ++q) {
        for (int r = 0; r <= degree[2]; ++r) {
          for (size_t c = 0; c < 3; ++c) body(at[p][q][r][c]);
        }
      }
    }
  }
};

void SumBlockImpl(const std::array<int, 3>& degree, const BlockVec& local,
                  const BlockVec& cotangents, size_t count, BoxNumbers& sums) {
  const D d;
  LaneSums lane_sums(degree);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const V l = hn::LoadU(d, local[0].data() + i), m = hn::LoadU(d, local[1].data() + i),
            n = hn::LoadU(d, local[2].data() + i);
    const V gx = hn::LoadU(d, cotangents[0].data() + i),
            gy = hn::LoadU(d, cotangents[1].data() + i),
            gz = hn::LoadU(d, cotangents[2].data() + i);
    V by_l = hn::Set(d, 1.0);
    for (int p = 0; p <= degree[0]; ++p, by_l = hn::Mul(by_l, l)) {
      V by_m = by_l;
      for (int q = 0; q <= degree[1]; ++q, by_m = hn::Mul(by_m, m)) {
        V power = by_m;
        for (int r = 0; r <= degree[2]; ++r, power = hn::Mul(power, n)) {
          lane_sums.Add(p, q, r, 0, power, gx);
          lane_sums.Add(p, q, r, 1, power, gy);
          lane_sums.Add(p, q, r, 2, power, gz);
        }
      }
    }
  }
  lane_sums.AddTo(degree, sums);
}

// t^0 … t^3 and their derivatives.
struct Powers {
  V value[kPowers], slope[kPowers];

  HWY_INLINE explicit Powers(V t) {
    const D d;
    value[0] = hn::Set(d, 1.0);
    slope[0] = hn::Zero(d);
    for (size_t k = 1; k < kPowers; ++k) {
      slope[k] = hn::Mul(hn::Set(d, static_cast<double>(k)), value[k - 1]);
      value[k] = hn::Mul(value[k - 1], t);
    }
  }
};

void SumSlopeBlockImpl(const std::array<int, 3>& degree, const BlockVec& local,
                       const BlockSlopes& cotangents, size_t count, BoxNumbers& sums) {
  const D d;
  LaneSums lane_sums(degree);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const Powers l(hn::LoadU(d, local[0].data() + i)), m(hn::LoadU(d, local[1].data() + i)),
        n(hn::LoadU(d, local[2].data() + i));
    for (size_t c = 0; c < 3; ++c) {
      const V gl = hn::LoadU(d, cotangents[0][c].data() + i),
              gm = hn::LoadU(d, cotangents[1][c].data() + i),
              gn = hn::LoadU(d, cotangents[2][c].data() + i);
      for (int p = 0; p <= degree[0]; ++p) {
        const V l_slope = hn::Mul(l.slope[p], gl), l_m = hn::Mul(l.value[p], gm),
                l_n = hn::Mul(l.value[p], gn);
        for (int q = 0; q <= degree[1]; ++q) {
          // The sum of the derivatives is rest * n^r + last * (n^r)'.
          const V rest = hn::MulAdd(l_slope, m.value[q], hn::Mul(l_m, m.slope[q]));
          const V last = hn::Mul(l_n, m.value[q]);
          for (int r = 0; r <= degree[2]; ++r) {
            lane_sums.Add(p, q, r, c, rest, n.value[r]);
            lane_sums.Add(p, q, r, c, last, n.slope[r]);
          }
        }
      }
    }
  }
  lane_sums.AddTo(degree, sums);
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::points
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace latticed::points {

HWY_EXPORT(PaddedCountImpl);
HWY_EXPORT(MapBlockImpl);
HWY_EXPORT(EvaluateBlockImpl);
HWY_EXPORT(SumBlockImpl);
HWY_EXPORT(SumSlopeBlockImpl);

size_t PaddedCount(size_t count) { return HWY_DYNAMIC_DISPATCH(PaddedCountImpl)(count); }

void MapBlock(const LocalMap& map, const std::array<const double*, 3>& world, size_t count,
              BlockVec& local) {
  HWY_DYNAMIC_DISPATCH(MapBlockImpl)(map, world, count, local);
}

void EvaluateBlock(const std::array<int, 3>& degree, const BoxPolynomial& polynomial,
                   const BlockVec& local, size_t count, BlockVec& values, BlockSlopes* slopes) {
  HWY_DYNAMIC_DISPATCH(EvaluateBlockImpl)(degree, polynomial, local, count, values, slopes);
}

void SumBlock(const std::array<int, 3>& degree, const BlockVec& local, const BlockVec& cotangents,
              size_t count, BoxNumbers& sums) {
  HWY_DYNAMIC_DISPATCH(SumBlockImpl)(degree, local, cotangents, count, sums);
}

void SumSlopeBlock(const std::array<int, 3>& degree, const BlockVec& local,
                   const BlockSlopes& cotangents, size_t count, BoxNumbers& sums) {
  HWY_DYNAMIC_DISPATCH(SumSlopeBlockImpl)(degree, local, cotangents, count, sums);
}

}  // namespace latticed::points
#endif  // HWY_ONCE
