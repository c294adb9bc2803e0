// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The memory that a scene reports, as in GetScene: its purposes add up to the device's own report.
#include <gtest/gtest.h>

#include <string>

#include "cuda/cuda_backend.h"
#include "tests/cuda/cuda_test.h"
#include "tests/support/pipeline_name.h"

namespace latticed::testing {
namespace {

constexpr uint64_t kBudget = 256 * kMiB;
constexpr ViewSpec kSpec{.segments = 4};

class CudaPurposes : public CudaTest {
 protected:
  CudaPurposes() : CudaTest(17) {}
  // Adds purposes under the device's names, without the prefix.
  static void AddDevicePart(const MemoryUse& of, MemoryUse& sum) {
    for (const auto& [purpose, bytes] : of) {
      if (purpose.starts_with(kDevicePurpose)) sum[purpose.substr(kDevicePurpose.size())] += bytes;
    }
  }
  static void ExpectUse(const Backend& backend, const MemoryUse& sum) {
    const DeviceState state = backend.devices().front();
    EXPECT_EQ(state.use, sum);
    uint64_t bytes = 0;
    for (const auto& [purpose, size] : sum) bytes += size;
    EXPECT_EQ(state.free_bytes, kBudget - bytes);
  }
};

TEST_F(CudaPurposes, TheDeviceReportsTheSumOfAllPurposes) {
  for (const Pipeline pipeline : kPipelines) {
    SCOPED_TRACE(PipelineName(pipeline));
    const bool fused = pipeline == Pipeline::kFused;
    ASSERT_OK_AND_ASSIGN(const auto backend, MakeCudaBackend({.memory_bytes = kBudget}));
    ASSERT_OK_AND_ASSIGN(const auto target, backend->Prepare(plan_, pipeline));
    ASSERT_OK_AND_ASSIGN(const auto view, target->CreateView(kSpec));
    if (!fused) {
      EXPECT_EQ(view->memory().at("device_samples"), 0u) << "before the first use";
    }

    ASSERT_OK(view->Evaluate(points_, BoxFor(*plan_, points_), AllChunks(*plan_)));
    ASSERT_OK(view->Encode(AllChunks(*plan_), Encoding::kQuantised));

    MemoryUse sum;
    AddDevicePart(target->memory(), sum);
    AddDevicePart(view->memory(), sum);
    EXPECT_EQ(target->device_use(), (DeviceUse{{0, sum.at("plan")}}));
    if (!fused) sum["gemm_workspace"] = 4 * kMiB;  // belongs to the lane, not to a scene
    ExpectUse(*backend, sum);
  }
}

TEST_F(CudaPurposes, TheDeviceReportsTheSumOfAllPurposesOfAViewWithATolerance) {
  const QuantisationBox box = BoxFor(*plan_, points_);
  ASSERT_OK_AND_ASSIGN(const auto backend, MakeCudaBackend({.memory_bytes = kBudget}));
  ASSERT_OK_AND_ASSIGN(const auto target, backend->Prepare(plan_, Pipeline::kFused));
  ASSERT_OK_AND_ASSIGN(const auto view, target->CreateView({.segments = 32,
                                                            .tolerance = 1e-5 * box.range,
                                                            .normals = NormalMode::kSmooth,
                                                            .position_bits = 16}));
  const uint64_t vertices = view->memory().at("device_vertices");

  ASSERT_OK(view->Evaluate(points_, box, AllChunks(*plan_)));
  ASSERT_OK(view->Encode(AllChunks(*plan_), Encoding::kQuantised));

  EXPECT_GT(view->memory().at("device_vertices"), vertices) << "it has more points than room";
  MemoryUse sum;
  AddDevicePart(target->memory(), sum);
  AddDevicePart(view->memory(), sum);
  ExpectUse(*backend, sum);
}

TEST_F(CudaPurposes, TheDeviceReportsTheSumOfAllPurposesOfAViewOfBounds) {
  ASSERT_OK_AND_ASSIGN(const auto backend, MakeCudaBackend({.memory_bytes = kBudget}));
  ASSERT_OK_AND_ASSIGN(const auto target, backend->Prepare(plan_, Pipeline::kFused));
  ASSERT_OK_AND_ASSIGN(const auto view, target->CreateView({.format = VertexFormat::kEdgeBounds}));

  ASSERT_OK(view->Evaluate(points_, BoxFor(*plan_, points_), AllChunks(*plan_)));
  ASSERT_OK(view->Encode(AllChunks(*plan_), Encoding::kPatches));

  MemoryUse sum;
  AddDevicePart(target->memory(), sum);
  AddDevicePart(view->memory(), sum);
  EXPECT_EQ(sum.count("vertices"), 0u);
  EXPECT_EQ(sum.count("draco"), 0u);
  ExpectUse(*backend, sum);
}

}  // namespace
}  // namespace latticed::testing
