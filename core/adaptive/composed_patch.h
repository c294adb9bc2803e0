// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A patch as one polynomial: that of its knot box, composed with the patch's affine map, by Horner's rule.
//
//   P(x, t) = sum_abc C_abc l_0^a l_1^b l_2^c,   l_i = map[i][0] + map[i][1] x + map[i][2] t
//
// This is the reference, in any number type and of any degree. Backends have faster forms of it, in the same order.
//
// Layout   coefficients as in BoxBasis::Polynomial; the term x^i t^j at (i + j)(i + j + 1) / 2 + j
// Threads  pure functions
#ifndef LATTICED_CORE_ADAPTIVE_COMPOSED_PATCH_H_
#define LATTICED_CORE_ADAPTIVE_COMPOSED_PATCH_H_

#include <array>

#include "core/base/limits.h"

namespace latticed {

inline constexpr int kMostPatchDegree = 3 * limits::kMaxDegree;
inline constexpr int kMostWeightedDegree = kMostPatchDegree + 1;  // of a patch with vertex weights

constexpr int PatchTerm(int i, int j) { return (i + j) * (i + j + 1) / 2 + j; }

template <typename T>
struct PatchPolynomial {
  static constexpr int kMostTerms = (kMostWeightedDegree + 1) * (kMostWeightedDegree + 2) / 2;
  T value[kMostTerms] = {};
  int degree = 0;

  // this = this * (l[0] + l[1] x + l[2] t)
  void MultiplyLinear(const T* l) {
    ++degree;
    for (int d = degree; d >= 0; --d) {  // from above, so that lower terms are still the old ones
      for (int j = 0; j <= d; ++j) {
        T sum = value[PatchTerm(d - j, j)] * l[0];
        if (j < d) sum += value[PatchTerm(d - j - 1, j)] * l[1];
        if (j > 0) sum += value[PatchTerm(d - j, j - 1)] * l[2];
        value[PatchTerm(d - j, j)] = sum;
      }
    }
  }
  void Add(const PatchPolynomial& other) {
    for (int k = 0; k < PatchTerm(0, other.degree) + 1; ++k) value[k] += other.value[k];
  }
};

// One component; c[k] is that of coefficient k.
template <typename T>
PatchPolynomial<T> ComposePatch(const T* c, const std::array<int, 3>& degree, const T map[3][3]) {
  PatchPolynomial<T> outer;
  for (int a = degree[0]; a >= 0; --a) {
    PatchPolynomial<T> middle;
    for (int b = degree[1]; b >= 0; --b) {
      PatchPolynomial<T> inner;
      for (int k = degree[2]; k >= 0; --k) {
        if (k < degree[2]) inner.MultiplyLinear(map[2]);
        inner.value[0] += c[(a * (degree[1] + 1) + b) * (degree[2] + 1) + k];
      }
      if (b < degree[1]) middle.MultiplyLinear(map[1]);
      middle.degree = middle.degree > inner.degree ? middle.degree : inner.degree;
      middle.Add(inner);
    }
    if (a < degree[0]) outer.MultiplyLinear(map[0]);
    outer.degree = outer.degree > middle.degree ? outer.degree : middle.degree;
    outer.Add(middle);
  }
  return outer;
}

}  // namespace latticed

#endif  // LATTICED_CORE_ADAPTIVE_COMPOSED_PATCH_H_
