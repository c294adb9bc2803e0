// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/measure/box_integral_kernel.cc"
#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL)
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target, as Highway asks.
#include <algorithm>

#include "core/measure/box_integral_kernel.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::box_integral {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Four powers of the last axis, in one vector or two.
constexpr size_t kPowers = 4;
using D = hn::CappedTag<double, kPowers>;
using V = hn::Vec<D>;

// product += sign x y. A factor is the derivative by one axis, where it has one power less.
HWY_INLINE void AddProduct(const Narrow& x, size_t x_axis, const Narrow& y, size_t y_axis,
                           double sign, const std::array<size_t, 3>& degree, Wide& product) {
  const D d;
  const size_t lanes = hn::Lanes(d);
  for (size_t a = 0; a < degree[0] + (x_axis != 0); ++a) {
    for (size_t b = 0; b < degree[1] + (x_axis != 1); ++b) {
      for (size_t c = 0; c < degree[2] + (x_axis != 2); ++c) {
        const V factor = hn::Set(d, sign * x[NarrowTerm(a, b, c)]);
        for (size_t p = 0; p < degree[0] + (y_axis != 0); ++p) {
          for (size_t q = 0; q < degree[1] + (y_axis != 1); ++q) {
            const double* from = y.data() + NarrowTerm(p, q, 0);
            double* to = product.data() + WideTerm(a + p, b + q, c);
            for (size_t i = 0; i < kPowers; i += lanes) {
              hn::StoreU(hn::MulAdd(factor, hn::LoadU(d, from + i), hn::LoadU(d, to + i)), d,
                         to + i);
            }
          }
        }
      }
    }
  }
}

using Slopes = std::array<std::array<Narrow, 3>, 3>;  // [component][axis]
HWY_INLINE void FindSlopes(const std::array<Narrow, 3>& f, Slopes& slope) {
  for (size_t k = 0; k < 3; ++k) {
    for (size_t a = 0; a < kSide; ++a) {
      for (size_t b = 0; b < kSide; ++b) {
        for (size_t c = 0; c < kSide; ++c) {
          const double term = f[k][NarrowTerm(a, b, c)];
          if (a > 0) slope[k][0][NarrowTerm(a - 1, b, c)] = static_cast<double>(a) * term;
          if (b > 0) slope[k][1][NarrowTerm(a, b - 1, c)] = static_cast<double>(b) * term;
          if (c > 0) slope[k][2][NarrowTerm(a, b, c - 1)] = static_cast<double>(c) * term;
        }
      }
    }
  }
}

void MultiplySlopesImpl(const std::array<Narrow, 3>& f, const std::array<size_t, 3>& degree,
                        CrossProducts& cross) {
  Slopes slope{};
  FindSlopes(f, slope);
  for (size_t d = 0; d < 3; ++d) {
    const size_t e = (d + 1) % 3, g = (d + 2) % 3;
    for (size_t k = 0; k < 3; ++k) {
      const auto &y = slope[(k + 1) % 3], &z = slope[(k + 2) % 3];
      AddProduct(y[e], e, z[g], g, 1, degree, cross[d][k]);
      AddProduct(y[g], g, z[e], e, -1, degree, cross[d][k]);
    }
  }
}

void MultiplyOffsetsImpl(const std::array<Narrow, 3>& f, const std::array<size_t, 3>& degree,
                         CrossProducts& offsets) {
  constexpr size_t kNoAxis = 3;
  Slopes slope{};
  FindSlopes(f, slope);
  for (size_t a = 0; a < 3; ++a) {
    for (size_t k = 0; k < 3; ++k) {
      const size_t y = (k + 1) % 3, z = (k + 2) % 3;
      AddProduct(slope[y][a], a, f[z], kNoAxis, 1, degree, offsets[a][k]);
      AddProduct(slope[z][a], a, f[y], kNoAxis, -1, degree, offsets[a][k]);
    }
  }
}

// Sums for kRows powers q, q + 1, … of the middle axis: each value of `cross` is loaded once for all of them.
template <size_t kRows>
HWY_INLINE void SumRows(const CrossProducts& cross, const Powers& powers, const Moments& moments,
                        size_t p, size_t q, size_t r, std::array<Wide, 3>& sums) {
  const D d;
  const auto& extent = moments.extent;
  V sum[3][kRows];
  for (auto& component : sum) {
    for (V& row : component) row = hn::Zero(d);
  }
  for (size_t axis = 0; axis < 3; ++axis) {
    const double* table = moments.table[axis] + (p * extent[1] + q) * extent[2] + r;
    for (size_t a = 0; a < powers[axis][0]; ++a) {
      for (size_t b = 0; b < powers[axis][1]; ++b) {
        const double* moment = table + (a * extent[1] + b) * extent[2];
        const size_t row = WideTerm(a, b, 0);
        for (size_t c = 0; c < powers[axis][2]; ++c) {
          const V x = hn::Set(d, cross[axis][0][row + c]), y = hn::Set(d, cross[axis][1][row + c]),
                  z = hn::Set(d, cross[axis][2][row + c]);
          for (size_t i = 0; i < kRows; ++i) {
            const V m = hn::LoadU(d, moment + i * extent[2] + c);
            sum[0][i] = hn::MulAdd(x, m, sum[0][i]);
            sum[1][i] = hn::MulAdd(y, m, sum[1][i]);
            sum[2][i] = hn::MulAdd(z, m, sum[2][i]);
          }
        }
      }
    }
  }
  for (size_t k = 0; k < 3; ++k) {
    for (size_t i = 0; i < kRows; ++i) {
      hn::StoreU(sum[k][i], d, sums[k].data() + WideTerm(p, q + i, r));
    }
  }
}

void SumMomentsImpl(const CrossProducts& cross, const Powers& powers, const Moments& moments,
                    const std::array<size_t, 3>& count, std::array<Wide, 3>& sums) {
  constexpr size_t kMostRows = 4;
  const size_t lanes = hn::Lanes(D());
  for (size_t p = 0; p < count[0]; ++p) {
    for (size_t r = 0; r < count[2]; r += lanes) {
      for (size_t q = 0; q < count[1]; q += kMostRows) {
        switch (std::min(kMostRows, count[1] - q)) {
          case 1:
            SumRows<1>(cross, powers, moments, p, q, r, sums);
            break;
          case 2:
            SumRows<2>(cross, powers, moments, p, q, r, sums);
            break;
          case 3:
            SumRows<3>(cross, powers, moments, p, q, r, sums);
            break;
          default:
            SumRows<kMostRows>(cross, powers, moments, p, q, r, sums);
        }
      }
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::box_integral
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace latticed::box_integral {

HWY_EXPORT(MultiplySlopesImpl);
HWY_EXPORT(MultiplyOffsetsImpl);
HWY_EXPORT(SumMomentsImpl);

void MultiplySlopes(const std::array<Narrow, 3>& f, const std::array<size_t, 3>& degree,
                    CrossProducts& cross) {
  HWY_DYNAMIC_DISPATCH(MultiplySlopesImpl)(f, degree, cross);
}

void MultiplyOffsets(const std::array<Narrow, 3>& f, const std::array<size_t, 3>& degree,
                     CrossProducts& offsets) {
  HWY_DYNAMIC_DISPATCH(MultiplyOffsetsImpl)(f, degree, offsets);
}

Powers CrossPowers(const std::array<size_t, 3>& degree) {
  Powers powers;
  for (size_t d = 0; d < 3; ++d) {
    for (size_t a = 0; a < 3; ++a) powers[d][a] = 2 * degree[a] + (d == a ? 1 : 0);
  }
  return powers;
}

void SumMoments(const CrossProducts& cross, const Powers& powers, const Moments& moments,
                const std::array<size_t, 3>& count, std::array<Wide, 3>& sums) {
  HWY_DYNAMIC_DISPATCH(SumMomentsImpl)(cross, powers, moments, count, sums);
}

}  // namespace latticed::box_integral
#endif  // HWY_ONCE
