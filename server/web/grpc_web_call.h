// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A call of gRPC-Web (binary), of any rpc: frames in, frames out. No rpc is named here.
//
// A request may hold several messages, where the rpc takes several. grpc-timeout is the deadline.
// When the client goes away the rpc is cancelled. An error found here is sent as the server's own
// errors are: in the trailers, with details.
// Threads  on the connection's strand
#ifndef LATTICED_SERVER_WEB_GRPC_WEB_CALL_H_
#define LATTICED_SERVER_WEB_GRPC_WEB_CALL_H_

#include <memory>

#include "server/web/generic_call.h"
#include "server/web/http_exchange.h"
#include "server/web/request_guard.h"

namespace latticed::web {

// Answers a request to "/<service>/<method>". `guard` outlives the server's connections.
void RunGrpcWebCall(const ServerChannel& server, const RequestGuard& guard,
                    std::shared_ptr<HttpExchange> exchange);

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_GRPC_WEB_CALL_H_
