// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A non-owning column-major matrix in host memory: element (r, c) is data[r + c * stride].
#ifndef LATTICED_CORE_BASE_MATRIX_VIEW_H_
#define LATTICED_CORE_BASE_MATRIX_VIEW_H_

#include <cstddef>

#include "absl/status/status.h"
#include "fmt/format.h"

namespace latticed {

template <typename T>
struct MatrixView {
  T* data = nullptr;
  size_t rows = 0;
  size_t columns = 0;
  size_t stride = 0;  // elements from one column to the next; >= rows

  T& operator()(size_t row, size_t column) const { return data[row + column * stride]; }
  // Implicit, as from a span of T to one of const T.
  // NOLINTNEXTLINE(google-explicit-constructor)
  operator MatrixView<const T>() const { return {data, rows, columns, stride}; }
};

// kInternal, with the shapes, where c = a b does not fit. Also for matrices of other memory.
template <typename A, typename C>
absl::Status CheckProduct(const A& a, const A& b, const C& c) {
  if (a.columns == b.rows && a.rows == c.rows && b.columns == c.columns && a.stride >= a.rows &&
      b.stride >= b.rows && c.stride >= c.rows) {
    return absl::OkStatus();
  }
  return absl::InternalError(fmt::format(
      "shapes of a product must fit: ({} x {}, stride {}) * ({} x {}, stride {}) -> "
      "({} x {}, stride {})",
      a.rows, a.columns, a.stride, b.rows, b.columns, b.stride, c.rows, c.columns, c.stride));
}

}  // namespace latticed

#endif  // LATTICED_CORE_BASE_MATRIX_VIEW_H_
