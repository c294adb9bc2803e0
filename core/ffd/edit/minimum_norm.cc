// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/edit/minimum_norm.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace latticed {
namespace {

constexpr int kRefinements = 2;

// Four independent sums, because each addition to a single one would wait for the one before.
double DotOf(const double* a, const double* b, size_t n) {
  double sum[4] = {};
  size_t i = 0;
  for (; i + 4 <= n; i += 4) {
    for (size_t lane = 0; lane < 4; ++lane) sum[lane] += a[i + lane] * b[i + lane];
  }
  for (; i < n; ++i) sum[0] += a[i] * b[i];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

double DotOf(const SparseRow& row, const std::vector<double>& dense) {
  double sum = 0;
  for (size_t n = 0; n < row.columns.size(); ++n) sum += row.values[n] * dense[row.columns[n]];
  return sum;
}

// x := L^-1 x, then x := L'^-1 x; row(j) is row j of the lower triangle L.
template <typename RowOf>
void SolveCholesky(const RowOf& row, std::vector<Vec3d>& x) {
  for (size_t j = 0; j < x.size(); ++j) {
    for (size_t i = 0; i < j; ++i) x[j] -= row(j)[i] * x[i];
    x[j] = x[j] / row(j)[j];
  }
  for (size_t j = x.size(); j-- > 0;) {
    x[j] = x[j] / row(j)[j];
    for (size_t i = 0; i < j; ++i) x[i] -= row(j)[i] * x[j];
  }
}

}  // namespace

MinimumNorm::MinimumNorm(std::vector<SparseRow> rows, size_t columns)
    : rows_(std::move(rows)),
      columns_(columns),
      stride_(std::min(rows_.size(), columns)),
      factor_(rows_.size() * stride_) {
  ChooseRows();
  FactorDependence();
}

void MinimumNorm::ChooseRows() {
  std::vector<double> distance2;  // of each row from the span of those chosen
  for (const SparseRow& row : rows_) {
    distance2.push_back(DotOf(row.values.data(), row.values.data(), row.values.size()));
  }
  const double longest2 = distance2.empty() ? 0 : *std::ranges::max_element(distance2);
  std::vector<bool> taken(rows_.size());
  std::vector<double> dense(columns_);
  while (chosen_.size() < stride_) {
    const auto farthest = std::ranges::max_element(distance2);
    if (!(*farthest > kDependence * kDependence * longest2)) break;
    const auto pivot = static_cast<size_t>(farthest - distance2.begin());
    const size_t rank = chosen_.size();
    const double length = std::sqrt(*farthest);
    const SparseRow& row = rows_[pivot];
    for (size_t n = 0; n < row.columns.size(); ++n) dense[row.columns[n]] = row.values[n];
    taken[pivot] = true;
    *farthest = 0;
    FactorRow(pivot)[rank] = length;
    for (size_t i = 0; i < rows_.size(); ++i) {
      if (taken[i]) continue;
      const double along =
          (DotOf(rows_[i], dense) - DotOf(FactorRow(i), FactorRow(pivot), rank)) / length;
      FactorRow(i)[rank] = along;
      distance2[i] = std::max(0.0, distance2[i] - along * along);
    }
    for (const uint32_t column : row.columns) dense[column] = 0;
    chosen_.push_back(static_cast<uint32_t>(pivot));
  }
  for (uint32_t i = 0; i < rows_.size(); ++i) {
    if (!taken[i]) dependent_.push_back(i);
  }
}

void MinimumNorm::FactorDependence() {
  if (dependent_.empty()) return;
  const size_t r = rank();
  for (const uint32_t i : dependent_) {  // solves w L = the row's factor
    std::vector<double> w(FactorRow(i), FactorRow(i) + r);
    for (size_t j = r; j-- > 0;) {
      const double* l = FactorRow(chosen_[j]);
      w[j] /= l[j];
      for (size_t m = 0; m < j; ++m) w[m] -= l[m] * w[j];
    }
    w_.insert(w_.end(), w.begin(), w.end());
  }
  w_factor_.assign(r * r, 0);
  for (size_t j = 0; j < r; ++j) w_factor_[j * r + j] = 1;
  for (size_t d = 0; d < dependent_.size(); ++d) {
    const double* w = w_.data() + d * r;
    for (size_t j = 0; j < r; ++j) {
      for (size_t m = 0; m <= j; ++m) w_factor_[j * r + m] += w[j] * w[m];
    }
  }
  for (size_t j = 0; j < r; ++j) {
    double* row = w_factor_.data() + j * r;
    for (size_t m = 0; m < j; ++m) {
      const double* other = w_factor_.data() + m * r;
      row[m] = (row[m] - DotOf(row, other, m)) / other[m];
    }
    row[j] = std::sqrt(row[j] - DotOf(row, row, j));  // W'W = I + …: at least 1 is left
  }
}

// W^+ b.
std::vector<Vec3d> MinimumNorm::LeastSquares(std::span<const Vec3d> b) const {
  const size_t r = rank();
  std::vector<Vec3d> z(r);
  for (size_t j = 0; j < r; ++j) z[j] = b[chosen_[j]];
  if (dependent_.empty()) return z;
  for (size_t d = 0; d < dependent_.size(); ++d) {
    for (size_t j = 0; j < r; ++j) z[j] += w_[d * r + j] * b[dependent_[d]];
  }
  SolveCholesky([this, r](size_t j) { return w_factor_.data() + j * r; }, z);
  return z;
}

std::vector<Vec3d> MinimumNorm::Solve(std::span<const Vec3d> b) const {
  std::vector<Vec3d> x(columns_);
  std::vector<Vec3d> left(b.begin(), b.end());
  for (int step = 0; step <= kRefinements; ++step) {
    std::vector<Vec3d> y = LeastSquares(left);
    SolveCholesky([this](size_t j) { return FactorRow(chosen_[j]); }, y);
    for (size_t j = 0; j < y.size(); ++j) {
      const SparseRow& row = rows_[chosen_[j]];
      for (size_t n = 0; n < row.columns.size(); ++n) x[row.columns[n]] += row.values[n] * y[j];
    }
    left = Residual(b, x);
  }
  return x;
}

std::vector<Vec3d> MinimumNorm::Residual(std::span<const Vec3d> b, std::span<const Vec3d> x) const {
  std::vector<Vec3d> left(b.begin(), b.end());
  for (size_t i = 0; i < rows_.size(); ++i) {
    for (size_t n = 0; n < rows_[i].columns.size(); ++n) {
      left[i] -= rows_[i].values[n] * x[rows_[i].columns[n]];
    }
  }
  return left;
}

}  // namespace latticed
