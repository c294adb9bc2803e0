// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/device_budget.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "core/base/error.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

TEST(DeviceBudget, CountsWhatIsReservedAndWhatIsUsedByPurpose) {
  DeviceBudget budget(0, 100);

  ASSERT_OK(budget.Reserve("the view", 70));
  EXPECT_EQ(budget.free_bytes(), 30u);
  EXPECT_EQ(budget.use(), MemoryUse()) << "nothing is allocated yet";

  budget.Use("vertices", 50);
  budget.Use("staging", 5);
  EXPECT_EQ(budget.free_bytes(), 30u);
  EXPECT_EQ(budget.use(), (MemoryUse{{"vertices", 50}, {"staging", 5}}));

  budget.GiveBack(15);
  EXPECT_EQ(budget.free_bytes(), 45u);
  budget.Return("vertices", 50);
  EXPECT_EQ(budget.free_bytes(), 95u);
  EXPECT_EQ(budget.use().at("vertices"), 0u);
}

TEST(DeviceBudget, RefusesAllOfWhatDoesNotFitAndNamesAllOfIt) {
  DeviceBudget budget(3, 100);
  ASSERT_OK(budget.Reserve("the plan", 60));

  const absl::Status refused = budget.Reserve("the view", 41);

  ASSERT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted));
  const error::Details details = error::DetailsOf(refused);
  EXPECT_EQ(details.asked_bytes, 41u);
  EXPECT_EQ(details.free_bytes, 40u);
  EXPECT_EQ(details.metadata.at(error::kDeviceKey), "3");
  EXPECT_EQ(refused.message(), "the view on device 3 needs 41 bytes, 40 are free");
  EXPECT_EQ(budget.free_bytes(), 40u);
  EXPECT_OK(budget.Reserve("the view", 40));
  EXPECT_THAT(budget.Reserve("another", ~uint64_t{0}),
              StatusIs(absl::StatusCode::kResourceExhausted));
}

// Each thread reserves two blocks, and memory suffices for one thread at a time: it gets both
// blocks or none.
TEST(DeviceBudget, ThreadsThatReserveAtOnceNeverHaveMoreThanThereIs) {
  constexpr int kThreads = 4, kRounds = 2'000;
  constexpr uint64_t kBlock = 30;
  DeviceBudget budget(0, 4 * kBlock - 1);
  const auto reserve_and_use = [&] {
    for (int round = 0; round < kRounds; ++round) {
      if (!budget.Reserve("two blocks", 2 * kBlock).ok()) continue;
      budget.Use("block", kBlock);
      budget.Use("block", kBlock);
      EXPECT_LE(budget.use().at("block"), budget.bytes());
      budget.Return("block", kBlock);
      budget.Return("block", kBlock);
    }
  };
  {
    std::vector<std::jthread> threads;
    threads.reserve(kThreads);
    for (int i = 0; i < kThreads; ++i) threads.emplace_back(reserve_and_use);
  }
  EXPECT_EQ(budget.free_bytes(), budget.bytes());
  EXPECT_EQ(budget.use().at("block"), 0u);
}

}  // namespace
}  // namespace latticed::testing
