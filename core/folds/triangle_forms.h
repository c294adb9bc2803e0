// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Polynomials on a triangle whose products are plain: coefficients of b0^i b1^j b2^k, those of Bernstein times the multinomial
// M(i, j, k) = (i + j + k)! / (i! j! k!).
//
// A box in Bernstein form (bezier_box.h) has at a triangle's corners p_0, p_1, p_2 the coefficients
//   c_A M(A) = sum over A_u + A_v + A_w = A of M(A_u) M(A_v) M(A_w) g(A_u, A_v, A_w)
// with g the polar form, |A_a| the degree of axis a, and A_a its corners as often as they are arguments. All weights are
// positive where the corners are in the box.                                             Ramshaw 1989, blossoming
//
// Threads  plain data and pure functions
#ifndef LATTICED_CORE_FOLDS_TRIANGLE_FORMS_H_
#define LATTICED_CORE_FOLDS_TRIANGLE_FORMS_H_

#include <array>
#include <cstddef>
#include <vector>

#include "core/base/vec.h"
#include "core/ffd/box/bezier_box.h"
#include "core/folds/bernstein_triangle.h"

namespace latticed {

// M(i, j, k), i + j + k at most BernsteinTriangle::kMostDegree.
[[nodiscard]] double Multinomial(size_t i, size_t j, size_t k);

// Coefficients of b0^i b1^j b2^k: those of Bernstein times the multinomial.
class TriangleForm {
 public:
  explicit TriangleForm(size_t degree) : degree_(degree), terms_((degree + 1) * (degree + 1)) {}
  size_t degree() const { return degree_; }
  double& at(size_t i, size_t j) { return terms_[i * (degree_ + 1) + j]; }
  double at(size_t i, size_t j) const { return terms_[i * (degree_ + 1) + j]; }

  // this += sign a b. The degree is the sum of theirs.
  void AddProduct(const TriangleForm& a, const TriangleForm& b, double sign);

 private:
  size_t degree_;
  std::vector<double> terms_;
};
// The linear form with these values at the corners.
[[nodiscard]] TriangleForm LinearForm(const std::array<double, 3>& corners);

using VectorForm = std::array<TriangleForm, 3>;  // by component
[[nodiscard]] VectorForm MakeVectorForm(size_t degree);

// Three corners of a triangle in a box: [axis][corner], 0 to 1.
using TriangleInBox = std::array<std::array<double, 3>, 3>;
// The box's polynomial on the triangle. Its degree is the sum of those of the axes.
[[nodiscard]] VectorForm Compose(const BezierBox& box, const TriangleInBox& corners);

// Sets `determinant` to that of the columns, which have one degree, divided by `divisor`.
void SetDeterminant(const std::array<VectorForm, 3>& column, double divisor,
                    BernsteinTriangle& determinant);

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_TRIANGLE_FORMS_H_
