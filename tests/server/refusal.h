// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a refusal says to a client: code, reason, field, and a message that helps.
#ifndef LATTICED_TESTS_SERVER_REFUSAL_H_
#define LATTICED_TESTS_SERVER_REFUSAL_H_

#include <grpcpp/grpcpp.h>

#include <string>

#include "client/cpp/library/status.h"
#include "core/base/error.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {

struct Refusal {
  absl::StatusCode code = absl::StatusCode::kInvalidArgument;
  std::string reason;   // of ErrorInfo
  std::string field;    // of BadRequest; empty: it has none
  std::string message;  // part of it: the allowed range, or what is wrong
};

inline void ExpectRefusal(const absl::Status& status, const Refusal& refusal) {
  EXPECT_THAT(status, StatusIs(refusal.code, ::testing::HasSubstr(refusal.message)));
  const error::Details details = error::DetailsOf(status);
  EXPECT_EQ(details.reason, refusal.reason) << status;
  EXPECT_EQ(details.field, refusal.field) << status;
}

inline void ExpectRefusal(const grpc::Status& status, const Refusal& refusal) {
  ExpectRefusal(client::FromGrpc(status), refusal);
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_REFUSAL_H_
