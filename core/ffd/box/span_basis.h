// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The basis functions of one knot span as powers of a local coordinate, by Cox and de Boor's recurrence on polynomials.
//
//   N_{span - degree + r} = sum_k basis[r][k] l^k,   l = (u - centre of the span) / width
//
// Errors   none: the span is not empty, the knots are valid
// Threads  pure function
#ifndef LATTICED_CORE_FFD_BOX_SPAN_BASIS_H_
#define LATTICED_CORE_FFD_BOX_SPAN_BASIS_H_

#include <array>
#include <span>

#include "core/base/limits.h"

namespace latticed {

// Zero beyond the degree.
using SpanBasis = std::array<std::array<double, limits::kMaxDegree + 1>, limits::kMaxDegree + 1>;

[[nodiscard]] SpanBasis MakeSpanBasis(std::span<const double> knots, int degree, int span);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_BOX_SPAN_BASIS_H_
