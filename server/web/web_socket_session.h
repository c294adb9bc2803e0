// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A connection after its upgrade to a WebSocket. It ends when the client is silent for too long and
// does not answer a ping.
//
// Threads  on its strand; Drain and Abort from anywhere
#ifndef LATTICED_SERVER_WEB_WEB_SOCKET_SESSION_H_
#define LATTICED_SERVER_WEB_WEB_SOCKET_SESSION_H_

#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <functional>
#include <memory>
#include <string>

#include "server/base/http_timeouts.h"
#include "server/web/connection_set.h"
#include "server/web/transport.h"
#include "server/web/web_socket.h"

namespace latticed::web {

using UpgradeRequest = beast::http::request<beast::http::string_body>;

// Answers the handshake and calls `opened`; ends the connection where the handshake fails.
void AcceptWebSocket(Transport transport, std::shared_ptr<ConnectionSet::Place> place,
                     const HttpTimeouts& timeouts, UpgradeRequest request, std::string subprotocol,
                     std::function<void(std::shared_ptr<WebSocket>)> opened);

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_WEB_SOCKET_SESSION_H_
