// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A connection of HTTP/1.1. It serves its requests one after the other, each as an HttpExchange.
//
// A connection holds at most a head of 16 KiB, a piece of a body and what one Write sends, and that no
// longer than the timeouts allow.
// Threads  on its strand; Drain and Abort from anywhere
#ifndef LATTICED_SERVER_WEB_HTTP_CONNECTION_H_
#define LATTICED_SERVER_WEB_HTTP_CONNECTION_H_

#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <memory>

#include "server/base/options.h"
#include "server/web/connection_set.h"
#include "server/web/http_exchange.h"
#include "server/web/transport.h"

namespace latticed::web {

// A connection whose request asks for a WebSocket, before its handshake.
struct Upgraded {
  Transport transport;
  std::shared_ptr<ConnectionSet::Place> place;  // held as long as the connection
  HttpTimeouts timeouts;
  beast::http::request<beast::http::string_body> request;
};

// Serves until the client, the set or a timeout ends it. `handler` outlives it.
void ServeConnection(Transport transport, std::shared_ptr<ConnectionSet::Place> place,
                     const HttpTimeouts& timeouts, const HttpHandler& handler);

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_HTTP_CONNECTION_H_
