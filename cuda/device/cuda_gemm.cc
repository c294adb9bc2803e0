// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/cuda_gemm.h"

#include "core/base/matrix_view.h"
#include "core/base/status_macros.h"
#include "cuda/device/cuda_status.h"

namespace latticed {
namespace {

int Int(size_t n) { return static_cast<int>(n); }

}  // namespace

absl::StatusOr<std::unique_ptr<CudaGemm>> CudaGemm::Create(DeviceReservation& from,
                                                           cudaStream_t stream) {
  LATTICED_ASSIGN_OR_RETURN(const auto library, CublasLibrary::Get());
  LATTICED_ASSIGN_OR_RETURN(auto workspace, DeviceBuffer<uint8_t>::Create(from, "gemm_workspace",
                                                                          kWorkspaceBytes, stream));
  cublasHandle_t handle = nullptr;
  LATTICED_RETURN_IF_ERROR(CublasStatus(library->create(&handle), "cuBLAS"));
  std::unique_ptr<CudaGemm> gemm(new CudaGemm(*library, handle, std::move(workspace)));
  LATTICED_RETURN_IF_ERROR(gemm->Configure(stream));
  return gemm;
}

absl::Status CudaGemm::Configure(cudaStream_t stream) {
  // The stream first: setting it puts the default workspace back.
  LATTICED_RETURN_IF_ERROR(CublasStatus(library_.set_stream(handle_, stream), "cuBLAS"));
  LATTICED_RETURN_IF_ERROR(
      CublasStatus(library_.set_workspace(handle_, workspace_.data(), kWorkspaceBytes), "cuBLAS"));
  return CublasStatus(library_.set_atomics_mode(handle_, CUBLAS_ATOMICS_NOT_ALLOWED), "cuBLAS");
}

CudaGemm::~CudaGemm() { static_cast<void>(library_.destroy(handle_)); }

absl::Status CudaGemm::Multiply(DeviceMatrix<const float> a, DeviceMatrix<const float> b,
                                DeviceMatrix<float> c) {
  LATTICED_RETURN_IF_ERROR(CheckProduct(a, b, c));
  const float one = 1, zero = 0;
  return CublasStatus(library_.sgemm(handle_, CUBLAS_OP_N, CUBLAS_OP_N, Int(c.rows), Int(c.columns),
                                     Int(a.columns), &one, a.data, Int(a.stride), b.data,
                                     Int(b.stride), &zero, c.data, Int(c.stride)),
                      "cublasSgemm");
}

absl::Status CudaGemm::Multiply(DeviceMatrix<const double> a, DeviceMatrix<const double> b,
                                DeviceMatrix<double> c) {
  LATTICED_RETURN_IF_ERROR(CheckProduct(a, b, c));
  const double one = 1, zero = 0;
  return CublasStatus(library_.dgemm(handle_, CUBLAS_OP_N, CUBLAS_OP_N, Int(c.rows), Int(c.columns),
                                     Int(a.columns), &one, a.data, Int(a.stride), b.data,
                                     Int(b.stride), &zero, c.data, Int(c.stride)),
                      "cublasDgemm");
}

}  // namespace latticed
