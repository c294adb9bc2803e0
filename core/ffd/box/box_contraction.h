// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The linear map from the control points that reach a knot box to the coefficients of its polynomial, and its transpose.
//
//   contracted   C_pqr  = sum_ijk A[i][p] B[j][q] D[k][r] (P_ijk - origin)      A, B, D: span_basis.h of u, v, w
//   transposed   T_ijk  = sum_pqr A[i][p] B[j][q] D[k][r] S_pqr
//
// If S are the sums of l^p m^q n^r g over some points, T is the derivative by P of the sum of g . R over them.
// Each step replaces one index, so a cubic box takes some 2,300 multiply-adds.
//
// Units    those of the control points
// Errors   none: the spans are not empty
// Threads  immutable; the structure and the bases must outlive it
#ifndef LATTICED_CORE_FFD_BOX_BOX_CONTRACTION_H_
#define LATTICED_CORE_FFD_BOX_BOX_CONTRACTION_H_

#include <array>
#include <cstddef>
#include <span>

#include "core/base/vec.h"
#include "core/ffd/box/box_polynomial.h"
#include "core/ffd/box/span_basis.h"
#include "core/ffd/lattice.h"

namespace latticed {

// Vectors for the control points i, j, k of a box. Zero beyond the degree.
struct BoxVectors {
  Vec3d at[kPowers][kPowers][kPowers];
};

class BoxContraction {
 public:
  // `basis`: MakeSpanBasis of `span` on each axis.
  BoxContraction(const LatticeStructure& structure, const std::array<int, 3>& span,
                 const std::array<const SpanBasis*, 3>& basis);

  // The number of control point 0, 0, 0 of the box in the lattice.
  size_t first() const { return first_; }
  [[nodiscard]] BoxNumbers Contract(std::span<const Vec3d> points, Vec3d origin) const;
  [[nodiscard]] BoxVectors Transpose(const BoxNumbers& sums) const;
  // The same, added to add(number of the control point), which returns a Vec3d&.
  template <class Add>
  void AddTransposed(const BoxNumbers& sums, const Add& add) const {
    const BoxVectors vectors = Transpose(sums);
    for (size_t k = 0; k < count_[2]; ++k) {
      for (size_t j = 0; j < count_[1]; ++j) {
        for (size_t i = 0; i < count_[0]; ++i) add(Number(i, j, k)) += vectors.at[i][j][k];
      }
    }
  }

 private:
  size_t Number(size_t i, size_t j, size_t k) const { return first_ + i + row_ * j + layer_ * k; }

  const std::array<size_t, 3> count_;  // degree + 1
  const std::array<const SpanBasis*, 3> basis_;
  const size_t first_, row_, layer_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_BOX_BOX_CONTRACTION_H_
