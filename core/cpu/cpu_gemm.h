// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// C = A B on OpenBLAS: the only file that calls it.
//
//   A: rows x inner    B: inner x columns    C: rows x columns    all column-major
//
// OpenBLAS is kept to one thread inside; ours come from oneTBB around it. It chooses its kernels
// once, when the library is loaded, from OPENBLAS_CORETYPE or the processor: version 0.3.21 (Debian
// 12) takes processors that it does not know for a Prescott, three to five times slower. A program
// that cares asks BetterBlasCoreType() at start, sets OPENBLAS_CORETYPE to it and executes itself
// again.
//
// Errors   kInternal for shapes that do not fit, naming them
// Threads  safe from any thread; synchronous
#ifndef LATTICED_CORE_CPU_CPU_GEMM_H_
#define LATTICED_CORE_CPU_CPU_GEMM_H_

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "core/base/matrix_view.h"

namespace latticed {

[[nodiscard]] absl::Status CpuGemm(MatrixView<const float> a, MatrixView<const float> b,
                                   MatrixView<float> c);
[[nodiscard]] absl::Status CpuGemm(MatrixView<const double> a, MatrixView<const double> b,
                                   MatrixView<double> c);

// The kernels that OpenBLAS chose: "SkylakeX", "Haswell", "Prescott", …
[[nodiscard]] std::string CpuBlasCoreName();

// The value of OPENBLAS_CORETYPE that this processor deserves when `core_name` has no AVX2 kernels
// and the processor does; empty when there is nothing to gain.
[[nodiscard]] std::string_view BetterBlasCoreType(std::string_view core_name);

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_CPU_GEMM_H_
