// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Makes OpenBLAS use this CPU's kernels. OpenBLAS 0.3.21 does not know CPUs newer than itself and
// falls back to SSE3 code, 3x slower (measured). It reads OPENBLAS_CORETYPE while it is loaded,
// before main, so the only cure is to set the variable and start the program anew.
//
// Call first in main. Does nothing where the variable is set already, or the CPU has no AVX2.
// Errors   none: where the program cannot be started again it goes on as it is
#ifndef LATTICED_CORE_BASE_BLAS_ENVIRONMENT_H_
#define LATTICED_CORE_BASE_BLAS_ENVIRONMENT_H_

#include <string_view>

namespace latticed {

// What OPENBLAS_CORETYPE should be here: "SKYLAKEX", "HASWELL", or empty for OpenBLAS' own choice.
[[nodiscard]] std::string_view BlasCoreType();

// Replaces the process by itself with OPENBLAS_CORETYPE set: same file, same arguments, same id.
void EnsureBlasEnvironment(char** argv);

}  // namespace latticed

#endif  // LATTICED_CORE_BASE_BLAS_ENVIRONMENT_H_
