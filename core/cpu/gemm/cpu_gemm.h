// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// C = A B on OpenBLAS: the only file that calls it.
//
//   A: rows x inner    B: inner x columns    C: rows x columns    all column-major
//
// OpenBLAS is loaded by the first call, and runs on the calling thread only; oneTBB makes the threads
// around it. OpenBLAS chooses its kernels when it is loaded, from OPENBLAS_CORETYPE or the processor.
// Version 0.3.21 (Debian 12) takes unknown processors for a Prescott, which is three to five times
// slower, so this file sets OPENBLAS_CORETYPE before main unless the user has set it.
//
// Errors   kInternal for shapes that do not fit, naming them; kUnavailable without OpenBLAS
// Threads  safe from any thread; synchronous
#ifndef LATTICED_CORE_CPU_GEMM_CPU_GEMM_H_
#define LATTICED_CORE_CPU_GEMM_CPU_GEMM_H_

#include <string>

#include "absl/status/status.h"
#include "core/base/matrix_view.h"

namespace latticed {

[[nodiscard]] absl::Status CpuGemm(MatrixView<const float> a, MatrixView<const float> b,
                                   MatrixView<float> c);
[[nodiscard]] absl::Status CpuGemm(MatrixView<const double> a, MatrixView<const double> b,
                                   MatrixView<double> c);

// The kernels that OpenBLAS chose: "SkylakeX", "Haswell", "Prescott", …; "missing" without OpenBLAS
[[nodiscard]] std::string CpuBlasCoreName();
// Version, settings of its build and kernels: "OpenBLAS 0.3.21 DYNAMIC_ARCH NO_AFFINITY Haswell MAX_THREADS=64"
[[nodiscard]] std::string CpuBlasVersion();

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_GEMM_CPU_GEMM_H_
