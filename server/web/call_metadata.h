// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// HTTP fields <-> metadata, deadline and status of an rpc.
//
// Threads  pure functions
#ifndef LATTICED_SERVER_WEB_CALL_METADATA_H_
#define LATTICED_SERVER_WEB_CALL_METADATA_H_

#include <grpcpp/support/status.h>

#include <string_view>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/web/generic_call.h"
#include "server/web/http_exchange.h"

namespace latticed::web {

// The fields that the server reads of an rpc's metadata. kInvalidArgument for a value that metadata
// cannot hold.
[[nodiscard]] absl::StatusOr<CallMetadata> ToMetadata(const HttpFields& fields);
// What the server adds to an answer: latticed-request-id, latticed-node.
[[nodiscard]] HttpFields ToFields(const CallMetadata& metadata);
// grpc-status, grpc-message (escaped as in gRPC over HTTP/2), grpc-status-details-bin.
[[nodiscard]] HttpFields StatusFields(const grpc::Status& status);
// Reads a grpc-timeout such as "100m": at most 8 digits and one of HMSmun. InfiniteFuture for an
// empty one. kInvalidArgument.
[[nodiscard]] absl::StatusOr<absl::Time> DeadlineOf(std::string_view timeout, absl::Time now);

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_CALL_METADATA_H_
