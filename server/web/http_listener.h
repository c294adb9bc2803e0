// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A listening port with one handler for its connections. Connections above the set's limit are answered
// 503 and closed; those far above it are closed at once.
//
// Threads  safe
#ifndef LATTICED_SERVER_WEB_HTTP_LISTENER_H_
#define LATTICED_SERVER_WEB_HTTP_LISTENER_H_

#include <boost/asio/ssl/context.hpp>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/base/options.h"
#include "server/net/tcp_listener.h"
#include "server/web/connection_set.h"
#include "server/web/http_exchange.h"

namespace latticed::web {

// Of --tls-cert, --tls-key and --tls-client-ca; null where they are not given. kInvalidArgument.
[[nodiscard]] absl::StatusOr<std::unique_ptr<boost::asio::ssl::context>> MakeTlsContext(
    const Options& options);

// Listens on `listen`, "host:port", for `flag`. The context, set and `tls` (may be null) outlive the
// connections and the listener. kUnavailable for a port that is taken, kInvalidArgument for an invalid
// address.
[[nodiscard]] absl::StatusOr<std::shared_ptr<TcpListener>> ListenForHttp(
    boost::asio::io_context& context, const std::string& flag, const std::string& listen,
    boost::asio::ssl::context* tls, ConnectionSet* connections, const HttpTimeouts& timeouts,
    const HttpHandler& handler);

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_HTTP_LISTENER_H_
