// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A fixture that needs a device, with a small plan. It skips without a device, or fails if
// LATTICED_REQUIRE_BACKENDS names cuda.
#ifndef LATTICED_TESTS_CUDA_CUDA_TEST_H_
#define LATTICED_TESTS_CUDA_CUDA_TEST_H_

#include <gtest/gtest.h>

#include <array>
#include <utility>
#include <vector>

#include "cuda/device/cuda_device.h"
#include "tests/backend/conformance.h"
#include "tests/support/backends.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {

inline constexpr uint64_t kMiB = uint64_t{1} << 20;
inline constexpr std::array kPipelines{Pipeline::kFused, Pipeline::kGemm, Pipeline::kGemm12,
                                       Pipeline::kControlNet};

class CudaTest : public ::testing::Test {
 protected:
  explicit CudaTest(uint32_t seed) : seed_(seed) {}

  void SetUp() override {
    const absl::Status status = CheckDevice(0);
    if (!status.ok() && IsRequired("cuda")) {
      FAIL() << "LATTICED_REQUIRE_BACKENDS names cuda: " << status;
    }
    if (!status.ok()) GTEST_SKIP() << status.message();
    PolygonMesh mesh = TorusMesh(9, 7);
    const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {.scale = 0.8});
    plan_ = MakeTestPlan(std::move(mesh), structure);
    ASSERT_NE(plan_, nullptr);
    points_ = Jitter(structure, 0.05, seed_);
  }

  Plan plan_;
  std::vector<Vec3d> points_;

 private:
  const uint32_t seed_;
};

// Compares the budgets, which we count to the byte. Call it after a first use, since lanes keep
// their workspaces.
inline void ExpectSameUse(const Backend& backend, const DeviceState& before) {
  const DeviceState state = backend.devices().front();
  EXPECT_EQ(state.free_bytes, before.free_bytes);
  EXPECT_EQ(state.use, before.use);
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CUDA_CUDA_TEST_H_
