// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What does not fit a device is refused before anything is allocated, with all bytes that it asks for
// and those that are free.
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <set>
#include <string>

#include "core/base/error.h"
#include "cuda/cuda_backend.h"
#include "fmt/format.h"
#include "tests/cuda/cuda_test.h"

namespace latticed::testing {
namespace {

// Two of which are the first to need the plan's normals.
const std::array kSpecs{
    ViewSpec{.segments = 4, .normals = NormalMode::kSmooth},
    ViewSpec{.segments = 32, .normal_bits = 12},
    ViewSpec{.segments = 7, .normals = NormalMode::kSmooth, .format = VertexFormat::kFloat32}};

class CudaRefusals : public CudaTest {
 protected:
  CudaRefusals() : CudaTest(3) {}

  // What a plan and the first view of a device take.
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
  const auto large = MakeCudaBackend({.memory_bytes = 256 * kMiB});
  ASSERT_OK(large);
  for (const Pipeline pipeline : kPipelines) {
    SCOPED_TRACE(PipelineName(pipeline));
    const auto target = (*large)->Prepare(plan_, pipeline);
    ASSERT_OK(target);
    const uint64_t bytes = (*target)->memory().at("device_plan");
    const auto enough = MakeCudaBackend({.memory_bytes = bytes});
    const auto small = MakeCudaBackend({.memory_bytes = bytes - 1});
    ASSERT_OK(enough);
    ASSERT_OK(small);

    const auto refused = (*small)->Prepare(plan_, pipeline);

    ASSERT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted));
    EXPECT_EQ(error::DetailsOf(refused.status()).asked_bytes, bytes);
    EXPECT_EQ(error::DetailsOf(refused.status()).free_bytes, bytes - 1);
    EXPECT_EQ((*small)->devices().front().use, MemoryUse());
    EXPECT_OK((*enough)->Prepare(plan_, pipeline));
  }
}

// Also the first on its device, which brings what it will share with others: stage matrices and a
// workspace of cuBLAS.
TEST_F(CudaRefusals, AViewThatDoesNotFitIsRefusedBeforeAnythingIsAllocated) {
  for (const Pipeline pipeline : kPipelines) {
    for (const ViewSpec& spec : kSpecs) {
      SCOPED_TRACE(fmt::format("{}, {} segments", PipelineName(pipeline), spec.segments));
      const FirstView first = MakeFirstView(pipeline, spec);
      ASSERT_GT(first.view_bytes, pipeline == Pipeline::kFused ? 0 : 4 * kMiB);
      const auto enough = MakeCudaBackend({.memory_bytes = first.plan_bytes + first.view_bytes});
      const auto small = MakeCudaBackend({.memory_bytes = first.plan_bytes + first.view_bytes - 1});
      ASSERT_OK(enough);
      ASSERT_OK(small);
      const auto target = (*small)->Prepare(plan_, pipeline);
      ASSERT_OK(target);
      const DeviceState before = (*small)->devices().front();

      const auto refused = (*target)->CreateView(spec);

      ASSERT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted));
      EXPECT_EQ(error::DetailsOf(refused.status()).asked_bytes, first.view_bytes);
      EXPECT_EQ(error::DetailsOf(refused.status()).free_bytes, first.view_bytes - 1);
      ExpectSameUse(**small, before);
      const auto target_of_enough = (*enough)->Prepare(plan_, pipeline);
      ASSERT_OK(target_of_enough);
      const auto fits = (*target_of_enough)->CreateView(spec);
      EXPECT_OK(fits);
      EXPECT_EQ((*enough)->devices().front().free_bytes, 0u);
    }
  }
}

TEST_F(CudaRefusals, ControlNetsThatDoNotFitAreRefusedBeforeAnythingIsAllocated) {
  for (const Pipeline pipeline : kPipelines) {
    SCOPED_TRACE(PipelineName(pipeline));
    const uint64_t plan_bytes = MakeFirstView(pipeline, kSpecs.front()).plan_bytes;
    const auto none = MakeCudaBackend({.memory_bytes = plan_bytes});
    ASSERT_OK(none);
    const auto target = (*none)->Prepare(plan_, pipeline);
    ASSERT_OK(target);
    const DeviceState before = (*none)->devices().front();

    const auto refused = (*target)->ControlNets(points_, 0, 2);

    ASSERT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted));
    EXPECT_EQ(error::DetailsOf(refused.status()).free_bytes, 0u);
    ExpectSameUse(**none, before);
    const uint64_t net_bytes = error::DetailsOf(refused.status()).asked_bytes;
    const auto enough = MakeCudaBackend({.memory_bytes = plan_bytes + net_bytes});
    ASSERT_OK(enough);
    const auto target_of_enough = (*enough)->Prepare(plan_, pipeline);
    ASSERT_OK(target_of_enough);
    EXPECT_OK((*target_of_enough)->ControlNets(points_, 0, 2));
  }
}

// Also where the budget has room and the device has not, which any of the blocks may find out.
TEST_F(CudaRefusals, ARefusalNamesAllThatIsNeededTogether) {
  std::string refused_purpose;
  std::set<std::string, std::less<>> purposes;  // asked for since they were cleared
  const auto backend = MakeCudaBackend(
      {.memory_bytes = 256 * kMiB, .refuse_allocation = [&](std::string_view purpose, uint64_t) {
         purposes.emplace(purpose);
         return purpose == refused_purpose;
       }});
  ASSERT_OK(backend);
  const auto state = [&] { return (*backend)->devices().front(); };
  for (const Pipeline pipeline : kPipelines) {
    SCOPED_TRACE(PipelineName(pipeline));
    const auto target = (*backend)->Prepare(plan_, pipeline);
    ASSERT_OK(target);
    const auto living = (*target)->CreateView(kSpecs.front());
    ASSERT_OK(living);  // keeps what is of no view
    const auto evaluate = [&](DeformView& view) {
      return view.Evaluate(points_, BoxFor(*plan_, points_), AllChunks(*plan_));
    };
    {
      const auto view = (*target)->CreateView(kSpecs.front());
      ASSERT_OK(view);
      ASSERT_OK(evaluate(**view));  // its lane stays
    }
    const DeviceState before = state();
    uint64_t view_bytes = 0;
    std::set<std::string, std::less<>> purposes_of_view;
    {
      purposes.clear();
      const auto view = (*target)->CreateView(kSpecs.front());
      ASSERT_OK(view);
      purposes_of_view = purposes;
      view_bytes = before.free_bytes - state().free_bytes;
      if (pipeline != Pipeline::kFused) {
        refused_purpose = "samples";
        const absl::Status no_samples = evaluate(**view);
        refused_purpose.clear();

        ASSERT_THAT(no_samples, StatusIs(absl::StatusCode::kResourceExhausted));
        ASSERT_OK(evaluate(**view));
        EXPECT_EQ(error::DetailsOf(no_samples).asked_bytes, state().use.at("samples"));
      }
    }
    ExpectSameUse(**backend, before);

    // "staging" is the host's too, which is asked for after the device's.
    EXPECT_THAT(purposes_of_view, ::testing::IsSupersetOf({"staging", "vertices"}));
    EXPECT_GE(purposes_of_view.size(), pipeline == Pipeline::kFused ? 3u : 2u);
    for (const std::string& purpose : purposes_of_view) {
      SCOPED_TRACE(purpose);
      refused_purpose = purpose;
      const auto no_view = (*target)->CreateView(kSpecs.front());
      refused_purpose.clear();

      ASSERT_THAT(no_view, StatusIs(absl::StatusCode::kResourceExhausted));
      EXPECT_EQ(error::DetailsOf(no_view.status()).asked_bytes, view_bytes);
      EXPECT_EQ(error::DetailsOf(no_view.status()).free_bytes, before.free_bytes);
      ExpectSameUse(**backend, before);
    }
  }
}

// A lane keeps its workspace of cuBLAS, 4 MiB, and a plan its normals, 36 bytes a patch: the next
// view finds them.
TEST_F(CudaRefusals, WhatARefusedViewLeavesBehindIsToldNeitherAsAskedNorAsFree) {
  ASSERT_EQ(plan_->patches.size(), 602u);
  constexpr uint64_t kWorkspace = 4'194'304, kNormals = 21'672;
  // Stage matrices, the edit's copy and the vertices.
  constexpr uint64_t kOfProducts = 27'264 + 2'496 + 72'240;
  // The list of chunks, box polynomials, the edit's copy and the vertices of 19 whole chunks.
  constexpr uint64_t kOfFused = 304 + 6'460 + 2'496 + 72'960;
  struct Refused {
    Pipeline pipeline;
    NormalMode normals;
    uint64_t left_behind, asked;
  };
  for (const Refused& expected :
       {Refused{Pipeline::kGemm, NormalMode::kFacet, kWorkspace, kOfProducts},
        Refused{Pipeline::kFused, NormalMode::kSmooth, kNormals, kOfFused},
        Refused{Pipeline::kGemm, NormalMode::kSmooth, kWorkspace + kNormals, kOfProducts}}) {
    SCOPED_TRACE(
        fmt::format("{}, {} bytes", PipelineName(expected.pipeline), expected.left_behind));
    const ViewSpec spec{.segments = 4, .normals = expected.normals};
    bool refuse = true;
    const auto backend = MakeCudaBackend(
        {.memory_bytes = 256 * kMiB, .refuse_allocation = [&](std::string_view purpose, uint64_t) {
           return purpose == "vertices" && refuse;  // the last block
         }});
    ASSERT_OK(backend);
    const auto free_bytes = [&] { return (*backend)->devices().front().free_bytes; };
    const auto target = (*backend)->Prepare(plan_, expected.pipeline);
    ASSERT_OK(target);
    const uint64_t free_before = free_bytes();

    const auto refused = (*target)->CreateView(spec);

    ASSERT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted));
    const uint64_t free_after = free_before - expected.left_behind;
    EXPECT_EQ(free_bytes(), free_after);
    EXPECT_EQ(error::DetailsOf(refused.status()).asked_bytes, expected.asked);
    EXPECT_EQ(error::DetailsOf(refused.status()).free_bytes, free_after);
    refuse = false;
    const auto view = (*target)->CreateView(spec);
    ASSERT_OK(view);
    EXPECT_EQ(free_after - free_bytes(), expected.asked);
  }
}

}  // namespace
}  // namespace latticed::testing
