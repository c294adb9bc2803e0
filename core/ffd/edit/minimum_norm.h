// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The smallest of the least-squares solutions of a sparse system with few equations: x = N^+ b.
//
//   N = W N1              N: k x columns, of any rank r; N1: r of its rows, independent
//                         W: k x r, the identity in those rows
//   N1 N1' = L L'         r x r
//   x = N1' (L L')^-1 W^+ b
//
// The rows of N1 are found by Cholesky's factorisation of N N' with pivoting. The next row is the one farthest from the
// span of those chosen, until none is farther than kDependence times the longest row. The remaining rows count as
// dependent: to meet them exactly, x would have to be about 1 / kDependence times as large as its effect. N N' squares
// the condition of N; two steps of refinement, with residuals of N itself, restore the digits.
//
// A library's rank-revealing factorisation needs N as a dense matrix and costs 2 k^2 columns operations: for 1,024 rows
// and 32,768 columns about two hundred times as many as k^3 / 3.
//
// Layout   factors row by row, double
// Errors   none
// Threads  immutable
#ifndef LATTICED_CORE_FFD_EDIT_MINIMUM_NORM_H_
#define LATTICED_CORE_FFD_EDIT_MINIMUM_NORM_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/vec.h"

namespace latticed {

// One equation: its coefficients that are not zero, columns ascending. It may be empty.
struct SparseRow {
  std::vector<uint32_t> columns;
  std::vector<double> values;
};

class MinimumNorm {
 public:
  static constexpr double kDependence = 1e-6;

  // All columns in `rows` are below `columns`.
  MinimumNorm(std::vector<SparseRow> rows, size_t columns);

  size_t rank() const { return chosen_.size(); }
  // N^+ b for three right-hand sides at once: b has one entry per row, the result one per column.
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
  const size_t stride_;              // the largest possible rank
  std::vector<double> factor_;       // rows x stride: N = factor L^-1 N1; of chosen rows it is L
  std::vector<uint32_t> chosen_;     // rows of N1, in the order of L
  std::vector<uint32_t> dependent_;  // the others
  std::vector<double> w_;            // dependent rows x rank: their rows of W
  std::vector<double> w_factor_;     // rank x rank, lower: Cholesky's of W'W; empty where W = I
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_EDIT_MINIMUM_NORM_H_
