// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Errors of the CUDA runtime and of cuBLAS as statuses. Needs no device.
#include "cuda/device/cuda_status.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

TEST(CudaStatusTest, SuccessIsOk) {
  EXPECT_OK(CudaStatus(cudaSuccess, "the samples"));
  EXPECT_OK(CublasStatus(CUBLAS_STATUS_SUCCESS, "cublasSgemm"));
}

TEST(CudaStatusTest, OutOfMemoryIsResourceExhausted) {
  EXPECT_THAT(CudaStatus(cudaErrorMemoryAllocation, "the plan"),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("the plan")));
}

TEST(CudaStatusTest, LostDeviceIsUnavailable) {
  for (cudaError_t error : {cudaErrorIllegalAddress, cudaErrorLaunchFailure,
                            cudaErrorECCUncorrectable, cudaErrorUnknown}) {
    const absl::Status status = CudaStatus(error, "the vertices");

    EXPECT_THAT(status, StatusIs(absl::StatusCode::kUnavailable, HasSubstr("the vertices")));
    EXPECT_EQ(error::DetailsOf(status).reason, "DEVICE_LOST");
  }
}

TEST(CudaStatusTest, MissingDeviceOrDriverIsUnavailable) {
  for (cudaError_t error : {cudaErrorNoDevice, cudaErrorInsufficientDriver}) {
    const absl::Status status = CudaStatus(error, "no CUDA device");

    EXPECT_THAT(status, StatusIs(absl::StatusCode::kUnavailable));
    EXPECT_EQ(error::DetailsOf(status).reason, "NO_DEVICE");
  }
}

TEST(CudaStatusTest, MistakesOfOursAreInternal) {
  EXPECT_THAT(CudaStatus(cudaErrorInvalidConfiguration, "the samples"),
              StatusIs(absl::StatusCode::kInternal, HasSubstr("cudaErrorInvalidConfiguration")));
  EXPECT_THAT(CublasStatus(CUBLAS_STATUS_INVALID_VALUE, "cublasSgemm"),
              StatusIs(absl::StatusCode::kInternal, HasSubstr("CUBLAS_STATUS_INVALID_VALUE")));
}

}  // namespace
}  // namespace latticed::testing
