// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The smallest least-squares solution of a sparse system with few equations: x = N^+ b.
//
//   N = W N1              N: k x columns, of any rank r; N1: r of its rows, independent
//                         W: k x r, the identity in those rows
//   N1 N1' = L L'         r x r
//   x = N1' (L L')^-1 W^+ b
//
// The rows of N1 are found by Cholesky's factorisation of N N' with pivoting. The next row is the
// one farthest from the span of those before, until none is farther than kDependence times the
// longest row. Nearer rows count as dependent: only an x about 1 / kDependence times as large as
// its effect could meet them. N N' squares the condition of N; two steps of refinement, with
// residuals of N itself, restore the digits.
//
// A library's rank-revealing factorisation of N, which is dense in memory then, costs
// 2 k^2 columns: for 1,024 rows and 32,768 columns a hundred times as much as k^3 / 3.
//
// Layout   factors row by row, double
// Errors   none
// Threads  immutable
#ifndef LATTICED_CORE_FFD_MINIMUM_NORM_H_
#define LATTICED_CORE_FFD_MINIMUM_NORM_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/vec.h"

namespace latticed {

// One equation: what is not zero, columns ascending. May be empty.
struct SparseRow {
  std::vector<uint32_t> columns;
  std::vector<double> values;
};

class MinimumNorm {
 public:
  static constexpr double kDependence = 1e-6;

  // Columns are below `columns`.
  MinimumNorm(std::vector<SparseRow> rows, size_t columns);

  size_t rank() const { return chosen_.size(); }
  // N^+ b for three right-hand sides at once: b has one entry a row, the result one a column.
  [[nodiscard]] std::vector<Vec3d> Solve(std::span<const Vec3d> b) const;
  // b - N x.
  [[nodiscard]] std::vector<Vec3d> Residual(std::span<const Vec3d> b,
                                            std::span<const Vec3d> x) const;

 private:
  double* FactorRow(size_t row) { return factor_.data() + row * stride_; }
  const double* FactorRow(size_t row) const { return factor_.data() + row * stride_; }
  void ChooseRows();
  void FactorDependence();
  std::vector<Vec3d> LeastSquares(std::span<const Vec3d> b) const;

  const std::vector<SparseRow> rows_;
  const size_t columns_;
  const size_t stride_;              // most that the rank can be
  std::vector<double> factor_;       // rows x stride: N = factor L^-1 N1; of chosen rows it is L
  std::vector<uint32_t> chosen_;     // rows of N1, in the order of L
  std::vector<uint32_t> dependent_;  // the others
  std::vector<double> w_;            // dependent rows x rank: W there
  std::vector<double> w_factor_;     // rank x rank, lower: Cholesky's of W'W; empty where W = I
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_MINIMUM_NORM_H_
