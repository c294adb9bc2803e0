// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Converts errors of rpcs: grpc::Status -> absl::Status, with the reason and field of its google.rpc
// details in error::DetailsOf.
//
// Threads  pure functions, except that WithRetries sleeps
#ifndef LATTICED_CLIENT_CPP_LIBRARY_STATUS_H_
#define LATTICED_CLIENT_CPP_LIBRARY_STATUS_H_

#include <functional>
#include <stop_token>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "google/rpc/status.pb.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/status.h"

namespace latticed::client {

[[nodiscard]] absl::Status FromGrpc(const grpc::Status& status);
// The same for an rpc that has finished. If a server answered, the details' metadata also has
// "request_id", the request's id in the server's log.
[[nodiscard]] absl::Status FromGrpc(const grpc::Status& status, const grpc::ClientContext& context);
// Converts EditResult.status; OK for code 0.
[[nodiscard]] absl::Status FromRpc(const google::rpc::Status& status);

// kCancelled: the error of a call that would begin after a request to stop.
[[nodiscard]] absl::Status Stopped();

// Whether another attempt may succeed: after CANCELLED (by a proxy), INTERNAL (a broken transport),
// UNKNOWN (a proxy ended the stream without a status) and UNAVAILABLE.
[[nodiscard]] bool MayRetry(const absl::Status& status);

// Calls an idempotent function until it returns no error that MayRetry names, up to four times, with
// pauses of 100, 200 and 400 ms. After a request of `stop` it begins no further pause.
[[nodiscard]] absl::Status WithRetries(const std::stop_token& stop,
                                       const std::function<absl::Status()>& call);
// The pause after the given number of failures in a row (1 or more): 100 ms, doubled by each failure.
[[nodiscard]] absl::Duration PauseAfter(int failures);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_STATUS_H_
