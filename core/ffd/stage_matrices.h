// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Stage matrices of accurate FFD.
//                    Cui & Feng 2014, doi:10.1007/s11766-014-3239-6, formulas (4), (9), (24)
//
//   stack = [Bq; Bqu; Bqv] * inv(B)     inv(B): m x m    Bq, Bqu, Bqv: q x m    stack: 3q x m
//
//   m = (n+1)(n+2)/2   q = (s+1)(s+2)/2   n = 3..10   s = segments per edge
// Degree   nu+nv+nw, 3..9, and one more with vertex weights
// Samples  the m uniform barycentric points (i,j,k)/n, in the order of bernstein.h
// Layout   column-major, computed in double; rows of a block in pattern order. The matrices in double are kept for
//          products in which float is too coarse: inv(B) has entries up to 1,130 at n = 10.
// Units    none: barycentric weights; each row of Bq*inv(B) sums to 1, of Bqu*inv(B) to 0
// Errors   kInvalidArgument for n beyond 3..10, and when s leaves limits::kSegments…
// Threads  Get is safe from any thread; matrices are immutable and live until the process ends
#ifndef LATTICED_CORE_FFD_STAGE_MATRICES_H_
#define LATTICED_CORE_FFD_STAGE_MATRICES_H_

#include <array>
#include <cstddef>
#include <vector>

#include "absl/status/statusor.h"

namespace latticed {

struct StageMatrices {
  int degree = 0;    // n
  int segments = 0;  // s
  size_t m = 0;
  size_t q = 0;
  // The m sample points, integers that sum to n; also the index triples of the control net.
  std::vector<std::array<int, 3>> samples;
  std::vector<double> inverse;     // inv(B), m x m
  std::vector<double> bernstein;   // [Bq; Bqu; Bqv], 3q x m
  std::vector<float> bernstein_f;  // the same, rounded
  std::vector<float> stack;        // 3q x m, rounded once from the product in double

  size_t MemoryBytes() const;

  // Made on first use, then shared.
  [[nodiscard]] static absl::StatusOr<const StageMatrices*> Get(int degree, int segments);
};

// inv(B) alone, m x m, column-major. degree in 3 … 10.
[[nodiscard]] std::vector<double> InverseBernsteinMatrix(int degree);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_STAGE_MATRICES_H_
