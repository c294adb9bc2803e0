// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// cuBLAS, loaded when the first product asks for it: a program with the CUDA backend starts on
// machines without cuBLAS, and does not read its half gigabyte where no product is wanted.
//
// Errors   kUnavailable, reason NO_CUBLAS, where the library of the toolkit's major version is
//          neither on the loader's path nor in the toolkit's usual place
// Threads  safe; loaded once and never unloaded
#ifndef LATTICED_CUDA_DEVICE_CUDA_GEMM_LIBRARY_H_
#define LATTICED_CUDA_DEVICE_CUDA_GEMM_LIBRARY_H_

#include <cublas_v2.h>

#include "absl/status/statusor.h"

namespace latticed {

struct CublasLibrary {
  decltype(&::cublasCreate_v2) create = nullptr;
  decltype(&::cublasDestroy_v2) destroy = nullptr;
  decltype(&::cublasSetStream_v2) set_stream = nullptr;
  decltype(&::cublasSetWorkspace_v2) set_workspace = nullptr;
  decltype(&::cublasSetAtomicsMode) set_atomics_mode = nullptr;
  decltype(&::cublasSgemm_v2) sgemm = nullptr;
  decltype(&::cublasDgemm_v2) dgemm = nullptr;

  [[nodiscard]] static absl::StatusOr<const CublasLibrary*> Get();
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_CUDA_GEMM_LIBRARY_H_
