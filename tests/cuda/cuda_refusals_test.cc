// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A request that does not fit a device is refused before anything is allocated. The refusal names
// all bytes that it asks for, and the free bytes.
#include <gtest/gtest.h>

#include <array>

#include "core/base/error.h"
#include "cuda/cuda_backend.h"
#include "fmt/format.h"
#include "tests/cuda/cuda_test.h"
#include "tests/support/pipeline_name.h"

namespace latticed::testing {
namespace {

// Two of these are the first to need the plan's normals.
const std::array kRefusalSpecs{
    ViewSpec{.segments = 4, .normals = NormalMode::kSmooth},
    ViewSpec{.segments = 32, .normal_bits = 12}, ViewSpec{.segments = 32, .tolerance = 1e-4},
    ViewSpec{.format = VertexFormat::kEdgeBounds},
    ViewSpec{.segments = 7, .normals = NormalMode::kSmooth, .format = VertexFormat::kFloat32}};

class CudaRefusals : public CudaTest {
 protected:
  CudaRefusals() : CudaTest(3) {}

  // The bytes of a plan and of the first view on a device.
  struct FirstView {
    uint64_t plan_bytes = 0, view_bytes = 0;
  };
  FirstView MakeFirstView(Pipeline pipeline, const ViewSpec& spec) {
    FirstView bytes;
    const auto backend = MakeCudaBackend({.memory_bytes = 256 * kMiB});
    EXPECT_OK(backend);
    if (!backend.ok()) return bytes;
    const auto target = (*backend)->Prepare(plan_, pipeline);
    EXPECT_OK(target);
    if (!target.ok()) return bytes;
    bytes.plan_bytes = (*target)->memory().at("device_plan");
    const uint64_t free_before = (*backend)->devices().front().free_bytes;
    const auto view = (*target)->CreateView(spec);
    EXPECT_OK(view);
    bytes.view_bytes = free_before - (*backend)->devices().front().free_bytes;
    return bytes;
  }
};

TEST_F(CudaRefusals, APlanThatDoesNotFitIsRefusedBeforeAnythingIsAllocated) {
  ASSERT_OK_AND_ASSIGN(const auto large, MakeCudaBackend({.memory_bytes = 256 * kMiB}));
  for (const Pipeline pipeline : kPipelines) {
    SCOPED_TRACE(PipelineName(pipeline));
    ASSERT_OK_AND_ASSIGN(const auto target, large->Prepare(plan_, pipeline));
    const uint64_t bytes = target->memory().at("device_plan");
    ASSERT_OK_AND_ASSIGN(const auto enough, MakeCudaBackend({.memory_bytes = bytes}));
    ASSERT_OK_AND_ASSIGN(const auto small, MakeCudaBackend({.memory_bytes = bytes - 1}));

    const auto refused = small->Prepare(plan_, pipeline);

    ASSERT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted));
    EXPECT_EQ(error::DetailsOf(refused.status()).asked_bytes, bytes);
    EXPECT_EQ(error::DetailsOf(refused.status()).free_bytes, bytes - 1);
    EXPECT_EQ(small->devices().front().use, MemoryUse());
    EXPECT_OK(enough->Prepare(plan_, pipeline));
  }
}

// Includes the first view on a device, which also creates what later views share: stage matrices
// and a cuBLAS workspace.
TEST_F(CudaRefusals, AViewThatDoesNotFitIsRefusedBeforeAnythingIsAllocated) {
  for (const Pipeline pipeline : kPipelines) {
    for (const ViewSpec& spec : kRefusalSpecs) {
      const bool only_fused = spec.tolerance > 0 || spec.format == VertexFormat::kEdgeBounds;
      if (only_fused && pipeline != Pipeline::kFused) continue;  // no such view
      SCOPED_TRACE(fmt::format("{}, {} segments, tolerance {}, format {}", PipelineName(pipeline),
                               spec.segments, spec.tolerance, static_cast<int>(spec.format)));
      const FirstView first = MakeFirstView(pipeline, spec);
      ASSERT_GT(first.view_bytes, pipeline == Pipeline::kFused ? 0 : 4 * kMiB);
      ASSERT_OK_AND_ASSIGN(const auto enough,
                           MakeCudaBackend({.memory_bytes = first.plan_bytes + first.view_bytes}));
      ASSERT_OK_AND_ASSIGN(
          const auto small,
          MakeCudaBackend({.memory_bytes = first.plan_bytes + first.view_bytes - 1}));
      ASSERT_OK_AND_ASSIGN(const auto target, small->Prepare(plan_, pipeline));
      const DeviceState before = small->devices().front();

      const auto refused = target->CreateView(spec);

      ASSERT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted));
      EXPECT_EQ(error::DetailsOf(refused.status()).asked_bytes, first.view_bytes);
      EXPECT_EQ(error::DetailsOf(refused.status()).free_bytes, first.view_bytes - 1);
      ExpectSameUse(*small, before);
      ASSERT_OK_AND_ASSIGN(const auto target_of_enough, enough->Prepare(plan_, pipeline));
      const auto fits = target_of_enough->CreateView(spec);
      EXPECT_OK(fits);
      EXPECT_EQ(enough->devices().front().free_bytes, 0u);
    }
  }
}

// How many vertices a view with a tolerance has is known only when it is evaluated.
TEST_F(CudaRefusals, VerticesWithAToleranceThatDoNotFitAreRefusedByEvaluate) {
  const QuantisationBox box = BoxFor(*plan_, points_);
  const ViewSpec spec{.segments = 32, .tolerance = 1e-5 * box.range, .position_bits = 16};
  const FirstView first = MakeFirstView(Pipeline::kFused, spec);
  ASSERT_OK_AND_ASSIGN(const auto small,
                       MakeCudaBackend({.memory_bytes = first.plan_bytes + first.view_bytes}));
  ASSERT_OK_AND_ASSIGN(const auto target, small->Prepare(plan_, Pipeline::kFused));
  const uint64_t free_before = small->devices().front().free_bytes;
  {
    ASSERT_OK_AND_ASSIGN(const auto view, target->CreateView(spec));
    for (int turn = 0; turn < 2; ++turn) {
      EXPECT_THAT(view->Evaluate(points_, box, AllChunks(*plan_)),
                  StatusIs(absl::StatusCode::kResourceExhausted));
    }
  }
  EXPECT_EQ(small->devices().front().free_bytes, free_before);
  // Three vertices a patch have room.
  const ViewSpec coarse{.segments = 32, .tolerance = box.range};
  ASSERT_OK_AND_ASSIGN(const auto fits, target->CreateView(coarse));
  EXPECT_OK(fits->Evaluate(points_, box, AllChunks(*plan_)));
}

TEST_F(CudaRefusals, ControlNetsThatDoNotFitAreRefusedBeforeAnythingIsAllocated) {
  for (const Pipeline pipeline : kPipelines) {
    SCOPED_TRACE(PipelineName(pipeline));
    const uint64_t plan_bytes = MakeFirstView(pipeline, kRefusalSpecs.front()).plan_bytes;
    ASSERT_OK_AND_ASSIGN(const auto none, MakeCudaBackend({.memory_bytes = plan_bytes}));
    ASSERT_OK_AND_ASSIGN(const auto target, none->Prepare(plan_, pipeline));
    const DeviceState before = none->devices().front();

    const auto refused = target->ControlNets(points_, 0, 2);

    ASSERT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted));
    EXPECT_EQ(error::DetailsOf(refused.status()).free_bytes, 0u);
    ExpectSameUse(*none, before);
    const uint64_t net_bytes = error::DetailsOf(refused.status()).asked_bytes;
    ASSERT_OK_AND_ASSIGN(const auto enough,
                         MakeCudaBackend({.memory_bytes = plan_bytes + net_bytes}));
    ASSERT_OK_AND_ASSIGN(const auto target_of_enough, enough->Prepare(plan_, pipeline));
    EXPECT_OK(target_of_enough->ControlNets(points_, 0, 2));
  }
}

}  // namespace
}  // namespace latticed::testing
