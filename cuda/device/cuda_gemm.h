// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The matrix product on one stream: the only place that calls cuBLAS. Twin of core/cpu/gemm/cpu_gemm.h.
//
//   c = a * b      a: c.rows x k    b: k x c.columns    column-major
//
// float32 products do not use TF32. The same shape gives the same bits on the same device: each stream has
// its own handle and workspace, and atomics are off.
//
// Errors   kInternal with the shapes where they do not match; those of cuda_status.h; kUnavailable, reason
//          NO_CUBLAS, where the library of the toolkit's major version is neither on the loader's path nor in
//          the toolkit's usual place
// Threads  one at a time; Multiply enqueues and does not wait
#ifndef LATTICED_CUDA_DEVICE_CUDA_GEMM_H_
#define LATTICED_CUDA_DEVICE_CUDA_GEMM_H_

#include <cublas_v2.h>

#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "cuda/device/device_buffer.h"
#include "cuda/device/device_span.h"

namespace latticed {

// cuBLAS, loaded at its first use and never unloaded. A program with the CUDA backend thus starts without
// cuBLAS, and never reads its half gigabyte if it multiplies no matrices.
struct CublasLibrary {
  decltype(&::cublasCreate_v2) create = nullptr;
  decltype(&::cublasDestroy_v2) destroy = nullptr;
  decltype(&::cublasSetStream_v2) set_stream = nullptr;
  decltype(&::cublasSetWorkspace_v2) set_workspace = nullptr;
  decltype(&::cublasSetAtomicsMode) set_atomics_mode = nullptr;
  decltype(&::cublasSgemm_v2) sgemm = nullptr;
  decltype(&::cublasDgemm_v2) dgemm = nullptr;
  decltype(&::cublasGetProperty) get_property = nullptr;

  [[nodiscard]] static absl::StatusOr<const CublasLibrary*> Get();
};

// "13.0.2"; "missing" where it cannot be loaded
[[nodiscard]] std::string CublasVersion();

class CudaGemm {
 public:
  // Less than the 32 MiB of cuBLAS's default: the inner dimension of these products is small, so
  // cuBLAS hardly splits it.
  static constexpr size_t kWorkspaceBytes = size_t{4} << 20;

  // On the current device. Takes kWorkspaceBytes from the reservation.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<CudaGemm>> Create(DeviceReservation& from,
                                                                        cudaStream_t stream);
  ~CudaGemm();
  CudaGemm(const CudaGemm&) = delete;  // owns the handle
  CudaGemm& operator=(const CudaGemm&) = delete;

  [[nodiscard]] absl::Status Multiply(DeviceMatrix<const float> a, DeviceMatrix<const float> b,
                                      DeviceMatrix<float> c);
  [[nodiscard]] absl::Status Multiply(DeviceMatrix<const double> a, DeviceMatrix<const double> b,
                                      DeviceMatrix<double> c);

 private:
  absl::Status Configure(cudaStream_t stream);
  CudaGemm(const CublasLibrary& library, cublasHandle_t handle, DeviceBuffer<uint8_t> workspace)
      : library_(library), handle_(handle), workspace_(std::move(workspace)) {}

  const CublasLibrary& library_;
  cublasHandle_t handle_;
  DeviceBuffer<uint8_t> workspace_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_CUDA_GEMM_H_
