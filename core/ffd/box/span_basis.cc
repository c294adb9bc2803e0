// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/box/span_basis.h"

namespace latticed {

SpanBasis MakeSpanBasis(std::span<const double> knots, int degree, int span) {
  const auto knot = [&](int k) { return knots[static_cast<size_t>(k)]; };
  const double width = knot(span + 1) - knot(span), centre = 0.5 * (knot(span) + knot(span + 1));
  SpanBasis n{};
  n[0][0] = 1;
  for (int j = 1; j <= degree; ++j) {
    std::array<double, limits::kMaxDegree + 1> saved{};
    for (int r = 0; r < j; ++r) {
      const double low = knot(span + 1 - j + r), high = knot(span + r + 1);
      const auto row = static_cast<size_t>(r);
      const auto old = n[row];
      std::array<double, limits::kMaxDegree + 1> next{};
      for (size_t k = 0; k < old.size(); ++k) {
        const double term = old[k] / (high - low);
        n[row][k] =
            saved[k] + (high - centre) * term - (k > 0 ? width * old[k - 1] / (high - low) : 0);
        next[k] = (centre - low) * term + (k > 0 ? width * old[k - 1] / (high - low) : 0);
      }
      saved = next;
    }
    n[static_cast<size_t>(j)] = saved;
  }
  return n;
}

}  // namespace latticed
