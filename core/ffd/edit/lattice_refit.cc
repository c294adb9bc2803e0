// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/edit/lattice_refit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/limits.h"
#include "core/ffd/bspline_basis.h"

namespace latticed {
namespace {

// Functions that overlap have indices at most so far apart.
constexpr int kBand = limits::kMaxDegree;
constexpr double kSameKnot = 1e-12;  // of the domain
constexpr double kPivot = 1e-15;     // of the largest: smaller ones are rounding errors
// Gauss-Legendre on [-1, 1], exact to degree 7; products of two functions have degree 6 at most.
constexpr std::array kNodes{-0.86113631159405258, -0.33998104358485626, 0.33998104358485626,
                            0.86113631159405258};
constexpr std::array kWeights{0.34785484513745386, 0.65214515486254614, 0.65214515486254614,
                              0.34785484513745386};

// One axis of a lattice, with the domain mapped to [0, 1].
struct Axis {
  Axis(const LatticeStructure& structure, size_t axis)
      : degree(structure.degree[axis]), size(structure.size[axis]), knots(structure.knots[axis]) {
    const double begin = structure.domain_begin(static_cast<int>(axis));
    const double length = structure.domain_end(static_cast<int>(axis)) - begin;
    for (double& knot : knots) knot = (knot - begin) / length;
  }
  int degree, size;
  std::vector<double> knots;
};

// The functions that are not zero at one place, and their values.
struct BasisAt {
  size_t first = 0, count = 0;
  std::array<double, kBand + 1> values{};
};

// `places` ascend.
std::vector<BasisAt> BasisRows(const Axis& axis, const std::vector<double>& places) {
  std::vector<BasisAt> rows(places.size());
  int span = FindLowerSpan(axis.knots.data(), axis.degree, axis.size, places[0]);
  for (size_t n = 0; n < places.size(); ++n) {
    while (span + 1 < axis.size && axis.knots[static_cast<size_t>(span) + 1] < places[n]) ++span;
    rows[n].first = static_cast<size_t>(span - axis.degree);
    rows[n].count = static_cast<size_t>(axis.degree) + 1;
    EvaluateBasis(axis.knots.data(), axis.degree, span, places[n], rows[n].values.data());
  }
  return rows;
}

// The knots of both in [0, 1], each once, ascending.
std::vector<double> Breakpoints(const Axis& a, const Axis& b) {
  std::vector<double> all;
  for (const Axis* axis : {&a, &b}) {
    std::copy_if(axis->knots.begin(), axis->knots.end(), std::back_inserter(all),
                 [](double knot) { return knot > kSameKnot && knot < 1 - kSameKnot; });
  }
  all.push_back(0);
  std::sort(all.begin(), all.end());
  const auto same = [](double x, double y) { return y - x <= kSameKnot; };
  all.erase(std::unique(all.begin(), all.end(), same), all.end());
  all.push_back(1);
  return all;
}

// Vectors on a grid, index = i + size[0] (j + size[1] k).
struct Grid {
  std::array<size_t, 3> size{};
  std::vector<Vec3d> values;
};

// Replaces each line of the grid along `axis` by line(in, in's stride, out, out's stride), of `size` vectors.
template <typename Line>
Grid AlongAxis(const Grid& grid, size_t axis, size_t size, const Line& line) {
  Grid out{.size = grid.size};
  out.size[axis] = size;
  out.values.resize(out.size[0] * out.size[1] * out.size[2]);
  size_t stride = 1;
  for (size_t a = 0; a < axis; ++a) stride *= grid.size[a];
  const size_t blocks = grid.values.size() / (stride * grid.size[axis]);
  for (size_t block = 0; block < blocks; ++block) {
    for (size_t n = 0; n < stride; ++n) {
      line(&grid.values[block * stride * grid.size[axis] + n],
           &out.values[block * stride * size + n], stride);
    }
  }
  return out;
}

Vec3d At(const BasisAt& row, const Vec3d* line, size_t stride) {
  Vec3d sum;
  for (size_t r = 0; r < row.count; ++r) {
    sum += row.values[r] * line[(row.first + r) * stride];
  }
  return sum;
}

// The L2 projection along one axis.
class AxisProjection {
 public:
  AxisProjection(const Axis& from, const Axis& to) : size_(static_cast<size_t>(to.size)) {
    const std::vector<double> breakpoints = Breakpoints(from, to);
    std::vector<double> places;
    for (size_t n = 0; n + 1 < breakpoints.size(); ++n) {
      const double half = (breakpoints[n + 1] - breakpoints[n]) / 2;
      for (size_t g = 0; g < kNodes.size(); ++g) {
        places.push_back(breakpoints[n] + half * (1 + kNodes[g]));
        weights_.push_back(half * kWeights[g]);
      }
    }
    from_ = BasisRows(from, places);
    to_ = BasisRows(to, places);
    FactorMass();
  }

  Grid Apply(const Grid& grid, size_t axis) const {
    return AlongAxis(grid, axis, size_, [&](const Vec3d* in, Vec3d* out, size_t stride) {
      for (size_t n = 0; n < weights_.size(); ++n) {
        const Vec3d weighted = weights_[n] * At(from_[n], in, stride);
        for (size_t r = 0; r < to_[n].count; ++r) {
          out[(to_[n].first + r) * stride] += to_[n].values[r] * weighted;
        }
      }
      Solve(out, stride);
    });
  }

 private:
  // Cholesky's factor of the mass matrix: factor_[i][d] is its entry (i, i - d). A control point that has no effect in
  // the domain has a pivot of zero and a right-hand side of zero: with a pivot above zero it stays at rest.
  void FactorMass() {
    factor_.resize(size_);
    for (size_t n = 0; n < weights_.size(); ++n) {
      const auto& [first, count, values] = to_[n];
      for (size_t r = 0; r < count; ++r) {
        for (size_t d = 0; d <= r; ++d) {
          factor_[first + r][d] += weights_[n] * values[r] * values[r - d];
        }
      }
    }
    double largest = 0;
    for (const auto& row : factor_) largest = std::max(largest, row[0]);
    for (size_t i = 0; i < size_; ++i) {
      for (size_t d = std::min<size_t>(kBand, i) + 1; d-- > 0;) {
        double& entry = factor_[i][d];
        for (size_t e = d + 1; e <= std::min<size_t>(kBand, i); ++e) {
          entry -= factor_[i][e] * factor_[i - d][e - d];
        }
        entry = d > 0 ? entry / factor_[i - d][0] : std::sqrt(std::max(entry, kPivot * largest));
      }
    }
  }

  void Solve(Vec3d* x, size_t stride) const {
    for (size_t i = 0; i < size_; ++i) {
      for (size_t d = 1; d <= std::min<size_t>(kBand, i); ++d) {
        x[i * stride] = x[i * stride] - factor_[i][d] * x[(i - d) * stride];
      }
      x[i * stride] = x[i * stride] / factor_[i][0];
    }
    for (size_t i = size_; i-- > 0;) {
      x[i * stride] = x[i * stride] / factor_[i][0];
      for (size_t d = 1; d <= std::min<size_t>(kBand, i); ++d) {
        x[(i - d) * stride] = x[(i - d) * stride] - factor_[i][d] * x[i * stride];
      }
    }
  }

  size_t size_;
  std::vector<double> weights_;
  std::vector<BasisAt> from_, to_;  // at the nodes of the integral
  std::vector<std::array<double, kBand + 1>> factor_;
};

Grid Displacements(const Lattice& lattice) {
  const auto& size = lattice.structure.size;
  Grid grid{
      {static_cast<size_t>(size[0]), static_cast<size_t>(size[1]), static_cast<size_t>(size[2])},
      lattice.control_points};
  const std::vector<Vec3d> rest = IdentityControlPoints(lattice.structure);
  for (size_t n = 0; n < rest.size(); ++n) grid.values[n] = grid.values[n] - rest[n];
  return grid;
}

// The knots of both and the places half-way between them.
std::vector<double> ResidualPlaces(const Axis& a, const Axis& b) {
  const std::vector<double> breakpoints = Breakpoints(a, b);
  std::vector<double> places{0};
  for (size_t n = 0; n + 1 < breakpoints.size(); ++n) {
    places.push_back((breakpoints[n] + breakpoints[n + 1]) / 2);
    places.push_back(breakpoints[n + 1]);
  }
  return places;
}

// Leaves every n-th place of each axis, for the smallest n with which they are few enough.
void Thin(std::array<std::vector<double>, 3>& places) {
  const auto left = [&](size_t nth) {
    size_t product = 1;
    for (const auto& axis : places) product *= (axis.size() + nth - 1) / nth;
    return product;
  };
  size_t nth = 1;
  while (left(nth) > kMostResidualPlaces) ++nth;
  for (auto& axis : places) {
    size_t kept = 0;
    for (size_t n = 0; n < axis.size(); n += nth) axis[kept++] = axis[n];
    axis.resize(kept);
  }
}

Vec3d At(const Grid& grid, const BasisAt& u, const BasisAt& v, const BasisAt& w) {
  Vec3d sum;
  for (size_t k = 0; k < w.count; ++k) {
    for (size_t j = 0; j < v.count; ++j) {
      const size_t row = grid.size[0] * (v.first + j + grid.size[1] * (w.first + k));
      sum += w.values[k] * v.values[j] * At(u, &grid.values[row], 1);
    }
  }
  return sum;
}

double LargestDifference(const Grid& a, const Grid& b, const LatticeStructure& of_a,
                         const LatticeStructure& of_b) {
  std::array<std::vector<double>, 3> places;
  for (size_t axis = 0; axis < 3; ++axis) {
    places[axis] = ResidualPlaces(Axis(of_a, axis), Axis(of_b, axis));
  }
  Thin(places);
  std::array<std::vector<BasisAt>, 3> rows_a, rows_b;
  for (size_t axis = 0; axis < 3; ++axis) {
    rows_a[axis] = BasisRows(Axis(of_a, axis), places[axis]);
    rows_b[axis] = BasisRows(Axis(of_b, axis), places[axis]);
  }
  double largest = 0;
  for (size_t k = 0; k < places[2].size(); ++k) {
    for (size_t j = 0; j < places[1].size(); ++j) {
      for (size_t i = 0; i < places[0].size(); ++i) {
        const Vec3d difference = At(a, rows_a[0][i], rows_a[1][j], rows_a[2][k]) -
                                 At(b, rows_b[0][i], rows_b[1][j], rows_b[2][k]);
        largest = std::max(largest, Norm(difference));
      }
    }
  }
  return largest;
}

// The axes that shrink come first, so that no grid in between is larger than both ends.
std::array<size_t, 3> AxesByGrowth(const LatticeStructure& from, const LatticeStructure& to) {
  std::array<size_t, 3> axes{0, 1, 2};
  std::ranges::sort(axes, {}, [&](size_t axis) {
    return static_cast<double>(to.size[axis]) / static_cast<double>(from.size[axis]);
  });
  return axes;
}

}  // namespace

LatticeRefit Refit(const Lattice& lattice, const LatticeStructure& structure) {
  const Grid given = Displacements(lattice);
  Grid fitted = given;
  for (const size_t axis : AxesByGrowth(lattice.structure, structure)) {
    const AxisProjection projection(Axis(lattice.structure, axis), Axis(structure, axis));
    fitted = projection.Apply(fitted, axis);
  }
  LatticeRefit refit{.lattice = {structure, IdentityControlPoints(structure)}};
  for (size_t n = 0; n < fitted.values.size(); ++n) {
    refit.lattice.control_points[n] += fitted.values[n];
  }
  refit.residual = LargestDifference(given, fitted, lattice.structure, structure);
  return refit;
}

}  // namespace latticed
