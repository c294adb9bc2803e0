// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A poll returns the status of its check.
#include "core/base/stop_check.h"

#include <gtest/gtest.h>

#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;

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
