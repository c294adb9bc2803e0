// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The one conversion of statuses into what clients see.
//
//   absl::Status + error::Details  ->  google.rpc.Status  ->  grpc::Status
//
// Details travel as ErrorInfo{domain "latticed", reason, metadata}, always; BadRequest (field
// path), QuotaFailure (bytes asked and free, also in the metadata as "asked_bytes" and
// "free_bytes") and RetryInfo where they apply. Messages are cut at 1 KiB, metadata and field paths
// before that: all of it is sent in HTTP/2 trailers, of which clients accept 8 KiB. The client library has
// the opposite conversion.
//
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_GRPC_STATUS_H_
#define LATTICED_SERVER_WIRE_GRPC_STATUS_H_

#include <grpcpp/support/status.h>

#include <string>

#include "absl/status/status.h"
#include "google/rpc/status.pb.h"

namespace latticed {

// For the end of an rpc.
[[nodiscard]] grpc::Status ToGrpcStatus(const absl::Status& status);
// For EditResult.status. OK is code 0 with nothing else.
[[nodiscard]] google::rpc::Status ToRpcStatus(const absl::Status& status);
// For Goaway.status.
[[nodiscard]] google::rpc::Status ToRpcStatus(const grpc::Status& status);
// The reason in a status; empty if it has none.
[[nodiscard]] std::string ReasonOf(const grpc::Status& status);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_GRPC_STATUS_H_
