// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The matrix product on one stream: the only place that calls cuBLAS. Twin of core/cpu/gemm/cpu_gemm.h.
//
//   c = a * b      a: c.rows x k    b: k x c.columns    column-major
//
// In float32 without TF32, and the same bits for the same shape on the same device: one handle a
// stream, with a workspace of its own and no atomics.
//
// Errors   kInternal with the shapes where they do not fit; those of cuda_status.h; kUnavailable, reason
//          NO_CUBLAS, where the library of the toolkit's major version is neither on the loader's path
//          nor in the toolkit's usual place
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

// cuBLAS, loaded when the first product asks for it, and never unloaded: a program with the CUDA backend
// starts without cuBLAS, and does not read its half gigabyte where no product is wanted.
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

class CudaGemm {
 public:
  // The products are tall and thin, hardly split along m: less than the 32 MiB that cuBLAS would
  // take.
  static constexpr size_t kWorkspaceBytes = size_t{4} << 20;

  // On the current device. Of bytes reserved: kWorkspaceBytes.
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
