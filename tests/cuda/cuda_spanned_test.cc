// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One plan on two devices, or twice on one if there is no second: failed allocations in either
// part, and budgets. Leaks are tested in cuda_soak_test.cc, and equal bits in
// tests/backend/spanned_test.cc.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "cuda/cuda_backend.h"
#include "fmt/format.h"
#include "tests/cuda/cuda_test.h"

namespace latticed::testing {
namespace {

using Bytes = std::vector<std::vector<uint8_t>>;

class CudaSpanned : public CudaTest {
 protected:
  CudaSpanned() : CudaTest(5) {}

  static CudaOptions OnTwo() {
    return {.devices = {0, CheckDevice(1).ok() ? 1 : 0},
            .span_patches = 1,
            .memory_bytes = 256 * kMiB,
            .encoder = nullptr,
            .refuse_allocation = {}};
  }

  // Prepares, makes a view, evaluates everything, then dirty chunks on either side of the cut, and
  // encodes.
  absl::StatusOr<Bytes> Use(Backend& backend, const ViewSpec& spec) {
    auto target = backend.Prepare(plan_, Pipeline::kFused);
    if (!target.ok()) return target.status();
    auto view = (*target)->CreateView(spec);
    if (!view.ok()) return view.status();
    const QuantisationBox box = BoxFor(*plan_, points_);
    const std::vector<uint32_t> all = AllChunks(*plan_), ends{all.front(), all.back()};
    if (auto s = (*view)->Evaluate(plan_->identity_points, box, all); !s.ok()) return s;
    if (auto s = (*view)->Evaluate(points_, box, all); !s.ok()) return s;
    if (auto s = (*view)->Evaluate(points_, box, ends); !s.ok()) return s;
    const auto encoded = (*view)->Encode(all, Encoding::kQuantised);
    if (!encoded.ok()) return encoded.status();
    Bytes bytes;
    for (const SharedBytes& e : *encoded) bytes.emplace_back(e.span().begin(), e.span().end());
    return bytes;
  }

  static std::vector<uint64_t> FreeOfBudgets(const Backend& backend) {
    std::vector<uint64_t> free;
    for (const DeviceState& state : backend.devices()) free.push_back(state.free_bytes);
    return free;
  }
};

TEST_F(CudaSpanned, EveryFailedAllocationOfEitherPartIsRefusedCleanly) {
  // Allocations until one is refused; none is if this is negative. Atomic, because two parts encode
  // at once.
  std::atomic<int> left = -1;
  CudaOptions options = OnTwo();
  options.refuse_allocation = [&left](std::string_view, uint64_t) { return left-- == 0; };
  ASSERT_OK_AND_ASSIGN(const auto backend, MakeCudaBackend(options));
  const std::vector<uint64_t> untouched = FreeOfBudgets(*backend);
  const double tolerance = 1e-3 * BoxFor(*plan_, points_).range;
  for (const ViewSpec& spec : {ViewSpec{.segments = 4, .normals = NormalMode::kSmooth},
                               ViewSpec{.segments = 32, .tolerance = tolerance}}) {
    left = -1;
    ASSERT_OK_AND_ASSIGN(const auto expected, Use(*backend, spec));
    int refused = 0;
    for (int at = 0;; ++at) {
      SCOPED_TRACE(fmt::format("tolerance {}, allocation {}", spec.tolerance, at));
      left = at;
      const auto failed = Use(*backend, spec);
      if (failed.ok()) break;
      ASSERT_THAT(failed, StatusIs(absl::StatusCode::kResourceExhausted));
      ++refused;
      left = -1;
      ASSERT_EQ(FreeOfBudgets(*backend), untouched);
      ASSERT_OK_AND_ASSIGN(const auto again, Use(*backend, spec));
      ASSERT_TRUE(again == expected);
    }
    EXPECT_GT(refused, 14) << "one part has some 11";
  }
}

TEST_F(CudaSpanned, ABudgetThatIsTooSmallNamesItsDevice) {
  CudaOptions options = OnTwo();
  options.memory_bytes = 2 * kMiB;
  ASSERT_OK_AND_ASSIGN(const auto backend, MakeCudaBackend(options));
  ASSERT_OK_AND_ASSIGN(const auto target, backend->Prepare(plan_, Pipeline::kFused));

  const auto refused = target->CreateView({.segments = 32, .format = VertexFormat::kFloat32});

  ASSERT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted));
  const error::Details details = error::DetailsOf(refused.status());
  EXPECT_EQ(details.metadata.at(error::kDeviceKey), "0");
  EXPECT_GT(details.asked_bytes, details.free_bytes);
  EXPECT_OK(target->CreateView({.segments = 2}));
}

TEST_F(CudaSpanned, DevicesAreToldByNumber) {
  const CudaOptions options = OnTwo();
  ASSERT_OK_AND_ASSIGN(const auto backend, MakeCudaBackend(options));
  ASSERT_OK_AND_ASSIGN(const auto target, backend->Prepare(plan_, Pipeline::kFused));

  const std::vector<DeviceState> states = backend->devices();

  ASSERT_EQ(states.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(states[i].number, options.devices[i]);
    EXPECT_GT(states[i].use.at("plan"), 0u);
    EXPECT_TRUE(target->device_use().contains(options.devices[i]));
  }
}

}  // namespace
}  // namespace latticed::testing
