// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/cpu_gemm.h"

#include <cblas.h>

#include <mutex>

#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed {
namespace {

void UseOneThread() {
  static std::once_flag once;
  std::call_once(once, [] { openblas_set_num_threads(1); });
}

template <typename T>
absl::Status CheckShapes(MatrixView<const T> a, MatrixView<const T> b, MatrixView<T> c) {
  if (a.columns == b.rows && a.rows == c.rows && b.columns == c.columns && a.stride >= a.rows &&
      b.stride >= b.rows && c.stride >= c.rows) {
    return absl::OkStatus();
  }
  return absl::InternalError(fmt::format(
      "shapes of a product must fit: ({} x {}, stride {}) * ({} x {}, stride {}) -> "
      "({} x {}, stride {})",
      a.rows, a.columns, a.stride, b.rows, b.columns, b.stride, c.rows, c.columns, c.stride));
}

blasint Int(size_t n) { return static_cast<blasint>(n); }

}  // namespace

absl::Status CpuGemm(MatrixView<const float> a, MatrixView<const float> b, MatrixView<float> c) {
  LATTICED_RETURN_IF_ERROR(CheckShapes(a, b, c));
  UseOneThread();
  cblas_sgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, Int(c.rows), Int(c.columns),
              Int(a.columns), 1.0f, a.data, Int(a.stride), b.data, Int(b.stride), 0.0f, c.data,
              Int(c.stride));
  return absl::OkStatus();
}

absl::Status CpuGemm(MatrixView<const double> a, MatrixView<const double> b, MatrixView<double> c) {
  LATTICED_RETURN_IF_ERROR(CheckShapes(a, b, c));
  UseOneThread();
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, Int(c.rows), Int(c.columns),
              Int(a.columns), 1.0, a.data, Int(a.stride), b.data, Int(b.stride), 0.0, c.data,
              Int(c.stride));
  return absl::OkStatus();
}

std::string CpuBlasCoreName() { return openblas_get_corename(); }

}  // namespace latticed
