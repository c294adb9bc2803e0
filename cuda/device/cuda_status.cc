// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/cuda_status.h"

#include <string>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// A process cannot recover a lost context, so the client must go to another server.
constexpr uint32_t kRetryElsewhereMs = 1'000;

enum class Kind { kMemory, kNoDevice, kLost, kOther };

Kind KindOf(cudaError_t error) {
  switch (error) {
    case cudaErrorMemoryAllocation:
      return Kind::kMemory;
    case cudaErrorNoDevice:
    case cudaErrorInvalidDevice:
    case cudaErrorInsufficientDriver:
    case cudaErrorInitializationError:
    case cudaErrorDevicesUnavailable:
    case cudaErrorNoKernelImageForDevice:
    case cudaErrorSystemDriverMismatch:
    case cudaErrorSystemNotReady:
    case cudaErrorCompatNotSupportedOnDevice:
    case cudaErrorStubLibrary:
      return Kind::kNoDevice;
    case cudaErrorIllegalAddress:
    case cudaErrorLaunchFailure:
    case cudaErrorLaunchTimeout:
    case cudaErrorAssert:
    case cudaErrorHardwareStackError:
    case cudaErrorIllegalInstruction:
    case cudaErrorMisalignedAddress:
    case cudaErrorInvalidAddressSpace:
    case cudaErrorInvalidPc:
    case cudaErrorECCUncorrectable:
    case cudaErrorNvlinkUncorrectable:
    case cudaErrorContained:
    case cudaErrorCudartUnloading:
    case cudaErrorUnknown:
      return Kind::kLost;
    default:
      return Kind::kOther;
  }
}

// cuBLAS's own function for this needs the library to be loaded.
std::string_view CublasName(cublasStatus_t status) {
  switch (status) {
    case CUBLAS_STATUS_NOT_INITIALIZED:
      return "CUBLAS_STATUS_NOT_INITIALIZED";
    case CUBLAS_STATUS_INVALID_VALUE:
      return "CUBLAS_STATUS_INVALID_VALUE";
    case CUBLAS_STATUS_ARCH_MISMATCH:
      return "CUBLAS_STATUS_ARCH_MISMATCH";
    case CUBLAS_STATUS_EXECUTION_FAILED:
      return "CUBLAS_STATUS_EXECUTION_FAILED";
    case CUBLAS_STATUS_NOT_SUPPORTED:
      return "CUBLAS_STATUS_NOT_SUPPORTED";
    default:
      return "CUBLAS_STATUS_INTERNAL_ERROR";
  }
}

}  // namespace

absl::Status CudaStatus(cudaError_t error, std::string_view what) {
  if (error == cudaSuccess) return absl::OkStatus();
  static_cast<void>(cudaGetLastError());
  const std::string text =
      fmt::format("{}: {} ({})", what, cudaGetErrorString(error), cudaGetErrorName(error));
  switch (KindOf(error)) {
    case Kind::kMemory:
      return error::AllocationFailed(what);
    case Kind::kNoDevice:
      return error::Unavailable("NO_DEVICE", text, 0);
    case Kind::kLost:
      return error::Unavailable("DEVICE_LOST", text, kRetryElsewhereMs);
    case Kind::kOther:
      break;
  }
  return absl::InternalError(text);
}

absl::Status CublasStatus(cublasStatus_t status, std::string_view what) {
  if (status == CUBLAS_STATUS_SUCCESS) return absl::OkStatus();
  if (status == CUBLAS_STATUS_NOT_INITIALIZED || status == CUBLAS_STATUS_EXECUTION_FAILED ||
      status == CUBLAS_STATUS_INTERNAL_ERROR) {
    // The runtime's error tells the cause, for example a lost context.
    LATTICED_RETURN_IF_ERROR(LastCudaStatus(what));
  }
  if (status == CUBLAS_STATUS_ALLOC_FAILED) return error::AllocationFailed(what);
  return absl::InternalError(fmt::format("{}: {}", what, CublasName(status)));
}

absl::Status LastCudaStatus(std::string_view what) { return CudaStatus(cudaGetLastError(), what); }

}  // namespace latticed
