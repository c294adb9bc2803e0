// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a server answers, as the one currency of errors: grpc::Status -> absl::Status, with the
// reason and field of its google.rpc details in error::DetailsOf.
#ifndef LATTICED_CLIENT_CPP_LIBRARY_STATUS_H_
#define LATTICED_CLIENT_CPP_LIBRARY_STATUS_H_

#include <functional>
#include <stop_token>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "google/rpc/status.pb.h"
#include "grpcpp/support/status.h"

namespace latticed::client {

[[nodiscard]] absl::Status FromGrpc(const grpc::Status& status);
// Of EditResult.status; OK for code 0.
[[nodiscard]] absl::Status FromRpc(const google::rpc::Status& status);

// kCancelled: what a call that would begin after a request to stop fails with.
[[nodiscard]] absl::Status Stopped();

// Whether the same call may succeed if made again: CANCELLED (by a proxy), INTERNAL (a broken
// transport), UNKNOWN (a proxy ended the stream, and no server said why) and UNAVAILABLE.
[[nodiscard]] bool MayRetry(const absl::Status& status);

// Calls an idempotent function again after such an error, four times in all, waiting 100, 200, 400
// ms; not after a request of `stop`.
[[nodiscard]] absl::Status WithRetries(const std::stop_token& stop,
                                       const std::function<absl::Status()>& call);
// What to wait after so many failures in a row, from 1: 100 ms, doubled by each.
[[nodiscard]] absl::Duration PauseAfter(int failures);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_STATUS_H_
