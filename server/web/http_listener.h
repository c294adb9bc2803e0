// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A listening port whose connections go to one handler. Requests of those above the set's limit are
// answered 503 and closed, those far above it are closed without a word.
//
// Threads  safe
#ifndef LATTICED_SERVER_WEB_HTTP_LISTENER_H_
#define LATTICED_SERVER_WEB_HTTP_LISTENER_H_

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/base/options.h"
#include "server/web/connection_set.h"
#include "server/web/http_exchange.h"

namespace latticed::web {

// Of --tls-cert, --tls-key and --tls-client-ca; null where they are not given. kInvalidArgument.
[[nodiscard]] absl::StatusOr<std::unique_ptr<boost::asio::ssl::context>> MakeTlsContext(
    const Options& options);

class HttpListener : public std::enable_shared_from_this<HttpListener> {
 public:
  // Listens on `listen`, "host:port", for `flag`. The context, set and `tls` (may be null) outlive the
  // connections. kUnavailable for a port that cannot be had, kInvalidArgument for what is none.
  [[nodiscard]] static absl::StatusOr<std::shared_ptr<HttpListener>> Open(
      boost::asio::io_context& context, const std::string& flag, const std::string& listen,
      boost::asio::ssl::context* tls, ConnectionSet* connections, HttpTimeouts timeouts,
      HttpHandler handler);

  const std::string& address() const { return address_; }  // with the port that was taken
  void Close();

 private:
  HttpListener(boost::asio::io_context& context, boost::asio::ssl::context* tls,
               ConnectionSet* connections, HttpTimeouts timeouts, HttpHandler handler);
  absl::Status Bind(const std::string& host, const std::string& port);
  void Accept();
  void OnAccept(boost::asio::ip::tcp::socket socket);

  boost::asio::io_context& context_;
  boost::asio::ip::tcp::acceptor acceptor_;
  boost::asio::steady_timer retry_;
  boost::asio::ssl::context* const tls_;
  ConnectionSet* const connections_;
  const HttpTimeouts timeouts_;
  const HttpHandler handler_;
  std::string address_;
};

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_HTTP_LISTENER_H_
