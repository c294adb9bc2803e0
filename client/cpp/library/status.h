// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Converts errors of rpcs: grpc::Status -> absl::Status, with the reason and field of its google.rpc
// details in error::DetailsOf.
//
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LIBRARY_STATUS_H_
#define LATTICED_CLIENT_CPP_LIBRARY_STATUS_H_

#include "absl/status/status.h"
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
// Converts Goaway.status, which was read from the rpc of `context`, in the same way as FromGrpc.
[[nodiscard]] absl::Status FromRpc(const google::rpc::Status& status,
                                   const grpc::ClientContext& context);

// kCancelled: the error of a call that would begin after a request to stop.
[[nodiscard]] absl::Status Stopped();

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_STATUS_H_
