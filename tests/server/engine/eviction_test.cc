// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/memory/eviction.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "server/engine/memory/memory_budget.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// A candidate of `bytes` that was last used at second `second`.
EvictionCandidate Used(uint64_t bytes, int second) {
  return {bytes, absl::UnixEpoch() + absl::Seconds(second)};
}

TEST(ChooseVictims, TheLeastRecentlyUsedGoFirstAndNoMoreThanAreNeeded) {
  const std::vector<EvictionCandidate> all{Used(10, 3), Used(10, 1), Used(10, 2)};

  EXPECT_THAT(ChooseVictims(all, 1), ElementsAre(1));
  EXPECT_THAT(ChooseVictims(all, 10), ElementsAre(1));
  EXPECT_THAT(ChooseVictims(all, 11), ElementsAre(1, 2));
  EXPECT_THAT(ChooseVictims(all, 30), ElementsAre(1, 2, 0));
}

TEST(ChooseVictims, NobodyIsEvictedForWhatCannotBeServed) {
  EXPECT_THAT(ChooseVictims(std::vector{Used(10, 1), Used(10, 2)}, 21), IsEmpty());
  EXPECT_THAT(ChooseVictims({}, 0), IsEmpty());
}

TEST(ChooseVictims, WhatIsInUseIsNeverEvictedAndOneGoesWhereTheNeedIsUnknown) {
  const std::vector<EvictionCandidate> all{Used(0, 1), Used(5, 2), Used(5, 3)};

  EXPECT_THAT(ChooseVictims(all, 0), ElementsAre(1));
  EXPECT_THAT(ChooseVictims(all, 10), ElementsAre(1, 2));
}

class MemoryBudgetEviction : public ::testing::Test {
 protected:
  // The evictor releases `held_`, which has 60 of the budget's 100 bytes.
  void SetUp() override {
    held_ = *budget_->Reserve("held", 60);
    budget_->SetEvictor([this](const MemoryShortage& shortage) {
      shortages_.push_back(shortage.bytes);
      const bool freed = held_.bytes() > 0;
      held_.Release();
      return freed;
    });
  }
  const std::shared_ptr<MemoryBudget> budget_ = std::make_shared<MemoryBudget>(100);
  MemoryReservation held_;
  std::vector<uint64_t> shortages_;
};

TEST_F(MemoryBudgetEviction, AReservationThatFitsEvictsNothing) {
  EXPECT_OK(budget_->Reserve("new", 40));
  EXPECT_THAT(shortages_, IsEmpty());
}

TEST_F(MemoryBudgetEviction, AReservationEvictsWhatIsMissing) {
  const auto reservation = budget_->Reserve("new", 70);

  ASSERT_OK(reservation);
  EXPECT_THAT(shortages_, ElementsAre(30));
  EXPECT_EQ(budget_->used_bytes(), 70u);
}

TEST_F(MemoryBudgetEviction, ARefusalSaysAskedAndFreeBytesAfterTheEviction) {
  const absl::Status refused = budget_->Reserve("new", 101).status();

  EXPECT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_EQ(error::DetailsOf(refused).asked_bytes, 101u);
  EXPECT_EQ(error::DetailsOf(refused).free_bytes, 100u);
}

TEST_F(MemoryBudgetEviction, TryResizeEvictsNothingAndChangesNothingWhereItIsRefused) {
  auto reservation = budget_->Reserve("new", 40);
  ASSERT_OK(reservation);

  EXPECT_THAT(reservation->TryResize("new", 41), StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_EQ(reservation->bytes(), 40u);
  EXPECT_THAT(shortages_, IsEmpty());
  EXPECT_OK(reservation->Resize("new", 41));
  EXPECT_EQ(held_.bytes(), 0u);
}

TEST_F(MemoryBudgetEviction, ACallThatADeviceRefusesIsMadeAgainAfterAnEviction) {
  int calls = 0;
  const absl::Status status = budget_->Admit([&]() -> absl::Status {
    if (++calls == 1) return error::OutOfDeviceMemory("the view", 0, 12, 5);
    return absl::OkStatus();
  });

  EXPECT_OK(status);
  EXPECT_EQ(calls, 2);
  EXPECT_THAT(shortages_, ElementsAre(7));
}

TEST_F(MemoryBudgetEviction, OtherRefusalsEvictNothing) {
  const absl::Status refused =
      budget_->Admit([] { return absl::Status(error::LimitExceeded("views", 8)); });

  EXPECT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_THAT(shortages_, IsEmpty());
}

}  // namespace
}  // namespace latticed::testing
