// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How often a poll asks, and that it passes on what it is told.
#include "core/base/stop_check.h"

#include <gtest/gtest.h>

#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;

constexpr size_t kStride = StopPoll::kStepsPerCheck;

TEST(StopPollTest, AsksAtOnceAndOncePerStride) {
  int asked = 0;
  const auto check = [&asked] {
    ++asked;
    return absl::OkStatus();
  };
  StopPoll poll(check);

  for (size_t i = 0; i < 3 * kStride; ++i) ASSERT_OK(poll.Step());

  EXPECT_EQ(asked, 3);
}

TEST(StopPollTest, ALargeStepIsAskedAbout) {
  int asked = 0;
  const auto check = [&asked] {
    ++asked;
    return absl::OkStatus();
  };
  StopPoll poll(check);
  ASSERT_OK(poll.Step());

  ASSERT_OK(poll.Step(kStride - 1));
  EXPECT_EQ(asked, 1);
  ASSERT_OK(poll.Step(2 * kStride));
  EXPECT_EQ(asked, 2);
}

TEST(StopPollTest, PassesOnWhatTheCheckSays) {
  const auto late = [] { return absl::DeadlineExceededError("late"); };
  const auto gone = [] { return absl::CancelledError("gone"); };

  EXPECT_THAT(StopPoll(late).Step(), StatusIs(absl::StatusCode::kDeadlineExceeded));
  EXPECT_THAT(StopPoll(gone).Step(), StatusIs(absl::StatusCode::kCancelled));
  EXPECT_OK(StopPoll(NeverStop).Step());
  EXPECT_TRUE(IsStopped(late()));
  EXPECT_TRUE(IsStopped(gone()));
  EXPECT_FALSE(IsStopped(absl::OkStatus()));
  EXPECT_FALSE(IsStopped(absl::ResourceExhaustedError("full")));
}

}  // namespace
}  // namespace latticed
