// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/stage_matrices.h"

#include <cmath>
#include <memory>
#include <mutex>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/box/bernstein.h"
#include "core/ffd/tessellation_pattern.h"

namespace latticed {
namespace {

constexpr int kMinPatchDegree = 3 * limits::kMinDegree;
constexpr int kMaxPatchDegree = 3 * limits::kMaxDegree + 1;  // with weights

std::vector<std::array<int, 3>> IndexTriples(int n) {
  std::vector<std::array<int, 3>> triples;
  for (int i = n; i >= 0; --i) {
    for (int j = n - i; j >= 0; --j) triples.push_back({i, j, n - i - j});
  }
  return triples;
}

// Gauss-Jordan with partial pivoting. Rows of |inv(B)| add up to at most 7,508, so double keeps 12 digits.
std::vector<double> Invert(std::vector<double> a, size_t m) {
  std::vector<double> inverse(m * m, 0.0);
  for (size_t i = 0; i < m; ++i) inverse[i + i * m] = 1.0;
  for (size_t c = 0; c < m; ++c) {
    size_t pivot = c;
    for (size_t r = c + 1; r < m; ++r) {
      if (std::abs(a[r + c * m]) > std::abs(a[pivot + c * m])) pivot = r;
    }
    const double scale = 1.0 / a[pivot + c * m];
    for (size_t k = 0; k < m; ++k) {
      std::swap(a[c + k * m], a[pivot + k * m]);
      std::swap(inverse[c + k * m], inverse[pivot + k * m]);
      a[c + k * m] *= scale;
      inverse[c + k * m] *= scale;
    }
    for (size_t r = 0; r < m; ++r) {
      const double factor = a[r + c * m];
      if (r == c || factor == 0.0) continue;
      for (size_t k = 0; k < m; ++k) {
        a[r + k * m] -= factor * a[c + k * m];
        inverse[r + k * m] -= factor * inverse[c + k * m];
      }
    }
  }
  return inverse;
}

std::vector<double> BernsteinStack(const std::vector<std::array<int, 3>>& triples, int segments) {
  const TessellationPattern& pattern = TessellationPattern::Get(segments);
  const size_t q = pattern.points.size();
  std::vector<double> stack(3 * q * triples.size());
  for (size_t c = 0; c < triples.size(); ++c) {
    const auto [i, j, k] = triples[c];
    double* column = stack.data() + c * 3 * q;
    for (size_t r = 0; r < q; ++r) {
      const auto& point = pattern.points[r];
      const double b0 = point[0] / static_cast<double>(segments);
      const double b1 = point[1] / static_cast<double>(segments);
      const double b2 = point[2] / static_cast<double>(segments);
      column[r] = Bernstein(i, j, k, b0, b1, b2);
      column[q + r] = BernsteinU(i, j, k, b0, b1, b2);
      column[2 * q + r] = BernsteinV(i, j, k, b0, b1, b2);
    }
  }
  return stack;
}

StageMatrices MakeMatrices(int n, int s) {
  StageMatrices result;
  result.degree = n;
  result.segments = s;
  result.m = static_cast<size_t>(BernsteinCount(n));
  result.q = static_cast<size_t>(PointsPerPatch(s));
  result.samples = IndexTriples(n);
  result.inverse = InverseBernsteinMatrix(n);
  result.bernstein = BernsteinStack(result.samples, s);
  result.bernstein_f.assign(result.bernstein.begin(), result.bernstein.end());
  const size_t rows = 3 * result.q, m = result.m;
  result.stack.resize(rows * m);
  std::vector<double> column(rows);
  for (size_t c = 0; c < m; ++c) {
    column.assign(rows, 0.0);
    for (size_t k = 0; k < m; ++k) {
      const double factor = result.inverse[k + c * m];
      for (size_t r = 0; r < rows; ++r) column[r] += result.bernstein[r + k * rows] * factor;
    }
    for (size_t r = 0; r < rows; ++r) {
      result.stack[r + c * rows] = static_cast<float>(column[r]);
    }
  }
  return result;
}

}  // namespace

std::vector<double> InverseBernsteinMatrix(int n) {
  const std::vector<std::array<int, 3>> triples = IndexTriples(n);
  const size_t m = triples.size();
  std::vector<double> b(m * m);
  for (size_t c = 0; c < m; ++c) {
    const auto [i, j, k] = triples[c];
    for (size_t r = 0; r < m; ++r) {
      const double over = 1.0 / n;
      b[r + c * m] =
          Bernstein(i, j, k, triples[r][0] * over, triples[r][1] * over, triples[r][2] * over);
    }
  }
  return Invert(std::move(b), m);
}

size_t StageMatrices::MemoryBytes() const {
  return sizeof(*this) + samples.size() * sizeof(samples[0]) +
         (inverse.size() + bernstein.size()) * sizeof(double) +
         (bernstein_f.size() + stack.size()) * sizeof(float);
}

absl::StatusOr<const StageMatrices*> StageMatrices::Get(int degree, int segments) {
  LATTICED_RETURN_IF_ERROR(
      error::CheckRange("lattice.degree", degree, kMinPatchDegree, kMaxPatchDegree));
  LATTICED_RETURN_IF_ERROR(
      error::CheckRange("view.segments", segments, limits::kMinSegments, limits::kMaxSegments));
  struct Entry {
    std::once_flag once;
    std::unique_ptr<const StageMatrices> matrices;
  };
  // Never destroyed: threads may still use it when the program ends.
  static auto& cache =
      *new std::array<std::array<Entry, limits::kMaxSegments + 1>, kMaxPatchDegree + 1>;
  Entry& entry = cache[static_cast<size_t>(degree)][static_cast<size_t>(segments)];
  std::call_once(entry.once, [&] {
    entry.matrices = std::make_unique<const StageMatrices>(MakeMatrices(degree, segments));
  });
  return entry.matrices.get();
}

}  // namespace latticed
