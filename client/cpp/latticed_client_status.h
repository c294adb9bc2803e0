// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a server answers, as the one currency of errors: grpc::Status -> absl::Status, with the
// reason and field of its google.rpc details in error::DetailsOf.
#ifndef LATTICED_CLIENT_CPP_LATTICED_CLIENT_STATUS_H_
#define LATTICED_CLIENT_CPP_LATTICED_CLIENT_STATUS_H_

#include <functional>

#include "absl/status/status.h"
#include "google/rpc/status.pb.h"
#include "grpcpp/support/status.h"

namespace latticed::client {

[[nodiscard]] absl::Status FromGrpc(const grpc::Status& status);
// Of EditResult.status; OK for code 0.
[[nodiscard]] absl::Status FromRpc(const google::rpc::Status& status);

// Whether the same call may succeed if made again: CANCELLED (by a proxy), INTERNAL (a broken
// transport) and UNAVAILABLE.
[[nodiscard]] bool MayRetry(const absl::Status& status);

// Calls an idempotent function again after such an error, four times in all, waiting 100, 200, 400
// ms.
[[nodiscard]] absl::Status WithRetries(const std::function<absl::Status()>& call);

// When a broken stream is opened again: after the same errors, five times in a row, with pauses
// that double from 100 ms.
class Reopening {
 public:
  // Waits and returns OK where the stream is to be opened again, else why not.
  [[nodiscard]] absl::Status AfterBreak(const absl::Status& status);
  void Worked() { failures_in_a_row_ = 0; }

 private:
  int failures_in_a_row_ = 0;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICED_CLIENT_STATUS_H_
