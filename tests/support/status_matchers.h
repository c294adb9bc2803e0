// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// IsOk(), StatusIs(code) and StatusIs(code, message matcher) for absl::Status and absl::StatusOr.
// Debian's abseil does not have them.
#ifndef LATTICED_TESTS_SUPPORT_STATUS_MATCHERS_H_
#define LATTICED_TESTS_SUPPORT_STATUS_MATCHERS_H_

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/status_macros.h"

namespace latticed::testing {

inline const absl::Status& ToStatus(const absl::Status& status) { return status; }
template <typename T>
const absl::Status& ToStatus(const absl::StatusOr<T>& result) {
  return result.status();
}

MATCHER(IsOk, "is OK") {
  *result_listener << ToStatus(arg).ToString();
  return ToStatus(arg).ok();
}
MATCHER_P(StatusIs, code, "has status " + absl::StatusCodeToString(code)) {
  *result_listener << ToStatus(arg).ToString();
  return ToStatus(arg).code() == code;
}
MATCHER_P2(StatusIs, code, message, "has status " + absl::StatusCodeToString(code)) {
  *result_listener << ToStatus(arg).ToString();
  return ToStatus(arg).code() == code &&
         ::testing::ExplainMatchResult(message, std::string(ToStatus(arg).message()),
                                       result_listener);
}

}  // namespace latticed::testing

#define ASSERT_OK(expression) ASSERT_THAT((expression), ::latticed::testing::IsOk())
#define EXPECT_OK(expression) EXPECT_THAT((expression), ::latticed::testing::IsOk())

// ASSERT_OK_AND_ASSIGN(const auto mesh, ReadObj(text)) assigns the value of a StatusOr.
#define ASSERT_OK_AND_ASSIGN(value, ...) \
  ASSERT_OK_AND_ASSIGN_AS(LATTICED_CONCATENATE(latticed_result_, __LINE__), value, __VA_ARGS__)
#define ASSERT_OK_AND_ASSIGN_AS(result, value, ...) \
  auto result = (__VA_ARGS__);                      \
  ASSERT_OK(result);                                \
  value = *std::move(result)

#endif  // LATTICED_TESTS_SUPPORT_STATUS_MATCHERS_H_
