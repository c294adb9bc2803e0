// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/tensor_tables.h"

#include <array>
#include <cmath>
#include <utility>

namespace latticed::bench {
namespace {

using Row = std::array<double, kTensorOrder>;
using Matrix = std::array<Row, kTensorOrder>;

// Of `degree`, at x; zero outside of 0 … degree.
double Bernstein(int degree, int index, double x) {
  if (index < 0 || index > degree) return 0;
  double binomial = 1;
  for (int k = 0; k < index; ++k) binomial = binomial * (degree - k) / (k + 1);
  return binomial * std::pow(x, index) * std::pow(1 - x, degree - index);
}

// Gauss-Jordan; the Bernstein matrix of distinct parameters is totally positive and needs no
// pivots.
Matrix Inverse(Matrix a) {
  Matrix inverse{};
  for (size_t i = 0; i < kTensorOrder; ++i) inverse[i][i] = 1;
  for (size_t c = 0; c < kTensorOrder; ++c) {
    const double scale = 1 / a[c][c];
    for (size_t k = 0; k < kTensorOrder; ++k) {
      a[c][k] *= scale;
      inverse[c][k] *= scale;
    }
    for (size_t r = 0; r < kTensorOrder; ++r) {
      const double factor = r == c ? 0 : a[r][c];
      for (size_t k = 0; k < kTensorOrder; ++k) {
        a[r][k] -= factor * a[c][k];
        inverse[r][k] -= factor * inverse[c][k];
      }
    }
  }
  return inverse;
}

}  // namespace

TensorTables MakeTensorTables(int segments) {
  TensorTables tables{};
  Matrix samples{};
  for (int i = 0; i < kTensorOrder; ++i) {
    for (int a = 0; a < kTensorOrder; ++a) {
      samples[static_cast<size_t>(i)][static_cast<size_t>(a)] =
          Bernstein(kTensorDegree, a, double{1} * i / kTensorDegree);
    }
  }
  const Matrix inverse = Inverse(samples);
  for (size_t i = 0; i < kTensorOrder; ++i) {
    for (size_t a = 0; a < kTensorOrder; ++a) {
      tables.inverse[i][a] = static_cast<float>(inverse[i][a]);
    }
  }
  for (int k = 0; k <= segments; ++k) {
    const double x = double{1} * k / segments;
    for (int a = 0; a < kTensorOrder; ++a) {
      const double slope =
          Bernstein(kTensorDegree - 1, a - 1, x) - Bernstein(kTensorDegree - 1, a, x);
      tables.value[k][a] = static_cast<float>(Bernstein(kTensorDegree, a, x));
      tables.slope[k][a] = static_cast<float>(kTensorDegree * slope);
    }
  }
  const auto& pattern = TessellationPattern::Get(segments).points;
  for (size_t i = 0; i < pattern.size(); ++i) {
    tables.column[i] = pattern[i][1];
    tables.row[i] = pattern[i][2];
  }
  return tables;
}

std::vector<TensorPatch> MakeTensorPatches(const DeformPlan& plan) {
  std::vector<TensorPatch> patches;
  patches.reserve(plan.patches.size());
  for (const Patch& patch : plan.patches) {
    const bool outside = patch.box == plan.outside_box();
    const auto corner = [&](size_t c) {
      const PlanVertex& vertex = plan.vertices[patch.vertex[c]];
      return outside ? vertex.world - plan.local_origin : vertex.parameter;
    };
    const auto& span = plan.boxes[patch.box].span;
    patches.push_back({{span[0], span[1], span[2]},
                       outside ? 1 : 0,
                       corner(0),
                       corner(1) - corner(0),
                       corner(2) - corner(0)});
  }
  return patches;
}

}  // namespace latticed::bench
