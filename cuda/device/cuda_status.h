// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Turns cudaError_t and cublasStatus_t into absl::Status. No other file does.
//
//   memory (device or pinned)           kResourceExhausted
//   no device, no driver, too old       kUnavailable, reason NO_DEVICE
//   the context is lost until restart   kUnavailable, reason DEVICE_LOST: illegal address, failed
//                                       launch, uncorrectable memory error, …
//   anything else                       kInternal
//
// Each function also clears the runtime's "last error", so that the next call starts clean. A lost
// context reports its error again at the next call.
// Threads  safe; the last error belongs to the calling thread
#ifndef LATTICED_CUDA_DEVICE_CUDA_STATUS_H_
#define LATTICED_CUDA_DEVICE_CUDA_STATUS_H_

#include <cublas_v2.h>
#include <cuda_runtime_api.h>

#include <string_view>

#include "absl/status/status.h"

namespace latticed {

// `what` names the failed work: "the samples", "the copy of control points".
[[nodiscard]] absl::Status CudaStatus(cudaError_t error, std::string_view what);
[[nodiscard]] absl::Status CublasStatus(cublasStatus_t status, std::string_view what);

// The thread's last error, for example that of a failed launch.
[[nodiscard]] absl::Status LastCudaStatus(std::string_view what);

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_CUDA_STATUS_H_
