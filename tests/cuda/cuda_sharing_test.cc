// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What scenes and views share on a device is made once. A request for the memory in use need not
// wait for it.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <latch>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "cuda/cuda_backend.h"
#include "fmt/format.h"
#include "tests/cuda/cuda_test.h"
#include "tests/support/pipeline_name.h"

namespace latticed::testing {
namespace {

constexpr std::chrono::seconds kLong{20};
constexpr ViewSpec kSmooth{.segments = 4, .normals = NormalMode::kSmooth};

class CudaSharing : public CudaTest {
 protected:
  CudaSharing() : CudaTest(13) {}

  CudaOptions Gated() {
    return {.memory_bytes = 256 * kMiB,
            .refuse_allocation = [this](std::string_view purpose, uint64_t) {
              if (purpose != held_purpose_ || std::exchange(held_, true)) return false;
              reached_.set_value();
              opened_.get_future().wait();
              return false;
            }};
  }
  // Runs `slow` on a thread up to its allocation for `purpose`. `other` must end while `slow` waits
  // there. Once per test.
  void WhileHeld(std::string_view purpose, const std::function<void()>& slow,
                 const std::function<void()>& other) {
    held_purpose_ = purpose;
    const auto slow_one = std::async(std::launch::async, slow);
    EXPECT_EQ(reached_.get_future().wait_for(kLong), std::future_status::ready);
    const auto other_one = std::async(std::launch::async, other);
    EXPECT_EQ(other_one.wait_for(kLong), std::future_status::ready) << "waits for another's upload";
    opened_.set_value();
  }
  // Makes a view and evaluates it.
  absl::StatusOr<std::unique_ptr<DeformView>> View(DeformTarget& target) {
    auto view = target.CreateView(kSmooth);
    if (!view.ok()) return view;
    if (auto s = (*view)->Evaluate(points_, BoxFor(*plan_, points_), AllChunks(*plan_)); !s.ok()) {
      return s;
    }
    return view;
  }
  std::vector<uint8_t> FirstChunk(DeformView& view) {
    std::vector<uint8_t> bytes(ChunkPoints(*plan_, 0, kSmooth.segments) * BytesPerPoint(kSmooth));
    EXPECT_OK(view.Read(0, bytes));
    return bytes;
  }

 private:
  std::string_view held_purpose_;
  bool held_ = false;
  std::promise<void> reached_, opened_;
};

TEST_F(CudaSharing, ASceneTellsItsMemoryWhileItsNormalsAreBrought) {
  ASSERT_OK_AND_ASSIGN(const auto backend, MakeCudaBackend(Gated()));
  ASSERT_OK_AND_ASSIGN(const auto target, backend->Prepare(plan_, Pipeline::kFused));
  const MemoryUse before = target->memory();

  WhileHeld(
      "plan", [&] { EXPECT_OK(target->CreateView(kSmooth)); },
      [&] { EXPECT_EQ(target->memory(), before); });

  EXPECT_GT(target->memory().at("device_plan"), before.at("device_plan"));
}

TEST_F(CudaSharing, ViewsMadeAtOnceTakeOneCopyOfWhatTheyShare) {
  constexpr int kRounds = 20;
  for (const Pipeline pipeline : {Pipeline::kFused, Pipeline::kGemm}) {
    ASSERT_OK_AND_ASSIGN(const auto backend, MakeCudaBackend({.memory_bytes = 256 * kMiB}));
    MemoryUse use_of_one;
    std::vector<uint8_t> expected;
    {
      ASSERT_OK_AND_ASSIGN(const auto target, backend->Prepare(plan_, pipeline));
      ASSERT_OK_AND_ASSIGN(const auto view, View(*target));
      expected = FirstChunk(*view);
      use_of_one = backend->devices().front().use;
    }
    for (int round = 0; round < kRounds; ++round) {
      SCOPED_TRACE(fmt::format("{}, round {}", PipelineName(pipeline), round));
      ASSERT_OK_AND_ASSIGN(const auto target, backend->Prepare(plan_, pipeline));
      std::latch start(2);
      const auto make = [&] {
        start.arrive_and_wait();
        return View(*target);
      };
      auto on_thread = std::async(std::launch::async, make);
      const auto first = make(), second = on_thread.get();
      ASSERT_OK(first);
      ASSERT_OK(second);

      MemoryUse use = backend->devices().front().use;
      EXPECT_EQ(use["plan"], use_of_one["plan"]);
      EXPECT_EQ(use["stage_matrices"], use_of_one["stage_matrices"]);
      EXPECT_EQ(FirstChunk(**first), expected);
      EXPECT_EQ(FirstChunk(**second), expected);
    }
  }
}

}  // namespace
}  // namespace latticed::testing
