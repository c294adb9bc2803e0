// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How an rpc ended, with all that the reply says of it: FromGrpc of status.h and
// the reply's latticed-request-id, by which the server's log has it.
//
// Threads  pure function
#ifndef LATTICED_CLIENT_CPP_LIBRARY_REPLY_H_
#define LATTICED_CLIENT_CPP_LIBRARY_REPLY_H_

#include "absl/status/status.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/status.h"

namespace latticed::client {

// The id is "request_id" of the metadata in error::DetailsOf; absent where no server answered. The
// rpc of `context` has finished.
[[nodiscard]] absl::Status FromGrpc(const grpc::Status& status, const grpc::ClientContext& context);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_REPLY_H_
