// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// SceneService.Deform over a WebSocket, for browsers, which cannot stream up.
//
//   GET /ws/latticed.v1.SceneService/Deform?latticed-scene=<id>
//   binary frames: up, a DeformRequest each; down, a SceneEvent each
//
// The client offers the subprotocol `latticed.v1`, which the server answers, and its token as
// `bearer.<base64url>`, since pages cannot set fields. latticed-request-id and traceparent may be in
// the query. The close code is 1000 for OK, otherwise 4000 + the code of the status, with its reason
// and message. A close by the client is a half-close: edits that it has sent still count.
// Threads  on the connection's strand
#ifndef LATTICED_SERVER_WEB_DEFORM_SOCKET_H_
#define LATTICED_SERVER_WEB_DEFORM_SOCKET_H_

#include <memory>

#include "server/web/generic_call.h"
#include "server/web/http_exchange.h"

namespace latticed::web {

inline constexpr std::string_view kDeformSocketPath = "/ws/latticed.v1.SceneService/Deform";

// Answers a request to kDeformSocketPath.
void OpenDeformSocket(const ServerChannel& server, const std::shared_ptr<HttpExchange>& exchange);

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_DEFORM_SOCKET_H_
