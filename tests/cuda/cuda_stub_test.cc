// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A build without CUDA says so, both to callers that ask for a device and to the suites that then skip.
#include <gtest/gtest.h>

#include "cuda/cuda_backend.h"
#include "tests/support/backends.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

TEST(CudaStub, AskedForADeviceItSaysThatThereIsNoCuda) {
  const auto backend = MakeCudaBackend({.devices = {0}});

  EXPECT_THAT(backend, StatusIs(absl::StatusCode::kUnimplemented));
  EXPECT_EQ(backend.status().message(), "built without CUDA");
}

TEST(CudaStub, TestsOfEveryBackendSkipWithTheseWords) {
  for (const std::string name : {"cuda", "cuda-spanned"}) {
    const auto backend = MakeBackendByName(name);

    EXPECT_THAT(backend, StatusIs(absl::StatusCode::kUnimplemented)) << name;
    EXPECT_EQ(backend.status().message(), "built without CUDA") << name;
  }
}

}  // namespace
}  // namespace latticed::testing
